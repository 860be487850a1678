"""What goes wrong while a policy trains: full disks, damaged files, signals, a second run."""

import base64
import json
import pickle
import shutil
import signal
import threading
import zipfile

import numpy as np
import pytest
from helpers import no_larger_than
from hypothesis import given, settings
from hypothesis import strategies as st
from train_helpers import actor_of, refusal, same, timesteps, tiny, train, words

from baselines.rollout.lock import locked
from train import evaluation
from train.__main__ import main
from train.config import parse
from train.run import Run
from train.sb3.ppo import Learner
from train.sb3.training import Callback
from train.sb3.vec_env import TrainingVecEnv


def contents(folder):
    """Bytes of the files of a run that a training reads or hands out."""
    names = ("config.json", "checkpoint.zip", "curve.csv", "best.npz", "best.zip", "policy.npz")
    return {name: (folder / name).read_bytes() for name in names}


@pytest.fixture
def folder(trained, tmp_path):
    shutil.copytree(trained, tmp_path / "run")
    return tmp_path / "run"


@pytest.fixture
def half(tmp_path_factory, trained):
    """A run that was stopped after its second evaluation, and has a checkpoint."""
    folder, left = tmp_path_factory.mktemp("half") / "run", iter(range(40))

    def interrupted(self):
        if next(left, None) is None:
            raise KeyboardInterrupt
        return True

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Callback, "_on_step", interrupted)
        with pytest.raises(SystemExit):
            train(folder)
    assert timesteps(folder / "curve.csv") == [0, 1024]
    return folder


# ------------------------------------------------------------------ two runs, threads, signals


@pytest.mark.parametrize("option", [[], ["--overwrite"]])
def test_a_folder_in_use_is_left_as_it_is(option, folder):
    before = contents(folder)
    with locked(folder):
        assert f"{folder} is in use by another run" in refusal("--out", folder, *option)
    assert contents(folder) == before


def test_an_empty_folder_in_use_is_not_taken_for_that_of_something_else(tmp_path):
    with locked(tmp_path / "run"):
        assert "in use by another run" in refusal("--out", tmp_path / "run")
    Run(tiny(out=tmp_path / "run")).open()


def test_a_run_that_is_refused_gives_the_folder_back(folder):
    assert "ppo.gamma was" in refusal("--out", folder, "--gamma", 0.9)
    with locked(folder):
        pass


def test_a_training_runs_in_a_thread(tmp_path, trained):
    folder, thread = tmp_path / "run", None
    thread = threading.Thread(target=main, args=(words("--out", folder),))
    thread.start()
    thread.join()
    assert timesteps(folder / "curve.csv") == [0, 1024, 2048]
    assert same(actor_of(folder), actor_of(trained))


def test_a_request_to_terminate_ends_it_in_one_line_and_it_can_be_resumed(
    trained, tmp_path, monkeypatch
):
    def terminated(self):
        signal.raise_signal(signal.SIGTERM)
        return True

    folder = tmp_path / "run"
    monkeypatch.setattr(Callback, "_on_step", terminated)
    with pytest.raises(SystemExit) as stopped:
        train(folder)
    assert stopped.value.code.startswith("python -m train: stopped; the same command")
    assert "\n" not in stopped.value.code
    assert not list(folder.glob(".part-*"))
    monkeypatch.undo()
    train(folder)
    assert same(actor_of(folder), actor_of(trained))


def test_the_users_handler_of_signals_is_put_back(tmp_path):
    before = signal.getsignal(signal.SIGTERM), signal.getsignal(signal.SIGINT)
    train(tmp_path / "run", "--total-timesteps", 512)
    assert before == (signal.getsignal(signal.SIGTERM), signal.getsignal(signal.SIGINT))


# ------------------------------------------------------------------ full disks


@pytest.mark.parametrize("size", [0, 10_000, 40_000])
def test_on_a_full_disk_it_ends_in_one_line_and_can_be_resumed(size, half, trained):
    before = contents(half)
    with no_larger_than(size):
        message = refusal("--out", half)
    assert "free space and give the same command" in message
    assert str(half) in message
    after = contents(half)
    assert after["checkpoint.zip"] == before["checkpoint.zip"]
    assert all(len(after[name]) for name in after)
    train(half)
    assert timesteps(half / "curve.csv") == [0, 1024, 2048]
    assert same(actor_of(half), actor_of(trained))


# ------------------------------------------------------------------ damaged files


@settings(max_examples=25)
@given(data=st.data())
def test_a_damaged_checkpoint_is_named_or_gives_what_was_saved(data, trained, tmp_path_factory):
    old = (trained / "checkpoint.zip").read_bytes()
    at = data.draw(st.integers(0, len(old) - 1) | st.integers(len(old) - 500, len(old) - 1))
    length = data.draw(st.integers(1, 5000))
    changed = {
        "cut": old[:at],
        "zero": old[:at] + bytes(length) + old[at + length :],
        "flip": old[:at] + bytes([old[at] ^ data.draw(st.integers(1, 255))]) + old[at + 1 :],
    }[data.draw(st.sampled_from(["cut", "zero", "flip"]))]
    file, config = tmp_path_factory.mktemp("damaged") / "checkpoint.zip", tiny()
    file.write_bytes(changed)
    worlds = TrainingVecEnv(config)
    try:
        learner = Learner.resume(config, worlds, file)
    except ValueError as error:
        said = str(error)
        assert said.startswith(f"{file} cannot be read (")
        assert "--overwrite" in said
        assert "\n" not in said
    else:
        good = Learner.resume(config, worlds, trained / "checkpoint.zip")
        for name, weights in good.policy.state_dict().items():
            assert weights.equal(learner.policy.state_dict()[name])
        assert learner.num_timesteps == good.num_timesteps == 2048


