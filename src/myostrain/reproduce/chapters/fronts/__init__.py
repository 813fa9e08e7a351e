"""The start of section 4 and section 4.1: equilibria, and travelling fronts without recovery."""
