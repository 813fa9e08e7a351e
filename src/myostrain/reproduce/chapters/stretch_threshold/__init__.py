"""Section 5, an open question: whether deformation alone can excite, with a stretch current and without."""
