"""The scripted policy in a hurry: whom the learner imitates first."""

from __future__ import annotations

from asv_env.params import EnvParams
from baselines.route import RouteGains, Router
from baselines.scripted import ScriptedPolicy

HASTY = RouteGains(radius=2.8, runout=0.25)
"""Narrower arcs with a shorter straight at their end than the scripted policy's own."""


def teacher(params: EnvParams) -> ScriptedPolicy:
    """For the worlds of these parameters."""
    return ScriptedPolicy(params, router=Router(params.hulls()[0], HASTY))
