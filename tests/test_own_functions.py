"""Functions of tasks and features that fail or return nonsense are named, wherever they are run."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest

import asv_env
from asv_env import Simulation, make_params
from asv_env.checks import FunctionError
from asv_env.sensing.observation import scalar, vector
from asv_env.tasks import PUSH, Metric, Term
from baselines.evaluate import compare
from baselines.evaluate.api import InputError, StoppedError
from baselines.evaluate.conditions import Condition
from baselines.policy import Idle
from baselines.rollout import runner

W = 3


def raises(*_):
    raise ZeroDivisionError("one\ntwo")


def giving(value):
    return lambda *_: value


def stepped(task=PUSH, **options):
    """Summary after two steps of three worlds with a task of one's own."""
    simulation = Simulation(make_params(replace(task, name="own"), **options), W)
    simulation.reset(seeds=range(W))
    for _ in range(2):
        simulation.step(np.zeros((W, 4, 2)))
    return simulation.summary()


NOT_REAL = {
    "function": (raises, "failed: ZeroDivisionError: one two"),
    "scalar": (giving(0.0), r"returned float64 \(\): must be real"),
    "None": (giving(None), "returned object"),
    "short": (giving(np.zeros(W - 1)), r"returned float64 \(2,\)"),
    "ragged": (giving([[0.0], [0.0, 1.0]]), "failed: ValueError"),
    "complex": (giving(np.zeros(W) * 1j), "returned complex128"),
    "text": (giving(["a"] * W), "returned <U1"),
}


@pytest.mark.parametrize(("function", "text"), NOT_REAL.values(), ids=NOT_REAL)
@pytest.mark.parametrize("field", ["value", "potential"])
def test_a_reward_term_is_named(field, function, text):
    task = replace(PUSH, reward=(*PUSH.reward, Term("odd", **{field: function})))
    with pytest.raises(FunctionError, match=f"reward term 'odd' {text}"):
        stepped(task)


@pytest.mark.parametrize("number", [np.nan, np.inf])
@pytest.mark.parametrize("shared", [True, False])
def test_a_reward_that_is_not_finite_is_named(number, shared):
    term = Term("odd", giving(np.full(W if shared else (W, 4), number)), shared=shared)
    with pytest.raises(FunctionError, match="reward term 'odd' is not finite"):
        stepped(replace(PUSH, reward=(term, *PUSH.reward)))


@pytest.mark.parametrize("weight", ["delivry", np.nan, None, "time " * 99])
def test_a_weight_that_is_none_is_refused_when_the_term_is_made(weight):
    with pytest.raises(ValueError, match="reward term 'odd'"):
        Term("odd", giving(np.zeros(W)), weight=weight)


@pytest.mark.parametrize(("function", "text"), NOT_REAL.values(), ids=NOT_REAL)
def test_a_metric_is_named(function, text):
    with pytest.raises(FunctionError, match=f"metric 'odd' {text}"):
        stepped(replace(PUSH, metrics=(Metric("odd", function),)))


def test_a_metric_is_a_number_of_a_name_of_its_own():
    with pytest.raises(FunctionError, match="metric 'odd' is not a number; infinite is allowed"):
        stepped(replace(PUSH, metrics=(Metric("odd", giving(np.full(W, np.nan))),)))
    with pytest.raises(FunctionError, match="metric 'is_success': there is one already"):
        stepped(replace(PUSH, metrics=(Metric("is_success", giving(np.ones(W, bool))),)))
    assert stepped(replace(PUSH, metrics=(Metric("odd", giving([1, 2, 3])),)))["odd"][2] == 3


@pytest.mark.parametrize("value", [0, True, np.zeros(W), np.zeros((W, 4), bool), None])
def test_success_is_true_or_false_for_each_world(value):
    with pytest.raises(FunctionError, match=r"own' returned .*must be bool \(3,\)"):
        stepped(replace(PUSH, success=giving(value)))


@pytest.mark.parametrize(
    "value",
    [0.0, np.zeros(4), np.zeros((4, W)), np.zeros((W, 4, 1)), np.zeros((W, 4)) * 1j, None],
)
def test_a_feature_of_one_column_is_named(value):
    with pytest.raises(FunctionError, match=r"feature 'odd' returned .*must be real"):
        stepped(observation=["slot", scalar("odd", 1.0, 1.0, giving(value))])


@pytest.mark.parametrize("value", [np.zeros((W, 4)), np.zeros((W, 4, 3)), np.zeros((W, 4, 2)) * 1j])
def test_a_feature_of_two_columns_is_named(value):
    with pytest.raises(FunctionError, match=r"feature 'odd' returned .*must be complex"):
        stepped(observation=[vector("odd", 1.0, 1.0, giving(value))])


def test_a_column_that_is_not_a_number_is_named():
    value = np.zeros((W, 4, 2))
    value[1, 2, 1] = np.nan
    with pytest.raises(FunctionError, match=r"feature 'odd_y' is not a number"):
        stepped(observation=["goal", vector("odd", 1.0, 1.0, giving(value))])
    stepped(observation=[vector("odd", 1.0, 1.0, giving(np.full((W, 1, 2), np.inf)))])


ODD = replace(PUSH, name="own", reward=(*PUSH.reward, Term("odd", giving(np.zeros(9)))))


@pytest.mark.parametrize(
    "adapter", [asv_env.JointEnv, asv_env.AsvParallelEnv, partial(asv_env.AsvVectorEnv, 2)]
)
def test_adapters_name_it_too(adapter):
    env = adapter(task=ODD)
    env.reset(seed=0)
    agents = getattr(env, "agents", None)
    spaces = {name: env.action_space(name) for name in agents} if agents else env.action_space
    action = {n: space.sample() for n, space in spaces.items()} if agents else spaces.sample()
    with pytest.raises(FunctionError, match="reward term 'odd' returned float64"):
        env.step(action)


@pytest.mark.parametrize("workers", [0, 1])
def test_an_evaluation_refuses_it_before_anything_is_run(tmp_path, workers):
    condition = Condition("short", task=ODD, options={"time_limit": 0.5})
    with pytest.raises(InputError, match=r"^condition 'short': reward term 'odd' returned"):
        compare({"idle": "idle"}, condition, 1, tmp_path / "none", workers=workers, progress=False)
    assert not (tmp_path / "none").exists()


def late(now):
    """Fails in the third tick."""
    return np.full(len(now.state.tick), np.where(now.state.tick == 3, np.nan, 0.0))


@pytest.mark.parametrize(("workers", "error"), [(0, FunctionError), (1, StoppedError)])
def test_one_that_fails_later_ends_the_evaluation_by_name(workers, error):
    task = replace(PUSH, name="own", reward=(Term("late", late),))
    condition = Condition("short", task=task, options={"time_limit": 0.5})
    with pytest.raises(error, match="reward term 'late' is not finite"):
        compare({"idle": "idle"}, condition, 1, workers=workers, progress=False)


@pytest.mark.parametrize(("cause", "text"), [(raises, "failed"), (giving(5), "returned 5")])
def test_a_cause_of_failure_is_a_text(cause, text):
    params = make_params(replace(PUSH, name="own", cause=cause), time_limit=0.5)
    with pytest.raises(FunctionError, match=f"cause of task 'own' {text}"):
        next(runner.run(Idle, params, [0], 1))
