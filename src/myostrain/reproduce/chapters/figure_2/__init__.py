"""Figure 2: a weak bump, on the coupled line and on one that is held at first."""
