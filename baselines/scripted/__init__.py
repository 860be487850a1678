"""The strong scripted policy."""

from baselines.scripted.scripted_policy import ScriptedPolicy

__all__ = ["ScriptedPolicy"]
