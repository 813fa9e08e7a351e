"""Section 7: the contracting sheet of figure 3."""
