"""Windows open only on a display, and leave other windows and events of the process alone."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import gymnasium
import numpy as np
import pytest

import asv_env

pygame = pytest.importorskip("pygame")
OPTIONS: dict[str, Any] = {"num_boats": 2, "clock": {"control": 50, "sensing": 50}}


@pytest.fixture(autouse=True)
def _invisible(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    yield
    pygame.quit()


def shown() -> asv_env.JointEnv:
    env = asv_env.JointEnv("push", render_mode="human", **OPTIONS)
    env.reset(seed=0)
    return env


def kinds(events: list[Any]) -> set[int]:
    return {event.type for event in events}


@pytest.mark.parametrize("driver", ["dummy", "offscreen"])
def test_a_driver_that_shows_nothing_is_refused_unless_it_was_asked_for(
    monkeypatch: pytest.MonkeyPatch, driver: str
) -> None:
    monkeypatch.delenv("SDL_VIDEODRIVER")
    monkeypatch.setattr(pygame.display, "get_driver", lambda: driver)
    env = asv_env.JointEnv("push", render_mode="human", **OPTIONS)
    with pytest.raises(RuntimeError, match=f"no window can be opened.*{driver}.*rgb_array"):
        env.reset(seed=0)
    assert not pygame.display.get_init()
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    env.reset(seed=0)
    assert pygame.display.get_init()
    env.close()


def test_without_pygames_windows_the_package_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delattr(pygame, "Window")
    with pytest.raises(RuntimeError, match=r"install pygame-ce.*asv-env\[eval\].*rgb_array"):
        shown()


def test_two_windows_are_closed_one_by_one() -> None:
    one, other = shown(), shown()
    one._viewer._window._window.title  # noqa: B018  it is open
    assert one._viewer._window._window is not other._viewer._window._window
    one.close()
    assert pygame.display.get_init()
    other.step(0)
    assert not other._viewer.closed
    other.close()
    assert not pygame.display.get_init()


def test_the_users_window_and_events_stay() -> None:
    user = pygame.display.set_mode((64, 48))
    user.fill((1, 2, 3))
    env = shown()
    pygame.event.post(pygame.event.Event(pygame.KEYDOWN, key=pygame.K_ESCAPE, window=None))
    pygame.event.post(pygame.event.Event(pygame.USEREVENT))
    env.step(0)
    assert {pygame.KEYDOWN, pygame.USEREVENT} <= kinds(pygame.event.get())
    assert not env._viewer.closed, "Escape was for another window"
    env.close()
    assert pygame.display.get_surface() is user
    assert user.get_at((5, 5))[:3] == (1, 2, 3)


def test_each_window_closes_as_its_own_events_say() -> None:
    one, other = shown(), shown()
    window = one._viewer._window._window
    pygame.event.post(pygame.event.Event(pygame.WINDOWCLOSE, window=window))
    other.step(0)
    one.step(0)
    assert (one._viewer.closed, other._viewer.closed) == (True, False)
    assert one.step(0)[0] in one.observation_space, "the environment continues unseen"
    pygame.event.post(pygame.event.Event(pygame.KEYDOWN, key=pygame.K_ESCAPE, window=window))
    other.step(0)
    assert not other._viewer.closed
    pygame.event.post(pygame.event.Event(pygame.QUIT))
    other.step(0)
    assert other._viewer.closed
    one.close()
    other.close()


@pytest.mark.parametrize("leave", [pygame.quit, pygame.display.quit])
@pytest.mark.parametrize("again", [False, True])
def test_the_user_may_quit_pygame(leave: Any, again: bool) -> None:
    env, drawn = shown(), asv_env.JointEnv("push", render_mode="rgb_array", **OPTIONS)
    drawn.reset(seed=0)
    frame = drawn.render()
    leave()
    if again:
        pygame.init()
    assert np.array_equal(drawn.render(), frame)
    env.step(0)
    assert env._viewer.closed
    env.close()
    assert pygame.display.get_init() is again
    shown().close()


@pytest.mark.parametrize("name", ["make", "joint", "parallel"])
def test_render_waits_for_a_reset(name: str) -> None:
    env: Any = {
        "make": lambda: gymnasium.make("asv_env/Push-v0", render_mode="rgb_array"),
        "joint": lambda: asv_env.JointEnv("push", render_mode="rgb_array"),
        "parallel": lambda: asv_env.parallel_env("push", render_mode="rgb_array"),
    }[name]()
    with pytest.raises(gymnasium.error.ResetNeeded):
        env.render()
    env.reset(seed=0)
    assert env.render().std() > 0
