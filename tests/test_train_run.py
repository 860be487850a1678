"""``python -m train``: what a run leaves in its folder, and how it is stopped and resumed."""

import json
import os
import shutil
import signal
import subprocess
import sys
import time
import types
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from train_helpers import actor_of, layers_of, same, timesteps, tiny, train, words

from asv_env import Simulation, make_params
from asv_env.sensing import observation
from baselines import evaluate
from baselines.evaluate.results import read_csv
from baselines.learned import policy_file
from baselines.learned.sb3_policy import Sb3Policy
from train import actors, evaluation, keep_best
from train.run import Run
from train.sb3 import export
from train.sb3.training import Callback

ROOT = Path(__file__).parents[1]


def content(folder):
    return {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def test_a_run_leaves_its_files(trained):
    assert {path.name for path in trained.iterdir()} == {
        *("config.json", "checkpoint.zip", "curve.csv", "best.npz", "best.zip", "policy.npz"),
        *("tensorboard", ".lock"),
    }
    config = json.loads((trained / "config.json").read_text())
    assert config["options"]["worlds"]["num_envs"] == 8
    assert config["observation_version"] == observation.VERSION
    assert {"code", "revision", "libraries", "python"} <= config.keys()
    assert list((trained / "tensorboard").iterdir())


def test_a_run_that_has_come_to_its_end_is_left_as_it_is(trained):
    before = content(trained)
    train(trained)
    assert content(trained) == before


def test_the_curve_has_a_row_for_each_evaluation(trained):
    rows = np.genfromtxt(trained / "curve.csv", delimiter=",", names=True, dtype=None)
    assert rows["timesteps"].tolist() == [0, 1024, 2048]
    assert (np.diff(rows["seconds"]) > 0).all()


def test_the_policy_file_acts_as_the_model_does(trained):
    params = make_params("push")
    saved = Sb3Policy(trained / "best.zip", params)
    policy = policy_file.load(trained / "best.npz", params)
    simulation = Simulation(params, 8)
    seen, fresh = simulation.reset(seeds=list(range(8))), np.ones(8, dtype=bool)
    for _ in range(20):
        action = policy.forward(seen)
        wanted, _ = saved.act(simulation.sensed, seen, None, fresh)
        np.testing.assert_allclose(action, wanted, atol=1e-5)
        assert np.abs(action).max() > 1e-3
        seen = simulation.step(action).observation


def test_export_writes_the_best_policy_and_refuses_another(trained, tmp_path, capsys):
    file = tmp_path / "mine.npz"
    export.main([str(trained), str(file)])
    assert same(layers_of(file), layers_of(trained / "best.npz"))
    assert "the same to" in capsys.readouterr().out
    with pytest.raises(SystemExit, match="exists"):
        export.main([str(trained), str(file)])
    other = tmp_path / "other"
    shutil.copytree(trained, other)
    layers, *rest = policy_file.read(other / "best.npz")
    moved = [(weight + 0.01, bias) for weight, bias in layers]
    policy_file.save(other / "best.npz", moved, *rest)
    with pytest.raises(SystemExit, match="differ by up to"):
        export.main([str(other), str(tmp_path / "no.npz")])
    assert not (tmp_path / "no.npz").exists()


def test_what_was_learned_takes_part_in_the_comparison(trained, tmp_path, no_report):
    words = f"scripted one={trained / 'best.npz'}"
    options = f"--task push --episodes 2 --workers 0 --out {tmp_path / 'out'}"
    evaluate.main(["--policies", *words.split(), *options.split()])
    assert [row.policy for row in read_csv(tmp_path / "out/episodes.csv")].count("one") == 2


# ------------------------------------------------------------------ stopping and resuming


def test_a_run_that_is_killed_is_resumed_to_the_bit(trained, tmp_path):
    folder = tmp_path / "run"
    command = [sys.executable, "-m", "train", *words("--out", folder)]
    variables = {**os.environ, "PYTHONPATH": f"{ROOT}{os.pathsep}{ROOT / 'tests'}"}
    process = subprocess.Popen(command, cwd=ROOT, env=variables, stderr=subprocess.DEVNULL)
    try:
        while len(timesteps(folder / "curve.csv")) < 2:
            assert process.poll() is None
            time.sleep(0.02)
    finally:
        process.send_signal(signal.SIGKILL)
        process.wait()
    assert len(timesteps(folder / "curve.csv")) < 3
    train(folder)
    assert timesteps(folder / "curve.csv") == [0, 1024, 2048]
    assert same(actor_of(folder), actor_of(trained))


@pytest.mark.parametrize("steps", [5, 20])
def test_a_run_that_is_interrupted_is_resumed_to_the_bit(steps, trained, tmp_path, monkeypatch):
    """After an evaluation without a checkpoint of its own, and after a checkpoint."""
    folder, left = tmp_path / "run", iter(range(steps))

    def interrupted(self):
        if next(left, None) is None:
            raise KeyboardInterrupt
        return True

    monkeypatch.setattr(Callback, "_on_step", interrupted)
    with pytest.raises(SystemExit, match="resumes from the last"):
        train(folder)
    monkeypatch.undo()
    train(folder)
    assert timesteps(folder / "curve.csv") == [0, 1024, 2048]
    assert same(actor_of(folder), actor_of(trained))


def test_resuming_with_other_code_is_noted(trained, tmp_path, capsys):
    folder = tmp_path / "run"
    shutil.copytree(trained, folder)
    file = folder / "config.json"
    config = json.loads(file.read_text())
    now = config["code"]
    file.write_text(json.dumps(config | {"code": "old"}))
    train(folder)
    assert "resumed_with" not in json.loads(file.read_text())  # it has come to its end
    for _ in range(2):
        (folder / "curve.csv").unlink()
        train(folder)
    assert capsys.readouterr().err.count("resumed with other code") == 1
    config = json.loads(file.read_text())
    assert config["code"] == "old"
    assert [part["code"] for part in config["resumed_with"]] == [now]


def test_a_run_without_a_checkpoint_is_started_again(tmp_path):
    Run(tiny(out=tmp_path / "run")).open()
    Run(tiny(out=tmp_path / "run", ppo={"gamma": 0.5})).open()
    config = json.loads((tmp_path / "run/config.json").read_text())
    assert config["options"]["ppo"]["gamma"] == 0.5


def test_overwriting_starts_again(trained, tmp_path):
    folder = tmp_path / "run"
    shutil.copytree(trained, folder)
    train(folder, "--overwrite", "--total-timesteps", "512")
    assert timesteps(folder / "curve.csv") == [0, 512]


# ------------------------------------------------------------------ files and scores


def test_where_the_curve_has_a_row_there_is_a_policy(trained, tmp_path, monkeypatch):
    config = tiny(out=tmp_path / "run")
    made = Run(config)
    made.open()
    layers = actor_of(trained)
    scores = evaluation.evaluate(layers, made.metadata, config, 1, 2.0)
    keep_best.keep(made, layers, scores, best=True)
    assert timesteps(made.curve) == [1]

    def fails(*_):
        raise OSError("full")

    monkeypatch.setattr(policy_file, "save", fails)
    with pytest.raises(OSError, match="full"):
        keep_best.keep(made, layers, [replace(scores[0], timesteps=2)], best=False)
    assert timesteps(made.curve) == [1]


@pytest.mark.filterwarnings("ignore:invalid value")
def test_a_policy_that_fails_in_evaluation_is_a_training_that_diverged(trained):
    config = tiny()
    for wrong in (np.nan, np.inf):
        layers = [(weight.copy(), bias.copy()) for weight, bias in actor_of(trained)]
        layers[0][0][...] = wrong
        with pytest.raises(ValueError, match=r"diverged, its policy fails after 7 .*not finite"):
            evaluation.evaluate(layers, Run(config).metadata, config, 7, 2.0)


@pytest.mark.parametrize("wrong", [np.nan, np.inf, 1.0])
def test_actions_that_differ_or_are_no_numbers_are_named(wrong):
    policy = types.SimpleNamespace(forward=lambda seen: seen + np.float32(wrong))
    with pytest.raises(ValueError, match="differ by up to"):
        actors.difference(policy, np.zeros((3, 2), np.float32), np.zeros((3, 2), np.float32))


def test_a_score_counts_failures_with_twice_the_time_limit():
    params = make_params("push")
    rows = [
        types.SimpleNamespace(success=done, duration=time, position_error=0.01, heading_error=-0.1)
        for done, time in ((True, 20.0), (True, 40.0), (False, 120.0))
    ]
    score = evaluation.score(rows, params, "noisy", 5, 1.0)
    assert score.success == pytest.approx(2 / 3)
    assert score.median_time == 30.0
    assert score.penalised_time == pytest.approx((20 + 40 + 240) / 3)
    assert score.heading_error == 0.1


def test_a_tracker_hears_of_the_run(monkeypatch, tmp_path):
    heard = {}

    @contextmanager
    def init(**options):
        heard.update(options)
        yield
        heard.update(finished=True)

    monkeypatch.setitem(sys.modules, "wandb", types.SimpleNamespace(init=init))
    train(tmp_path / "run", "--track", "--total-timesteps", "512")
    assert heard["config"]["worlds"]["num_envs"] == 8
    assert heard["sync_tensorboard"]
    assert heard["finished"]
    assert heard["id"] == Run(tiny(out=tmp_path / "run")).recorded("id")  # of a resumed run too
    assert heard["resume"] == "allow"