class Marker:
    """An object that creates a file when it is unpickled."""

    def __init__(self, path):
        self.path = path

    def __reduce__(self):
        return open, (str(self.path), "w")


def test_nothing_of_a_checkpoint_is_unpickled(half, trained, tmp_path):
    evil = base64.b64encode(pickle.dumps(Marker(tmp_path / "mark"))).decode()
    file = half / "checkpoint.zip"
    shutil.move(file, tmp_path / "old.zip")
    with zipfile.ZipFile(tmp_path / "old.zip") as old, zipfile.ZipFile(file, "w") as new:
        for name in old.namelist():
            content = old.read(name)
            if name == "data":
                fields = json.loads(content)
                fields["config"] = {":type:": "x", ":serialized:": evil}
                content = json.dumps(fields).encode()
            new.writestr(name, content)
    train(half)
    assert not (tmp_path / "mark").exists()
    assert same(actor_of(half), actor_of(trained))


def test_a_damaged_checkpoint_can_be_overwritten(folder):
    (folder / "curve.csv").unlink()  # so that it is not at its end
    (folder / "checkpoint.zip").write_bytes(b"PK half")
    before = contents_but_curve(folder)
    assert "checkpoint.zip cannot be read" in refusal("--out", folder)
    assert contents_but_curve(folder) == before
    train(folder, "--overwrite", "--total-timesteps", 512)
    assert timesteps(folder / "curve.csv") == [0, 512]


def contents_but_curve(folder):
    return {path.name: path.read_bytes() for path in folder.glob("*.*") if path.is_file()}


@pytest.mark.parametrize("text", [None, "null", "\xff\xfe"])
def test_a_run_whose_config_is_damaged_is_named_and_replaced_when_asked(text, folder):
    file = folder / "config.json"
    file.unlink()
    if text is not None:
        file.write_bytes(text.encode("latin-1"))
    message = refusal("--out", folder)
    assert "config.json is missing or damaged: begin again with --overwrite" in message
    train(folder, "--overwrite", "--total-timesteps", 512)
    assert timesteps(folder / "curve.csv") == [0, 512]


def test_files_of_others_beside_a_damaged_config_are_not_overwritten(folder):
    (folder / "config.json").write_text("{")
    (folder / "thesis.tex").write_text("precious")
    assert "something else" in refusal("--out", folder, "--overwrite")
    assert (folder / "thesis.tex").read_text() == "precious"


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda text: text[:-1], "its last line is torn"),
        (lambda text: text.replace("noisy,2", "noisy,two", 1), "two"),
        (lambda text: text.replace("success", "delivered"), "its columns must be timesteps"),
        (lambda text: text + "4096,1.0\n", "no learning curve"),
        (lambda text: "\0" + text, "its columns must be"),
        (lambda text: text + "1,2,3,4,5,6,7,8,9,10,11,12\n", "no learning curve"),
        (lambda text: text.replace(",4,noisy,", f",{10**20},noisy,"), "no learning curve"),
    ],
)
def test_a_damaged_curve_is_named(change, words, folder):
    file = folder / "curve.csv"
    file.write_text(change(file.read_text()))
    assert words in refusal("--out", folder)
    with pytest.raises(ValueError, match=r"curve\.csv is no learning curve .*: remove it, or"):
        evaluation.read_curve(file)


# ------------------------------------------------------------------ numbers


def test_a_training_that_diverges_says_so_and_keeps_the_policy_of_before(tmp_path, monkeypatch):
    def diverge(self):
        with np.errstate(all="ignore"):
            self.policy.log_std.data.fill_(float("nan"))

    monkeypatch.setattr("stable_baselines3.PPO.train", diverge)
    message = refusal("--out", tmp_path / "run")
    assert "the training has diverged after 512 timesteps" in message
    assert np.isfinite(actor_of(tmp_path / "run")[0][0]).all()


def test_a_home_folder_is_expanded(tmp_path, monkeypatch):
    monkeypatch.setenv("HOME", str(tmp_path))
    config = parse(words("--out=~/x", "--init-from=~/a.npz", "--imitation.rounds=0"))
    assert (config.folder, config.init_from) == (tmp_path / "x", tmp_path / "a.npz")
    assert parse(words("--imitation.demonstrations=~/d")).imitation.demonstrations == tmp_path / "d"
    monkeypatch.delenv("HOME")
    assert parse(words("--out=~nobody-here/x")).folder.name == "x"
