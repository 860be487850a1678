"""The colours of pictures, as red, green and blue from 0 to 255."""

Colour = tuple[int, int, int]

WATER_TOP, WATER_BOTTOM = (25, 92, 122), (13, 60, 92)
WATER, GRID, SHADOW, FLOW = (19, 76, 107), (32, 89, 119), (9, 44, 68), (126, 186, 205)
LAND, QUAY = (40, 52, 60), (150, 162, 168)
STONE, STONE_EDGE = (122, 130, 134), (78, 86, 92)
HEADER, INK, DIM, GOOD = (9, 34, 52), (240, 246, 248), (165, 196, 210), (130, 240, 170)
DECK, SEAM, FIN, KEEL = (240, 229, 205), (217, 202, 170), (122, 96, 62), (70, 54, 36)
WHITE, EDGE = (252, 252, 250), (8, 30, 46)
FAILED, MARK = (128, 136, 142), (20, 24, 28)
TEAM = (
    (240, 160, 20), (105, 195, 245), (240, 228, 66), (224, 130, 185), (40, 190, 140), (235, 105, 50)
)  # fmt: skip
"""The colours of Okabe and Ito, which colour-blind readers can tell apart, suited to blue water."""


def mix(colour: Colour, other: Colour, share: float) -> Colour:
    """Returns a colour between two, ``share`` of which (0 to 1) is the other."""
    r, g, b = (round(a + (z - a) * share) for a, z in zip(colour, other, strict=True))
    return r, g, b


def boat_colour(boat: int) -> Colour:
    """Returns the colour of a boat by its number."""
    return TEAM[boat % len(TEAM)]
