"""Section 4.2: a pulse on the viscoelastic line."""
