"""What the command line asks for, as far as numbers depend on it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Job:
    """Options of a run.

    Attributes:
        seed: of the first episode; episode k has the seed plus k.
        trials: episodes of Fig. 10 (the paper's 12).
        episodes: of each condition of the tables.
    """

    seed: int
    trials: int
    episodes: int

    def seeds(self, number: int) -> range:
        """Seeds of the first ``number`` episodes."""
        return range(self.seed, self.seed + number)
