"""Section 3, an open question: what a stretch current does on clamped bodies with active strain."""
