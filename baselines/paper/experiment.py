"""What the paper says of its experiment in the tank, Sec. IV-B."""

PAPER_GOAL = (0.55, -0.95, 0.1)
"""Pose of the goal seen from the vessel at closure, m, m, rad."""
PAPER_TRIALS = 12
PAPER_POSITION, PAPER_HEADING = (4.88, 1.8), (-0.26, 0.44)
"""Mean and standard deviation over the trials: smallest distance, cm; heading error then, rad."""
