"""The code in the documents runs."""

import re
from dataclasses import replace
from pathlib import Path

import pytest

from asv_env.tasks import PUSH
from baselines import evaluate
from baselines.evaluate.results import read_csv
from baselines.reproduce.paper_page import TABLES, updated

ROOT = Path(__file__).parents[1]
BRIEF = replace(PUSH, time_limit=2.0)
"""The task of the episodes in the documents, in seconds."""
PAGES = [*sorted(ROOT.glob("*.md")), *sorted((ROOT / "docs").rglob("*.md"))]
SHORTER = {
    "2_000_000": "512",
    "episodes=20": "episodes=1, workers=0",
    "episodes=4": "episodes=1, workers=0",
    'suite="quick-v2"': 'suite="quick-v2", task=BRIEF',
    'task="push"': "task=BRIEF",
    "num_envs=64": "num_envs=4",
    '"push", 64': '"push", 4',
    "n_steps=128": "n_steps=16",
}
CODE = ("environment", "evaluation", "learning", "paper", "policies")
BLOCKS = [
    pytest.param(block, id=f"{name}-{number}")
    for name in ("README.md", *(f"docs/{page}.md" for page in CODE))
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
    exec(compile(block, "document", "exec"), {"BRIEF": BRIEF})


@pytest.mark.usefixtures("no_report")
def test_the_policy_of_the_page_meets_the_baselines_as_it_says(tmp_path, monkeypatch, capsys):
    page = (ROOT / "docs/policies.md").read_text()
    policy = re.search(r"```python\n(.*?)```", page, re.DOTALL)[1]
    command = re.search(r"python -m baselines.evaluate (.*mine:ToSlot)", page)[1]
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(tmp_path))
    Path("mine.py").write_text(policy)
    evaluate.main([*command.split(), "--episodes", "1", "--workers", "1"])
    assert "ToSlot" in capsys.readouterr().out
    assert len(read_csv(Path("runs/quick-v2-approach/episodes.csv"))) == 2 * 3


@pytest.mark.parametrize("page", PAGES, ids=[str(page.relative_to(ROOT)) for page in PAGES])
def test_links_to_files_lead_somewhere(page):
    text = page.read_text()
    links = re.findall(r"\]\((?!http)([^)#]+)", text) + re.findall(r'src="([^"]+)"', text)
    assert [link for link in links if not (page.parent / link).exists()] == []


def test_the_tables_of_the_paper_are_those_that_were_made():
    text, folder = (ROOT / "docs/paper.md").read_text(), ROOT / "docs/reproduction"
    assert text == updated(text, folder, list(TABLES)), (
        "run python -m baselines.reproduce --out docs/reproduction --page docs/paper.md"
    )
