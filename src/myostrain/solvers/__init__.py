"""Solvers: linear, chord Newton, Anderson, saddle points, continuation. They know no physics."""
