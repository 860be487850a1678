"""Measurements in turns: each subject lives in a process of its own and steps when it is asked to.

A process prints one line when it is ready. For every number of seconds that it then reads, it
steps for so long and prints what it measured, as JSON. This file is run by other environments'
interpreters too, and needs the standard library alone.
"""

import json
import sys
import time
from collections.abc import Callable

READY = "ready"


def serve(step: Callable[[], object], before: Callable[[str], None], after: Callable[[], float]):
    """Measures a subject whenever a line asks for it, until there are no more.

    Args:
        step: advances the subject by one step.
        before: is called with the second word of a line before its measurement.
        after: returns the time that the measurement spent in what is compared with, s, or 0.
    """
    print(READY, flush=True)
    for line in sys.stdin:
        seconds, *words = line.split()
        before(" ".join(words))
        steps, cpu, wall = 0, time.process_time(), time.perf_counter()
        while time.perf_counter() - wall < float(seconds):
            step()
            steps += 1
        wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
        print(json.dumps({"steps": steps, "wall": wall, "cpu": cpu, "bare": after()}), flush=True)
