"""The policy ``paper-tuned``: the laws of ``paper``, with free parameters that a search has found.

``python -m baselines.paper.tune`` writes the file from which they are read.
"""

import json
from pathlib import Path

from asv_env.params import EnvParams
from baselines.paper.paper_numbers import PaperGains
from baselines.paper.paper_policy import PaperPolicy

FILE = Path(__file__).with_name("tuned.json")


def tuned_gains() -> PaperGains:
    """Returns the free parameters that were found."""
    return PaperGains(**json.loads(FILE.read_text(encoding="utf-8"))["gains"])


def tuned_paper(params: EnvParams) -> PaperPolicy:
    """Returns the paper's controller with them."""
    return PaperPolicy(params, tuned_gains())
