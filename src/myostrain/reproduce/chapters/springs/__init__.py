"""Section 1.1: active stress and active strain, of springs and at small strain."""
