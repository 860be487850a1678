"""Policies that are compared: where they come from, and what is refused."""

import json
import sys
import threading
import types
from functools import partial

import numpy as np
import pytest
from command_line import SHORT, refused, rows, run
from helpers import SEEN

from asv_env import make_params
from baselines.evaluate.fingerprints import identify
from baselines.evaluate.policy_sources import find
from baselines.learned import policy_file
from baselines.learned.network import Metadata, NetworkPolicy
from baselines.policy import Idle, Random
from baselines.rollout import runner
from baselines.rollout.episodes import Label

pytestmark = pytest.mark.usefixtures("no_report")


@pytest.mark.usefixtures("own_modules")
@pytest.mark.parametrize(("workers", "num_envs"), [(0, 1), (0, 4), (1, 2)])
def test_a_broken_policy_fails_its_own_episodes_alone(tmp_path, capsys, workers, num_envs):
    run(
        *(*SHORT, "--random-goals", "--episodes", 4, "--seed", 20, "--out", tmp_path),
        *("--num-envs", num_envs, "--workers", workers),
        *("--policies", "idle", "broken_policies:RaisesNow", "broken_policies:GivesNan"),
    )
    message = capsys.readouterr().out
    by_policy = {
        name: [row for row in rows(tmp_path) if row.policy == name]
        for name in ("idle", "RaisesNow", "GivesNan")
    }
    assert all(row.error is None for row in by_policy["idle"])
    for name, text in (("RaisesNow", "ArithmeticError: tired"), ("GivesNan", "not finite")):
        broken = [row for row in by_policy[name] if row.error]
        assert 0 < len(broken) < 4  # of those that turn right only
        assert all(row.goal_x > 0 for row in broken)
        assert {(row.cause, row.success) for row in broken} == {("policy error", False)}
        assert all(text in row.error for row in broken)
        assert f"{name}, brief, seed {broken[0].seed}" in message
        for one, other in zip(by_policy[name], by_policy["idle"], strict=True):
            assert one.error or one.position_error == other.position_error


@pytest.mark.usefixtures("own_modules")
@pytest.mark.parametrize(
    ("word", "message"),
    [
        ("scriptd", "Did you mean 'scripted'"),
        ("nowhere:Policy", "No module named 'nowhere'"),
        ("broken_policies:Nothing", "no attribute 'Nothing'"),
        ("broken_policies:NoPolicy", "no method act"),
        ("broken_policies:WrongShape", "must be (1, 4, 2)"),
        ("broken_policies:Picky", "I only play approach"),
        ("broken_policies:OldStyle", "act must take (sensed, observation, memory, fresh)"),
        ("broken_policies:OnlyActs", "return (action, memory)"),
        ("broken_policies:Unmade", "AttributeError: nothing"),
        ("broken_policies:turning_right", "AttributeError"),
        ("scripted,idle", "need a name"),
        ("mine=scripted,idle", "need a name"),
        ("../mine=idle", "cannot be a name"),
        ("=idle", "cannot be a name"),
        ("missing.npz", "there is no such file"),
        ("missing.zip", "there is no such file"),
    ],
)
def test_what_is_no_policy_or_does_not_fit_is_refused(tmp_path, capsys, word, message):
    assert message in refused(capsys, *SHORT, "--policies", word, "--out", tmp_path / "none")
    assert not (tmp_path / "none").exists()


def test_a_policy_file_takes_part(tmp_path, network_file):
    run(*SHORT, "--policies", "idle", f"net={network_file}", "--out", tmp_path)
    assert {row.policy for row in rows(tmp_path)} == {"idle", "net"}


def test_several_trainings_are_one_policy(tmp_path, network_file, other_network_file):
    words = ["--policies", "idle", f"net={network_file},{other_network_file}"]
    run(*SHORT, *words, "--out", tmp_path)
    net = [row for row in rows(tmp_path) if row.policy == "net"]
    assert [(row.training_seed, row.seed) for row in net] == [
        (k, s) for k in (0, 1) for s in range(3)
    ]
    (condition,) = json.loads((tmp_path / "summary.json").read_text())["conditions"].values()
    assert condition["policies"]["net"]["trainings"] == 2
    assert condition["comparisons"]["net"]["mcnemar"] is None


