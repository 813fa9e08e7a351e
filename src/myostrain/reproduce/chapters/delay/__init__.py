"""Concluding remarks, an open question: what delays the contraction, and lets it outlast the potential."""
