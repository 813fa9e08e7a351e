"""Settings of cases that several chapters name."""

#: The line or the sheet that does not deform, and the one that is held at first.
RIGID = "mechanics.imposed_stretch={value=1.0, until=inf}"
HELD = "mechanics.imposed_stretch={value=1.0, until=0.01}"
#: The balance J ∂v/∂t in place of ∂(Jv)/∂t.
ADVECTIVE = 'potential.balance="advective"'
