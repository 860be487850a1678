"""The evaluation script, from the command line to its files."""

import csv
import json

import numpy as np
import pytest

from asv_env import Simulation, make_params
from baselines import dubins, episodes, evaluate, film
from baselines.policy import Idle, Random
from baselines.scripted import ScriptedPolicy

POLICIES = ("scripted", "idle")
COLUMNS = [
    *("seed", "policy", "task", "scenario", "num_boats", "success"),
    *("position_error", "heading_error", "min_position_error", "heading_error_at_min"),
    *("time_to_closure", "closure_spread", "time_to_goal", "path_length_ratio"),
    *("effort", "collisions", "closure_lost", "episode_return"),
]
SHORT = ["--task", "push", "--episodes", "3", "--num-envs", "2"]


def run(*arguments):
    evaluate.main([str(argument) for argument in arguments])


def read(folder):
    with (folder / "episodes.csv").open() as file:
        return list(csv.DictReader(file))


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    folder = tmp_path_factory.mktemp("results")
    run(*SHORT, "--policies", "scripted", "idle", "--seed", 7, "--out", folder)
    return folder


def test_every_policy_meets_the_same_seeds(results):
    rows = read(results)
    seeds = {name: [int(r["seed"]) for r in rows if r["policy"] == name] for name in POLICIES}
    assert seeds == {"scripted": [7, 8, 9], "idle": [7, 8, 9]}


def test_columns_are_the_published_ones_and_empty_where_they_do_not_apply(results):
    rows = read(results)
    assert list(rows[0]) == COLUMNS
    idle = next(row for row in rows if row["policy"] == "idle")
    assert idle["success"] == "False"
    assert idle["time_to_goal"] == ""
    assert idle["time_to_closure"] == ""
    assert float(idle["position_error"]) == pytest.approx(np.hypot(0.55, 0.95))
    assert float(idle["heading_error"]) == pytest.approx(-0.1)
    assert float(idle["path_length_ratio"]) == 0.0


def test_summary_agrees_with_the_rows(results):
    summary = json.loads((results / "summary.json").read_text())["policies"]
    for name in POLICIES:
        rows = [row for row in read(results) if row["policy"] == name]
        assert summary[name]["success"] == np.mean([row["success"] == "True" for row in rows])
        returns = [float(row["episode_return"]) for row in rows]
        assert summary[name]["episode_return"]["mean"] == pytest.approx(np.mean(returns))
        low, high = summary[name]["success_interval"]
        assert low <= summary[name]["success"] <= high


def test_picture_is_written(results):
    assert (results / "trajectories.png").read_bytes().startswith(b"\x89PNG")


def test_nothing_is_overwritten_unless_asked(results, capsys):
    before = (results / "episodes.csv").read_bytes()
    with pytest.raises(SystemExit):
        run(*SHORT, "--policies", "idle", "--out", results)
    assert "--overwrite" in capsys.readouterr().err
    assert (results / "episodes.csv").read_bytes() == before


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--policies", "scriptd"], "Did you mean 'scripted'"),
        (["--task", "transprt"], "Did you mean 'transport'"),
        (["--scenario", "noissy"], "Did you mean 'noisy'"),
        (["--policies", "idle", "idle"], "once"),
        (["--episodes", "0"], "--episodes 0"),
        (["--num-envs", "-1"], "--num-envs -1"),
        (["--seed", "-1"], "--seed -1"),
        (["--goal", "9", "0", "0"], "arena"),
        (["--goal", "nan", "0", "0"], "finite"),
        (["--num-boats", "1"], "2 to 100"),
        (["--video", "film.avi"], ".mp4"),
    ],
)
def test_bad_options_are_refused_before_anything_runs(arguments, message, tmp_path, capsys):
    with pytest.raises(SystemExit):
        run(*arguments, "--out", tmp_path / "none")
    assert message in capsys.readouterr().err
    assert not (tmp_path / "none").exists()


@pytest.mark.parametrize("policy", [ScriptedPolicy, Random])
def test_an_episode_does_not_depend_on_the_batch(policy):
    params = make_params("transport", scenario="harsh", time_limit=12.0)
    seeds = range(5)

    def rows(num_envs):
        tracks = episodes.run(policy, "p", "harsh", params, seeds, num_envs)
        return sorted((track.episode for track in tracks), key=lambda row: row.seed)

    assert rows(1) == rows(3) == rows(8)


def test_track_ends_where_the_episode_does():
    params = make_params("push", time_limit=2.0, goal=(0.5, -0.5, 0.2))
    (track,) = episodes.run(Idle, "idle", "nominal", params, [3], 4)
    assert track.poses.shape == (11, 5, 3)
    np.testing.assert_array_equal(track.goal, (0.5, -0.5, 0.2))
    assert track.episode.position_error == pytest.approx(np.hypot(0.5, 0.5))


@pytest.mark.parametrize("side", ["+n", "-n"])
def test_path_length_is_compared_with_the_dubins_path_of_the_pushed_side(side):
    goal = (0.5, -0.6, 0.3)
    params = make_params("push", goal=goal, side=side, time_limit=8.0)
    (track,) = episodes.run(ScriptedPolicy, "s", "nominal", params, [0], 1)
    way = np.hypot(*np.diff(track.poses[:, 0, :2], axis=0).T).sum()
    mirrored = goal if side == "+n" else (0.5, 0.6, -0.3)
    shortest = float(dubins.length(np.array(mirrored), params.vessel.length / 2))
    assert track.episode.path_length_ratio == pytest.approx(way / shortest, rel=0.02)


def test_film_shows_the_episode_that_the_row_counts(tmp_path):
    params = make_params("push", goal=(0.0, -0.5, 0.0), time_limit=3.0)
    frames = list(film.frames(ScriptedPolicy, params, 0))
    assert len(frames) == 8 + film.LAST
    assert (frames[0] != frames[7]).any()


def test_random_policy_repeats_itself():
    simulation = Simulation(make_params(), 2)
    observation = simulation.reset(seeds=[1, 2])
    fresh = np.ones(2, dtype=bool)
    one, _ = Random(simulation.params).act(simulation.sensed, observation, None, fresh)
    two, _ = Random(simulation.params).act(simulation.sensed, observation, None, fresh)
    np.testing.assert_array_equal(one, two)
    assert (one[0] != one[1]).any()
