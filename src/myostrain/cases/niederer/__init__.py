"""Activation times that codes found for the N-version benchmark (docs/niederer.md)."""
