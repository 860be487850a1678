"""How NumPy reacts to numbers that are out of range, whatever its user has set."""

import numpy as np


def numerics() -> np.errstate:
    """Returns a context, or decorator, in which NumPy reacts as it does by default."""
    return np.errstate(divide="warn", over="warn", under="ignore", invalid="warn")
