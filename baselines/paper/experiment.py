"""What the paper reports of its experiment in the tank, Sec. IV-B."""

PAPER_GOAL = (0.55, -0.95, 0.1)
"""Goal pose relative to the vessel at closure, m, m, rad."""
PAPER_TRIALS = 12
"""Number of trials."""
PAPER_POSITION = (4.88, 1.8)
"""Mean and standard deviation over the trials of the smallest distance to the goal, cm."""
PAPER_HEADING = (-0.26, 0.44)
"""Mean and standard deviation over the trials of the heading error at that instant, rad."""
