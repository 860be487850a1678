"""Seeds of training, development and test, in disjoint ranges.

A policy is trained with the first, selected with the second, and compared with the third.
"""

TEST = range(0, 10**7)
DEVELOPMENT = range(10**8, 10**9)
TRAINING = range(10**9, 2**63)
RANGES = {"test": TEST, "development": DEVELOPMENT, "training": TRAINING}


def purpose(seed: int) -> str | None:
    """Returns the purpose of a seed, a key of ``RANGES``; None for one between the ranges."""
    return next((name for name, seeds in RANGES.items() if seed in seeds), None)


def check(seeds: range, wanted: str) -> None:
    """Refuses seeds that are not all for one purpose, ``wanted``, a key of ``RANGES``.

    Raises:
        ValueError: one of them is for another purpose.
    """
    allowed = RANGES[wanted]
    for seed in (seeds[0], seeds[-1]) if seeds else ():
        if seed not in allowed:
            raise ValueError(
                f"seed {seed} is not for {wanted}: use seeds from {allowed.start} "
                f"to {allowed.stop - 1}"
            )