def test_another_policy_under_a_known_name_is_noticed(
    tmp_path, capsys, network_file, other_network_file
):
    run(*SHORT, "--policies", "idle", f"net={network_file}", "--out", tmp_path)
    words = ["--policies", "idle", f"net={other_network_file}", "--out", tmp_path]
    assert "another policy net" in refused(capsys, *SHORT, *words)
    run(*SHORT, *words, "--overwrite")
    assert len(rows(tmp_path)) == 6


@pytest.mark.parametrize("text", [b"not an archive", b"PK\x05\x06" + 18 * b"\0"])
def test_a_file_that_is_no_policy_is_refused(tmp_path, capsys, text):
    file = tmp_path / "mine.npz"
    file.write_bytes(text)
    message = refused(capsys, *SHORT, "--policies", file, "--out", tmp_path / "none")
    assert "not a policy file" in message


@pytest.mark.parametrize(
    ("weight", "bias", "metadata", "message"),
    [
        ((SEEN, 2), (3,), {}, "do not fit"),
        ((SEEN,), (2,), {}, "do not fit"),
        ((SEEN - 1, 2), (2,), {}, f"must map an observation of {SEEN}"),
        ((SEEN, 2), (2,), {"tasks": ("approach",)}, "is for the task approach, not for 'push'"),
        ((SEEN, 2), (2,), {"action_mode": "thrusters"}, "gives 'thrusters' actions"),
        ((SEEN, 2), (2,), {"observation_version": 0}, "observes by version 0"),
    ],
)
def test_a_policy_file_that_does_not_fit_is_refused(
    tmp_path, capsys, weight, bias, metadata, message
):
    file = tmp_path / "mine.npz"
    layers = [(np.zeros(weight), np.zeros(bias))]
    policy_file.save(file, layers, Metadata(**metadata), {})
    assert message in refused(capsys, *SHORT, "--policies", file, "--out", tmp_path / "none")


@pytest.mark.parametrize(
    "metadata", ["no json", '"text"', '{"tasks": null}', '{"tasks": [], "unknown": 1}']
)
def test_a_policy_file_with_metadata_that_make_no_sense_is_refused(tmp_path, capsys, metadata):
    file, layer = tmp_path / "mine.npz", {"weight_0": np.zeros((SEEN, 2)), "bias_0": np.zeros(2)}
    policy = f'{{"format": "{policy_file.FORMAT}", "metadata": {metadata}, "model_card": {{}}}}'
    np.savez(file, policy=np.array(policy), **layer)
    message = refused(capsys, *SHORT, "--policies", file, "--out", tmp_path / "none")
    assert f"{file} is not a policy file" in message


def test_a_policy_file_gives_what_its_perceptron_says():
    rng = np.random.default_rng(0)
    first, last = rng.normal(size=(SEEN, 3)), rng.normal(size=(3, 2))
    shift = rng.normal(size=3)
    policy = NetworkPolicy(
        [(first, shift), (last, np.zeros(2))], Metadata(activation="relu"), make_params("push")
    )
    seen = rng.normal(size=(5, 4, SEEN)).astype(np.float32)
    wanted = np.clip(np.maximum(seen @ first + shift, 0.0) @ last, -1.0, 1.0)
    np.testing.assert_allclose(policy.forward(seen), wanted, atol=1e-5)


def test_a_policy_that_decides_less_often_holds_its_action():
    policy = NetworkPolicy(
        [(np.eye(SEEN, 2), np.zeros(2))], Metadata(action_repeat=3), make_params("push")
    )
    memory, done = None, []
    for tick in range(8):
        seen = np.full((2, 4, SEEN), tick / 10, dtype=np.float32)
        fresh = np.array([tick == 0, tick in (0, 4)])
        action, memory = policy.act(None, seen, memory, fresh)
        done.append(np.round(10 * action[:, 0, 0]).astype(int).tolist())
    assert done == [[0, 0], [0, 0], [0, 0], [3, 3], [3, 4], [3, 4], [6, 4], [6, 7]]


