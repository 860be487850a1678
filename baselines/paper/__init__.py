"""The paper's laws, and its controller."""

from baselines.paper.paper_policy import PaperPolicy

__all__ = ["PaperPolicy"]
