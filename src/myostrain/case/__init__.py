"""A case file and what it takes to run it: sections, words, overrides, estimates of size."""