@pytest.mark.parametrize("kind", ["joint", "off-policy"])
def test_models_of_other_kinds_take_part(tmp_path, kind):
    import gymnasium as gym
    from stable_baselines3 import PPO, SAC

    from asv_env.envs.sb3 import BoatVecEnv

    if kind == "joint":
        model = PPO("MlpPolicy", gym.make("asv_env/Push-v0"), device="cpu", seed=0)
    else:
        model = SAC(
            "MlpPolicy", BoatVecEnv("push", num_envs=1), device="cpu", buffer_size=8, seed=0
        )
    model.save(tmp_path / "other.zip")
    params = make_params("push", time_limit=0.5)
    made = find(tmp_path / "other.zip", trust_pickles=True).factory(params)
    (log,) = runner.run(lambda params: made, params, [0], 1, Label("other"), record=True)
    assert log.episode.error is None
    seen = log.trajectory.observation[0]
    action, _ = model.predict(seen, deterministic=True)
    np.testing.assert_allclose(log.trajectory.action[0], action, atol=1e-6)


def test_pickles_are_not_read_unless_trusted(tmp_path, capsys, sb3_file):
    message = refused(capsys, *SHORT, "--policies", sb3_file, "--out", tmp_path / "none")
    assert "--trust-pickles" in message
    run(*SHORT, "--policies", sb3_file, "--trust-pickles", "--out", tmp_path)
    assert {row.policy for row in rows(tmp_path)} == {"model"}


def test_a_model_with_other_spaces_is_refused(tmp_path, capsys):
    from stable_baselines3 import PPO

    PPO("MlpPolicy", "Pendulum-v1", device="cpu").save(tmp_path / "pendulum.zip")
    words = ["--policies", tmp_path / "pendulum.zip", "--trust-pickles"]
    message = refused(capsys, *SHORT, *words, "--out", tmp_path / "none")
    assert "maps observations (3,) to actions (1,)" in message
    assert f"({SEEN},) -> (2,)" in message


def test_a_program_that_has_no_file_has_policies_too(monkeypatch):
    """As one that is read from standard input, or run from an archive."""
    module = types.ModuleType("fileless")
    module.__file__ = "<stdin>"
    monkeypatch.setitem(sys.modules, "fileless", module)
    own = type("Own", (), {"__module__": "fileless"})
    file, identity = identify(own)
    assert file is None
    assert identity != identify(own)[1]


def made(seed):
    """A policy that a function has made, with a base and a method that knows its class."""

    class Base(Idle):
        seed = 0

    class Made(Base):
        def __init__(self, params):
            super().__init__(params)
            self.seed = seed

    return Made


class Maker:
    def __init__(self, seed):
        self.seed = seed

    def __call__(self, params):
        return Random(params, self.seed)

    make = __call__


KINDS = {
    "class": made,
    "object": Maker,
    "method": lambda seed: Maker(seed).make,
    "partial": lambda seed: partial(Random, seed=seed),
    "nested": lambda seed: partial(lambda params, k: Random(params, k), k=Maker(seed)),
    "function": lambda seed: lambda params: Random(params, seed),
    "default": lambda seed: lambda params, k=seed: Random(params, k),
    "type": lambda seed: type("Typed", (Idle,), {"seed": seed}),
    "base": lambda seed: type("Derived", (made(seed),), {}),
}


@pytest.mark.parametrize("kind", KINDS.values(), ids=KINDS)
def test_policies_that_differ_in_what_is_bound_to_them_are_different(kind):
    one, same, other = (find(kind(seed)).fingerprint() for seed in (1, 1, 2))
    assert one == same != other


def test_policies_whose_bound_values_cannot_be_compared_are_different():
    lock = threading.Lock()
    assert find(lambda _: lock).fingerprint() != find(lambda _: lock).fingerprint()
