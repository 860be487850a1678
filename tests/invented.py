"""Writes a report on invented episodes, and reads its page."""

import html.parser
import json
from types import SimpleNamespace

import numpy as np

from asv_env.tasks import TASKS
from baselines.evaluate.conditions import Condition, Suite
from baselines.evaluate.report import document, replay
from baselines.evaluate.results import Results
from baselines.evaluate.store import RunKey, Store
from baselines.evaluate.summary import summarise
from baselines.rollout.episodes import CAUSES, COLUMNS, Episode, PoseLog

ODD = "learned </script> & |$more$|"
SUITE = Suite(
    "tried-v1",
    "Episodes that were never run.",
    (
        Condition("calm", "goals over the plane"),
        Condition("rough & <windy>", "the same, scenario `noisy`", "calm", scenario="noisy"),
    ),
    seed=10,
    episodes=8,
)
POLICIES = {  # by name: fingerprints, one a training, and the share of successes
    "scripted": (["scripted"], 0.9),
    ODD: (["00112233445566aa", "00112233445566bb"], 0.5),
    "random": (["random"], 0.0),
}
DIES = 1  # boat whose thrusters die, in all episodes, after
DEATH = 6.0  # s


def invented_row(condition, policy, training, seed, share):
    rng = np.random.default_rng([seed, len(policy), training or 0])
    broken = policy != "scripted" and seed % 5 == 0
    success = not broken and bool(rng.random() < share)
    cause = "policy error" if broken else CAUSES[1 + seed % (len(CAUSES) - 1)]
    closed = success or cause not in ("policy error", "strayed", "no closure")
    away, ended = 0.02 + 0.2 * (not success), 20.0 + 10 * rng.random()
    values = dict.fromkeys(COLUMNS, 1.0) | {
        "seed": seed,
        "policy": policy,
        "training_seed": training,
        "condition": condition.name,
        "task": condition.task,
        "scenario": condition.scenario,
        "num_boats": condition.params.num_boats,
        "success": success,
        "cause": None if success else cause,
        "goal_x": rng.uniform(-1, 1),
        "goal_y": rng.uniform(-1, 1),
        "position_error": away * rng.uniform(0.5, 1.0),
        "min_position_error": away * rng.uniform(0.5, 1.0),
        "heading_error_at_min": rng.normal(0.0, 0.05),
        "time_to_closure": 0.4 * ended if closed else None,
        "closure_spread": 1.0 if closed else None,
        "time_to_goal": ended if success else None,
        "duration": round(ended, 1),
        "collisions": 2,
        "closure_lost": 0,
        "error": "ValueError: <no> | use" if broken else None,
    }
    values |= dict.fromkeys(TASKS[condition.task].not_applicable)
    return Episode(**values)


def invented_log(row):
    """Returns the log of boats on circles around a vessel that drifts."""
    rng = np.random.default_rng(row.seed)
    times = np.append(np.arange(0.0, row.duration, 0.2), row.duration)
    poses = np.empty((len(times), 1 + row.num_boats, 3))
    for body in range(1 + row.num_boats):
        radius = (1.0 if body else 0.1) * rng.uniform(0.5, 1.5)
        angle = rng.uniform(0, 6) + 0.2 * times * (1 if len(row.policy) % 2 else -1)
        poses[:, body] = np.stack(
            [radius * np.cos(angle), radius * np.sin(angle), (angle + 4) % (2 * np.pi) - np.pi], -1
        )
    failed = np.full(row.num_boats, np.inf)
    failed[DIES] = DEATH
    goal = np.array([row.goal_x or 0.0, row.goal_y or 0.0, 0.3])
    return PoseLog(row, poses, goal, failed, np.zeros((0, 5)), np.ones(len(failed)))


def report(folder, suite=SUITE, policies=POLICIES, replays=3):
    """Writes a report on invented episodes, and returns it with all that it was made from."""
    rows = {
        (condition.name, name): [
            [
                invented_row(condition, name, number if len(prints) > 1 else None, seed, share)
                for seed in suite.seeds
            ]
            for number in range(len(prints))
        ]
        for condition in suite.conditions
        for name, (prints, share) in policies.items()
    }
    results = Results(suite, tuple(policies), rows)
    prints = {name: prints for name, (prints, _) in policies.items()}
    provenance = {
        "set of episodes": "feedfeedfeedfeed",
        "state of the code": "c0dec0dec0dec0de",
        "set of libraries": {"numpy": "2.0"},
    }
    store = Store(folder, {}, prints, replace=False)
    for (condition, policy), trainings in rows.items():
        for number, training in enumerate(trainings):
            for row in training:
                store.add(RunKey(condition, policy, number), invented_log(row))
    summary = {
        "suite": suite.name,
        "about": suite.about,
        "seeds": [suite.seeds[0], suite.seeds[-1]],
        "provenance": provenance,
        "policies": prints,
        **summarise(results),
    }
    page, markdown = document.write(folder, results, summary, store, replays)
    return SimpleNamespace(
        page=page, html=page.read_text(), markdown=markdown.read_text(), results=results,
        summary=summary, store=store, cast=replay.find(results, prints),
    )  # fmt: skip


class Page(html.parser.HTMLParser):
    """The content of a page; raises an error where tags do not match."""

    VOID = {"meta", "link", "input", "br"}

    def __init__(self, text):
        super().__init__()
        self.open, self.ids, self.links, self.cells, self.data = [], [], [], [], {}
        self.tags, self.text = [], ""
        self.feed(text)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag, attributes):
        found = dict(attributes)
        self.tags.append((tag, found))
        self.ids += [found["id"]] if "id" in found else []
        self.links += [found[k] for k in ("href", "src", "xlink:href") if k in found]
        if tag in ("td", "th"):
            self.cells.append("")
        if tag not in self.VOID:
            self.open.append((tag, found))

    def handle_startendtag(self, tag, attributes):
        self.handle_starttag(tag, attributes)
        self.handle_endtag(tag)

    def handle_endtag(self, tag):
        assert self.open
        assert self.open.pop()[0] == tag

    def handle_data(self, text):
        tags = [tag for tag, _ in self.open]
        self.text += text if "script" not in tags else ""
        if "td" in tags or "th" in tags:
            self.cells[-1] += text
        elif tags and tags[-1] == "script" and "type" in self.open[-1][1]:
            self.data[self.open[-1][1].get("data-condition", "world")] = json.loads(text)
