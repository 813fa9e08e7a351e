"""Figure 1: a pulse on the rigid and on the contracting line."""
