"""Section 6, an open question: the pulse of figure 1 with human membranes, at once and with a delay."""
