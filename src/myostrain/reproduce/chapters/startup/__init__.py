"""Section 5: the energy of an initial potential, and which bumps start a pulse."""
