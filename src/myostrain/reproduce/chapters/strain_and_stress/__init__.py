"""Section 8, an open question: active strain against active stress, matched on one passive law."""
