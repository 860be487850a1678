"""The field's words: the unmistakable words of a private dialect are not used."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
FOLDERS = ("asv_env", "baselines", "train", "benchmarks", "docs", "tests", ".ci", ".github")
ENDINGS = {".py", ".md", ".js", ".css", ".html", ".jinja", ".yml", ""}
DIALECT = {
    "again": r"\banew\b",
    "resume, continue": r"\b(?:go|goes|going|went) on\b(?! board)",
    "reported, metadata": r"\btold\b|\bsays? of (?:it|them)sel(?:f|ves)\b",
    "compared with": r"\b(?:held|hold|holds) against\b",
    "unconstrained": r"\bat large\b",
    "adapter": r"\b(?:the|every|each|all|its) faces?\b[^d]|\b_face\b|\bFace\b",
    "condition": r"\barms\b|\b(?:an|each|every|one) arm\b",
    "policy": r"\b[Ee]ntrants?\b",
    "rollout starts": r"\b[Mm]idway\b|\bhand[- _]?over\b",
    "progress of the curriculum": r"\bwidening\b",
    "selection score": r"\bmerit\b",
    "holding position": r"\bberths?\b",
    "off path": r"\bastray\b",
    "collision avoidance": r"\bparting\b",
    "autopilot": r"\bloops? on board\b",
}
"""{the field's word: pattern of the other}."""
FILES = [
    path
    for path in [*ROOT.glob("*.md"), *(p for name in FOLDERS for p in (ROOT / name).rglob("*"))]
    if path.is_file() and path.suffix in ENDINGS and "__pycache__" not in path.parts
]


@pytest.mark.parametrize("word", DIALECT)
def test_the_word_of_the_field_is_used(word):
    found = [
        f"{name}:{number}: {line.strip()}"
        for path in FILES
        if (name := path.relative_to(ROOT).as_posix()) != "tests/test_words.py"
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1)
        if re.search(DIALECT[word], line)
    ]
    assert not found, f"say {word!r}:\n" + "\n".join(found)
