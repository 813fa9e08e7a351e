"""Section 1.1, an open question: whether active strain keeps the equations elliptic."""
