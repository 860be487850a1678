"""Scores of a search, kept in a file, so that a search that was stopped finds them there again."""

import json
from collections.abc import Callable
from pathlib import Path

from baselines.rollout import provenance


class ScoreLog:
    """Scores by what was scored.

    Args:
        path: file of the scores, one a line.
        modules: dotted names of modules on which they depend, besides those of all episodes.
    """

    def __init__(self, path: Path, *modules: str) -> None:
        self._path, self._code = path, provenance.code(*modules)
        lines = path.read_text(encoding="utf-8").splitlines() if path.exists() else []
        whole = (json.loads(line) for line in lines if line.endswith("}"))
        self._known = {line["key"]: line["score"] for line in whole}

    def score(self, what: str, compute: Callable[[], float]) -> float:
        """Returns the score of something, which is computed unless it is in the file."""
        key = f"{self._code} {what}"
        if key not in self._known:
            self._known[key] = compute()
            with self._path.open("a", encoding="utf-8") as file:
                file.write(json.dumps({"key": key, "score": self._known[key]}) + "\n")
        return self._known[key]
