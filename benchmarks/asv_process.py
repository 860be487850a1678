"""Environments of this package, to be timed by ``throughput.py``.

``python benchmarks/asv_process.py SITUATION WORLDS THREADS CLOCK``; with ``PYTHONPATH`` set to
another version of the package it is that one that is timed. No worlds stand for ``gym.make``.
"""

import sys

from subjects import SITUATIONS, single_subject, vector_subject
from turns import serve

BARE = "bare"  #: word that asks for the time in ``cpSpaceStep``


def main(name: str, worlds: int, threads: int, clock: str) -> None:
    """Serves measurements of a situation."""
    situation = SITUATIONS[name]
    subject = vector_subject(situation, worlds, threads) if worlds else single_subject(situation)
    watches = []

    def before(word: str) -> None:
        if word == BARE and not watches:
            from bare import Watch  # versions without compiled code have no such thing

            watches.append(Watch(subject.simulation, clock))
        for watch in watches:
            watch.start(word == BARE)

    serve(subject.step, before, lambda: sum(watch.seconds for watch in watches))


if __name__ == "__main__":
    main(sys.argv[1], *map(int, sys.argv[2:4]), sys.argv[4])
