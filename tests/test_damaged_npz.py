"""Policy files and trajectories that are damaged, or claim what they are not, are named."""

import io
import json
import zipfile

import numpy as np
import pytest
from helpers import SEEN
from hypothesis import given, settings
from hypothesis import strategies as st

from asv_env import make_params
from baselines.learned import npz, policy_file
from baselines.learned.network import Metadata
from baselines.rollout import runner, trajectories
from baselines.scripted.scripted_policy import ScriptedPolicy

PARAMS = make_params("push", time_limit=1.0)


@pytest.fixture(scope="module")
def good(tmp_path_factory):
    """A policy file and a trajectory."""
    folder, rng = tmp_path_factory.mktemp("good"), np.random.default_rng(0)
    layers = [(rng.normal(size=(n, m)), rng.normal(size=m)) for n, m in [(SEEN, 3), (3, 2)]]
    policy_file.save(folder / "policy.npz", layers, Metadata(), {"steps": 3})
    (log,) = runner.run(ScriptedPolicy, PARAMS, [10**9], 1, record=True)
    trajectories.save(folder, log, PARAMS)
    return {"policy": folder / "policy.npz", "trajectory": folder / f"{10**9}.npz"}


def content(kind, file):
    """All that is read of a file, comparable."""
    if kind == "trajectory":
        trajectory, about = trajectories.load(file)
        return {name: np.asarray(a).tobytes() for name, a in vars(trajectory).items()}, about
    layers, metadata, card = policy_file.read(file)
    return [a.tobytes() for layer in layers for a in layer], metadata, card


@settings(max_examples=150)
@given(data=st.data())
def test_a_damaged_file_gives_what_was_written_or_is_named(data, good, tmp_path_factory):
    kind = data.draw(st.sampled_from(["policy", "trajectory"]))
    old = good[kind].read_bytes()
    at = data.draw(st.integers(0, len(old) - 1) | st.integers(len(old) - 800, len(old) - 1))
    length = data.draw(st.integers(1, 40))
    changed = {
        "cut": old[:at],
        "zero": old[:at] + bytes(length) + old[at + length :],
        "flip": old[:at] + bytes([old[at] ^ data.draw(st.integers(1, 255))]) + old[at + 1 :],
        "twice": old[:at] + old[at : at + length] + old[at:],
    }[data.draw(st.sampled_from(["cut", "zero", "flip", "twice"]))]
    file = tmp_path_factory.mktemp("damaged") / "7.npz"
    file.write_bytes(changed)
    try:
        found = content(kind, file)
    except ValueError as error:
        said = str(error)
        assert said.startswith(f"{file} is not a ")
        assert "\n" not in said
    else:
        assert found == content(kind, good[kind])


def rewritten(source, target, **members):
    """A copy of a file in which some members have other bytes."""
    with zipfile.ZipFile(source) as old, zipfile.ZipFile(target, "w") as new:
        for name in old.namelist():
            new.writestr(name, members.get(name.removesuffix(".npy"), old.read(name)))
    return target


def npy(array, **header):
    """Bytes of an array with a header that claims something else."""
    stream = io.BytesIO()
    form = {"descr": np.lib.format.dtype_to_descr(array.dtype), "fortran_order": False}
    np.lib.format.write_array_header_1_0(stream, {**form, "shape": array.shape, **header})
    return stream.getvalue() + array.tobytes()


@pytest.mark.parametrize(
    ("array", "words"),
    [
        (npy(np.zeros(2), shape=(10**15,)), "1,000,000,000,000,000 times float64 has 16 bytes"),
        (npy(np.zeros(2), shape=(-2,)), "times float64 has 16 bytes"),
        (npy(np.zeros(2), descr="|O"), "objects"),
        (npy(np.zeros((2, 2))), "do not fit"),
        (npy(np.zeros(3)), "do not fit"),
        (npy(np.zeros(2, dtype="S4")), "not real numbers"),
        (npy(np.full(2, np.inf)), "not finite"),
        (b"", "magic string"),
        (b"\x93NUMPY\x01\x00\x05\x00(((((", ""),
    ],
)
def test_arrays_that_a_policy_cannot_have_are_refused(array, words, good, tmp_path):
    file = rewritten(good["policy"], tmp_path / "bad.npz", bias_1=array)
    with pytest.raises(ValueError, match=rf"bad\.npz is not a policy file .*{words}"):
        policy_file.read(file)


