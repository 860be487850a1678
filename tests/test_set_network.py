"""The network of sets: NumPy and torch agree; neither order, nor padding, nor the batch matters."""

import numpy as np
import pytest

from asv_env import Simulation, make_params
from asv_env.types import rows
from baselines.learned import policy_file, team_policy
from baselines.learned.seen import Seen
from baselines.learned.set_network import SetNetwork
from baselines.learned.team_policy import TeamPolicy
from baselines.learned.team_view import TeamView
from baselines.rollout.loop import rollout

torch = pytest.importorskip("torch")
from train.team.set_actor import SetActor, tensors  # noqa: E402

PARAMS = make_params("transport", 6, "noisy", obstacles="pillars")


@pytest.fixture(scope="module")
def actor():
    """A network with actions of all sizes."""
    torch.manual_seed(0)
    actor = SetActor()
    with torch.no_grad():
        actor.layers["out"].weight *= 30.0
    return actor


@pytest.fixture(scope="module")
def seen(actor):
    """What boats see after a while; rows are worlds."""
    simulation, policy = Simulation(PARAMS, 5), TeamPolicy(actor.weights(), PARAMS)
    ticks = list(rollout(simulation, policy.act, range(5), 20))
    fresh = np.zeros(5, dtype=bool)
    return TeamView(PARAMS).observe(simulation.sensed, ticks[-1].memory, fresh)[0]


def flat(seen):
    """The same with boats of all worlds in one row."""
    return tensors(
        Seen(*(part.reshape(part.shape[0] * part.shape[1], *part.shape[2:]) for part in seen))
    )


@pytest.mark.parametrize("obstacles", [True, False])
def test_numpy_and_torch_agree(actor, seen, obstacles):
    if not obstacles:
        seen = seen._replace(obstacles=seen.obstacles[:, :, :0])
    with torch.no_grad():
        wanted = actor(*flat(seen)).clamp(-1.0, 1.0).numpy().reshape(5, 6, 3)
    found = SetNetwork(actor.weights())(seen)
    np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-5)
    assert np.ptp(found, axis=(0, 1)).min() > 0.3


def test_the_order_of_sets_does_not_matter(actor, seen):
    network, rng = SetNetwork(actor.weights()), np.random.default_rng(0)
    shuffled = Seen(seen.own, *(rng.permutation(part, axis=2) for part in seen[1:]))
    np.testing.assert_allclose(network(shuffled), network(seen), rtol=0, atol=1e-6)


def test_boats_that_are_not_present_do_not_matter(actor, seen):
    own, boats, outline, obstacles = flat(seen)
    padded = torch.cat([boats, torch.zeros(len(boats), 7, boats.shape[-1])], dim=1)
    with torch.no_grad():
        one, other = actor(own, boats, outline, obstacles), actor(own, padded, outline, obstacles)
    torch.testing.assert_close(one, other, rtol=0, atol=1e-6)


def test_a_world_does_not_depend_on_the_others_to_the_bit(actor, seen):
    network = SetNetwork(actor.weights())
    together = network(seen)
    for world in range(5):
        np.testing.assert_array_equal(
            network(Seen(*(part[world : world + 1] for part in seen)))[0], together[world]
        )


def test_the_policy_runs_in_every_world_from_its_file(actor, tmp_path):
    file = tmp_path / "team.npz"
    team_policy.save(file, actor.weights(), {"seed": 0})
    assert file.stat().st_size < 1_000_000
    assert team_policy.read(file)[1] == {"seed": 0}
    for task, team, options in [
        ("approach", 2, {}),
        ("push", 12, {"vessel": "L"}),
        ("transport", 3, {"scenario": "harsh", "sensors": {"shared": False, "range": 0.5}}),
    ]:
        simulation = Simulation(make_params(task, team, **options), 2)
        policy = policy_file.load(file, simulation.params)
        one = 1 if simulation.params.sensors.shared else team
        sensed, memory, fresh = simulation.reset(seeds=[0, 1]), None, np.ones(2 * one, dtype=bool)
        sensed = simulation.sensed
        together, memory = policy.act(sensed, np.zeros(0), memory, fresh)
        alone, _ = policy.act(rows(sensed, slice(0, one)), np.zeros(0), None, fresh[:one])
        assert together.shape == (2 * one, team, 2)
        assert np.isfinite(together).all()
        np.testing.assert_array_equal(alone, together[:one])


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda w: w.pop("out.bias"), "out.bias"),
        (lambda w: w.update({"out.bias": np.full(3, np.nan)}), "not finite"),
        (lambda w: w.update({"own_1.weight": np.zeros((3, 32))}), "own_1.weight"),
        (lambda w: w.clear(), "not those of a network of sets"),
    ],
)
def test_weights_that_do_not_fit_are_refused(actor, change, message):
    weights = dict(actor.weights())
    change(weights)
    with pytest.raises(ValueError, match=message):
        SetNetwork(weights)


def test_a_file_of_another_kind_is_refused(tmp_path, network_file):
    with pytest.raises(ValueError, match="not a policy file of the format"):
        team_policy.read(network_file)
