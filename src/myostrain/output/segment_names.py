"""What the 17 segments of a left ventricle are called (Cerqueira et al., Circulation 105 (2002) 539)."""

#: Walls of the basal and the middle ring, anticlockwise seen from the apex with the septum at the left.
_WALLS = ("anterior", "anteroseptal", "inferoseptal", "inferior", "inferolateral", "anterolateral")

#: By number, from 1.
NAMES = (
    *(f"{ring} {wall}" for ring in ("basal", "mid") for wall in _WALLS),
    *(f"apical {wall}" for wall in ("anterior", "septal", "inferior", "lateral")),
    "apex",
)

#: How many there are.
COUNT = len(NAMES)
