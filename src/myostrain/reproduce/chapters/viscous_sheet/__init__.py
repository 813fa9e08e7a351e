"""The viscous sheet: the delay and the longer mechanical wave that section 8 announces."""
