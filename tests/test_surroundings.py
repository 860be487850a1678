"""Error states, warnings, threads and defaults of other libraries do not reach environments."""

from __future__ import annotations

import threading
import warnings
from typing import Any

import numpy as np
import pytest
import torch
from helpers import same
from test_copies import DRIVERS, Driver, outcome

drivers = pytest.mark.parametrize("driver", DRIVERS.values(), ids=DRIVERS.keys())
OPTIONS: dict[str, Any] = {"scenario": "harsh", "num_boats": 4, "time_limit": 0.8}


def history(driver: Driver, steps: int = 25, **options: Any) -> list[Any]:
    env = driver.make(**OPTIONS, **options)
    returned = [driver.reset(env, 3, None)]
    for step in range(steps):
        returned.append(outcome(driver.step, env, step))
        if driver.single and step % 8 == 7:
            returned.append(driver.reset(env, None, None))
        if options and step % 8 == 0:
            returned.append(env.render())
    env.close()
    return returned


@drivers
@pytest.mark.parametrize("state", ["raise", "warn", "print"])
def test_the_floating_point_error_state_changes_nothing(driver: Driver, state: Any) -> None:
    expected = history(driver)
    with np.errstate(all=state), warnings.catch_warnings():
        warnings.simplefilter("error")
        assert same(history(driver), expected)
        after = np.geterr()
    assert set(after.values()) == {state}, "the user's setting stays"


@drivers
def test_pictures_do_not_depend_on_the_error_state(driver: Driver) -> None:
    expected = history(driver, 9, render_mode="rgb_array")
    with np.errstate(all="raise"):
        assert same(history(driver, 9, render_mode="rgb_array"), expected)


def test_each_thread_computes_what_it_would_alone() -> None:
    expected = {name: history(driver) for name, driver in DRIVERS.items()}
    found: dict[Any, Any] = {}

    def run(name: str, number: int) -> None:
        found[name, number] = history(DRIVERS[name])

    threads = [threading.Thread(target=run, args=(n, k)) for n in DRIVERS for k in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(found) == 2 * len(DRIVERS)
    assert all(same(one, expected[name]) for (name, _), one in found.items())


@drivers
def test_defaults_of_other_libraries_change_nothing(driver: Driver) -> None:
    expected = history(driver)
    try:
        torch.set_default_dtype(torch.float64)
        np.random.seed(1)  # noqa: NPY002
        with np.printoptions(precision=1):
            assert same(history(driver), expected)
    finally:
        torch.set_default_dtype(torch.float32)
