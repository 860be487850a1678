"""The code in the documents runs."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
SHORTER = {"1_000_000": "512", "num_envs=64": "num_envs=4", "n_steps=128": "n_steps=16"}
BLOCKS = [
    pytest.param(block, id=f"{name}-{number}")
    for name in ("README.md", "docs/learning.md")
    for number, block in enumerate(
        re.findall(r"```python\n(.*?)```", (ROOT / name).read_text(), re.DOTALL)
    )
]


@pytest.mark.filterwarnings("ignore:You have specified a mini-batch size")
@pytest.mark.parametrize("block", BLOCKS)
def test_code_block_runs(block, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for long, short in SHORTER.items():
        block = block.replace(long, short)
    exec(compile(block, "document", "exec"), {})


def test_links_to_files_lead_somewhere():
    for page in (ROOT / "README.md", *(ROOT / "docs").glob("*.md")):
        links = re.findall(r"\]\((?!http)([^)#]+)\)", page.read_text())
        assert [link for link in links if not (page.parent / link).exists()] == []