def test_more_than_can_be_read_is_refused_before_it_is(good, tmp_path, monkeypatch):
    monkeypatch.setattr(npz, "LARGEST", 1000)
    with pytest.raises(ValueError, match=r"it claims .* bytes, at most 1,000 are read"):
        policy_file.read(good["policy"])


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"metadata": 3}, "not subscriptable"),
        ({"metadata": {}}, "tasks"),
        ({"model_card": None}, "model card"),
        ({"activation": "sine"}, "activation 'sine'"),
        ({"tasks": "push"}, "'push' are not names"),
        ({"observation": [1]}, "are not names"),
        ({"speed": 3}, "speed"),
    ],
)
def test_what_a_policy_file_says_of_a_network_is_checked(change, words, good, tmp_path):
    policy = json.loads(str(np.load(good["policy"])["policy"]))
    for name, value in change.items():
        place = policy if name in policy else policy["metadata"]
        place[name] = value
    text = npy(np.array(json.dumps(policy)))
    file = rewritten(good["policy"], tmp_path / "bad.npz", policy=text)
    with pytest.raises(ValueError, match=rf"bad\.npz is not a policy file .*{words}"):
        policy_file.read(file)


@pytest.mark.parametrize("name", ["observation", "action", "reward", "motion", "goal", "working"])
def test_arrays_of_other_lengths_are_no_trajectory(name, good, tmp_path):
    array = np.load(good["trajectory"])[name][1:]
    file = rewritten(good["trajectory"], tmp_path / "7.npz", **{name: npy(array)})
    with pytest.raises(ValueError, match=r"7\.npz is not a recorded trajectory: arrays of shapes"):
        trajectories.load(file)


@pytest.mark.parametrize("text", ["", "[]", "{}", "[" * 100_000, '{"episode": 1}'])
def test_metadata_that_a_trajectory_cannot_have_are_refused(text, good, tmp_path):
    about = npy(np.array(text)) if text else npy(np.zeros(3))
    file = rewritten(good["trajectory"], tmp_path / "7.npz", about=about)
    for read in (trajectories.load, trajectories.about):
        with pytest.raises(ValueError, match=r"7\.npz is not a recorded trajectory"):
            read(file)


@pytest.mark.parametrize("episode", [None, 3, "x", [], True])
def test_an_episode_that_is_no_record_is_refused(episode, good, tmp_path):
    about = json.loads(str(np.load(good["trajectory"])["about"])) | {"episode": episode}
    text = npy(np.array(json.dumps(about)))
    file = rewritten(good["trajectory"], tmp_path / "7.npz", about=text)
    with pytest.raises(ValueError, match=r"7\.npz is not a recorded trajectory"):
        trajectories.about(file)


def test_what_is_not_there_or_a_folder_is_an_error_of_the_system(tmp_path):
    for name, kind in (("none.npz", FileNotFoundError), (".", IsADirectoryError)):
        with pytest.raises(kind):
            policy_file.read(tmp_path / name)


def test_a_policy_file_is_written_all_at_once(good, tmp_path):
    file = tmp_path / "mine.npz"
    with pytest.raises(ValueError, match=r"mine\.txt: a policy file ends in \.npz"):
        policy_file.save(tmp_path / "mine.txt", [], Metadata(), {})
    file.write_text("old")
    with pytest.raises(TypeError):
        policy_file.save(file, [], Metadata(), {"not JSON": object()})
    assert file.read_text() == "old"
    assert list(tmp_path.iterdir()) == [file]
