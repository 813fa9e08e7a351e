"""Pointwise models: written once as NumPy functions, traced, differentiated, compiled, fused over nodes."""

from myostrain.pointwise.differentiation import derivative
from myostrain.pointwise.divisions import quotient_of_factors
from myostrain.pointwise.expressions import Expression, Graph, Untraceable
from myostrain.pointwise.program import Program
from myostrain.pointwise.time_loop import TimeLoop

__all__ = ["Expression", "Graph", "Program", "TimeLoop", "Untraceable", "derivative", "quotient_of_factors"]
