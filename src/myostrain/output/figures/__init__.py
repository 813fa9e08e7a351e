"""Pictures of result folders, one kind a file."""

from myostrain.output.figures.draw import draw

__all__ = ["draw"]
