"""Policies that do something wrong; named on the command line by tests."""

import os

import numpy as np

from baselines.policy import Idle


def turning_right(sensed):
    """(W,) worlds whose goal lies ahead of the vessel."""
    return sensed.goal[:, 0] > 0


class RaisesNow(Idle):
    """Raises wherever a world has a goal to the right and twenty ticks have passed."""

    def act(self, sensed, observation, memory, fresh):
        if (turning_right(sensed) & (sensed.tick == 20)).any():
            raise ArithmeticError("tired")
        return super().act(sensed, observation, memory, fresh)


class GivesNan(Idle):
    """Gives NaN in the same worlds."""

    def act(self, sensed, observation, memory, fresh):
        action, memory = super().act(sensed, observation, memory, fresh)
        action[turning_right(sensed) & (sensed.tick == 20), 1] = np.nan
        return action, memory


class WrongShape(Idle):
    """One action for the whole team."""

    def act(self, sensed, observation, memory, fresh):
        return np.zeros((len(fresh), 2)), memory


class Picky(Idle):
    """Refuses all tasks but one."""

    def __init__(self, params):
        if params.task.name != "approach":
            raise ValueError("I only play approach")


class NoPolicy:
    """Cannot act."""

    def __init__(self, params):
        pass


class OldStyle:
    """Wants less than it gets."""

    def __init__(self, params):
        pass

    def act(self, observation):
        return np.zeros(1)


class OnlyActs(Idle):
    """Forgets to return its memory."""

    def act(self, sensed, observation, memory, fresh):
        return super().act(sensed, observation, memory, fresh)[0]


class Unmade:
    """Cannot be made."""

    def __init__(self, params):
        raise AttributeError("nothing")


class Exits(Idle):
    """Ends its process, as a crash of a library does."""

    def act(self, *arguments):
        os._exit(7)
