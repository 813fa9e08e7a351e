"""The command line: thin, over the public functions."""

from myostrain.cli import cells, drawing, studies
from myostrain.cli.commands import _load_engine, app, main

__all__ = ["_load_engine", "app", "cells", "drawing", "main", "studies"]
