"""Trajectories and films of episodes."""

import numpy as np
import pytest
from command_line import SHORT, WHOLE, rows, run

from asv_env import make_params
from baselines.policy import Idle
from baselines.rollout import film, runner, trajectories
from baselines.rollout.episodes import Label

pytestmark = pytest.mark.usefixtures("no_report")


def test_trajectories_agree_with_the_rows(tmp_path):
    run(*SHORT, "--policies", "random", "--record", "--out", tmp_path)
    for row in rows(tmp_path):
        folder = trajectories.folder(tmp_path, row.condition, row.policy, None)
        trajectory, about = trajectories.load(trajectories.path(folder, row.seed))
        steps = len(trajectory.action)
        assert steps == round(row.duration * about["control_rate"])
        assert trajectory.observation.shape == (steps + 1, 4, len(about["observation_names"]))
        assert trajectory.motion.shape == (steps + 1, 5, 6)
        assert trajectory.reward.mean(axis=1).sum() == pytest.approx(row.episode_return, abs=1e-4)
        assert not trajectory.terminated
        assert about["purpose"] == "test"
        assert about["episode"]["seed"] == row.seed
        error = trajectory.motion[-1, 0, :2] - trajectory.goal[-1, :2]
        assert np.hypot(*error) == pytest.approx(row.position_error)


def test_actions_of_a_trajectory_lead_to_its_states(tmp_path):
    from asv_env import Simulation

    run(*WHOLE, "--policies", "scripted", "--record", "--episodes", 1, "--out", tmp_path)
    folder = trajectories.folder(tmp_path, "nominal", "scripted", None)
    trajectory, _ = trajectories.load(trajectories.path(folder, 0))
    simulation = Simulation(make_params("push", goal=(0.55, -0.95, 0.1)))
    observations = [simulation.reset(seeds=[0])[0]]
    for action in trajectory.action[:50]:
        observations.append(simulation.step(action[None]).observation[0])
    np.testing.assert_array_equal(observations, trajectory.observation[:51])
    np.testing.assert_array_equal(simulation.state.motion[0], trajectory.motion[50])


def test_a_trajectory_names_the_features_that_were_observed(tmp_path):
    params = make_params("push", time_limit=1.0, observation=("goal", "own_yaw_rate"))
    (log,) = runner.run(Idle, params, [0], 1, Label("idle"), record=True)
    trajectories.save(tmp_path, log, params)
    trajectory, about = trajectories.load(trajectories.path(tmp_path, 0))
    assert about["observation_names"] == ["goal_x", "goal_y", "own_yaw_rate"]
    assert trajectory.observation.shape[-1] == 3


def test_trajectories_that_are_missing_are_made_later(tmp_path):
    run(*SHORT, "--policies", "idle", "--out", tmp_path)
    before = rows(tmp_path)
    run(*SHORT, "--policies", "idle", "--record", "--out", tmp_path)
    assert rows(tmp_path) == before
    folder = trajectories.folder(tmp_path, "brief", "idle", None)
    assert len(list(folder.glob("*.npz"))) == 3


def test_trajectories_are_of_the_policy_that_they_are_named_after(
    tmp_path, network_file, other_network_file
):
    def recorded(*words):
        run(*SHORT, "--episodes", 1, "--policies", *words, "--out", tmp_path)
        (row,) = rows(tmp_path)
        file = trajectories.path(trajectories.folder(tmp_path, "brief", "net", None), 0)
        return row, trajectories.load(file)[1]["episode"] if file.exists() else None

    row, about = recorded(f"net={network_file}", "--record")
    assert about["episode_return"] == row.episode_return
    assert recorded(f"net={other_network_file}", "--overwrite")[1] is None
    other, about = recorded(f"net={other_network_file}", "--record")
    assert about["episode_return"] == other.episode_return != row.episode_return


@pytest.mark.usefixtures("own_modules")
def test_broken_episodes_are_not_run_again_for_want_of_a_trajectory(tmp_path, monkeypatch):
    words = [*SHORT, "--policies", "broken_policies:RaisesNow", "--record", "--out", tmp_path]
    run(*words)
    assert all(row.error for row in rows(tmp_path))
    monkeypatch.setattr("baselines.rollout.runner.run", lambda *arguments: pytest.fail("run again"))
    run(*words)


def test_a_file_that_is_no_trajectory_is_refused(tmp_path, network_file):
    with pytest.raises(ValueError, match="not a recorded trajectory"):
        trajectories.load(network_file)


def test_film_shows_the_episode_that_the_row_counts():
    params = make_params("push", goal=(0.0, -0.5, 0.0), time_limit=3.0)
    frames = list(film.frames(Idle, params, 0))
    assert len(frames) == 8 + film.LAST
    (log,) = runner.run(Idle, params, [0], 1, Label("idle"))
    assert log.episode.duration == 3.0
