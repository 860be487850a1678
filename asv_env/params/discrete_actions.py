"""The actions of ``action_mode="discrete"``: numbers that stand for tracking actions."""

import itertools

SPEEDS = (0.0, 0.5, 1.0, -0.5)  #: forward speeds, full speeds
TURNS = (0.0, 1.0, -1.0)  #: yaw rates, full yaw rates; positive to port
DISCRETE_ACTIONS = tuple(itertools.product(SPEEDS, TURNS))
"""Tracking actions (speed, yaw rate) by number; 0 is to stop."""
