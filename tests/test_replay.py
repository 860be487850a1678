"""The replay of a report: its packed episodes and, in a browser, what it shows."""

import base64
import re
import shutil
import time
import zlib

import numpy as np
import pytest
from invented import DEATH, DIES, ODD, SUITE, Page

from asv_env import make_params
from asv_env.render import colours
from baselines.evaluate.report import replay
from baselines.evaluate.store import RunKey, packed
from baselines.evaluate.store import unpacked as unpack_log
from baselines.policy import Idle
from baselines.rollout import runner
from baselines.rollout.episodes import Label

CHROMIUM, DRIVER = "/usr/bin/chromium", "/usr/bin/chromedriver"


@pytest.fixture(scope="module")
def page(report):
    return Page(report.html)


# Packed episodes


def unpacked(text, frames):
    """Poses (T, B, 3) as the page unpacks them, headings not wrapped."""
    planes = np.frombuffer(zlib.decompress(base64.b64decode(text)), np.uint8).reshape(2, -1)
    unsigned = planes[0].astype(np.int64) | planes[1].astype(np.int64) << 8
    bends = ((unsigned >> 1) ^ -(unsigned & 1)).reshape(-1, 3, frames)
    return np.moveaxis(bends.cumsum(axis=-1).cumsum(axis=-1), -1, 0) * np.array(replay.UNITS)


def test_poses_in_the_page_are_those_of_the_store(report, page):
    for condition in SUITE.conditions:
        block = page.data[condition.name]
        for player in report.cast.players:
            for seed, take in zip(block["seeds"], block["takes"][player.key], strict=True):
                log = report.store.log(RunKey(condition.name, player.policy, player.number), seed)
                poses = unpacked(take["poses"], take["frames"])
                wanted = replay.thinned(condition.params, log.poses)
                off = poses - wanted
                off[..., 2] = (off[..., 2] + np.pi) % (2 * np.pi) - np.pi
                assert np.abs(off).max() <= 0.5001e-3
                assert take["end"] == log.episode.duration
                assert take["failures"][DIES] == DEATH


def test_headings_are_packed_without_drift_over_many_turns():
    poses = np.zeros((500, 2, 3))
    poses[:, 1, 2] = (np.arange(500) * 2.9 + np.pi) % (2 * np.pi) - np.pi
    poses[:, 1, 0] = 27.8
    back = unpacked(replay.pack(poses), 500)
    off = (back - poses)[:, 1]
    assert np.abs(off[:, 0]).max() < 1e-9
    assert np.abs((off[:, 2] + np.pi) % (2 * np.pi) - np.pi).max() < 1e-3


def test_first_episodes_are_embedded_and_as_many_failures(report):
    assert report.cast.trivial == ["random"]
    seeds = replay.chosen(report.results, "calm", report.cast, 2)
    assert seeds[:2] == [10, 11]
    assert len(seeds) <= 4
    judged = [report.results.success("calm", name) for name in ("scripted", ODD)]
    failed = ~np.concatenate(judged).all(axis=0)
    assert all(failed[seed - 10] for seed in seeds[2:])
    assert replay.chosen(report.results, "calm", report.cast, 99) == list(range(10, 18))


def test_page_gives_the_number_of_embedded_episodes(report, page):
    number = len(page.data["calm"]["seeds"])
    assert 3 < number < 8
    assert re.search(r"\d (to \d )?of 8 episodes of a condition are in this page", report.html)
    assert "--replays N" in report.html


# In a browser


@pytest.fixture(scope="module")
def driver():
    webdriver = pytest.importorskip("selenium.webdriver")
    if not (shutil.which(CHROMIUM) and shutil.which(DRIVER)):
        pytest.skip(f"no {CHROMIUM} with {DRIVER}: apt-get install chromium chromium-driver")
    options = webdriver.ChromeOptions()
    options.binary_location = CHROMIUM
    for argument in (
        *("--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage"),
        *("--disable-background-networking", "--disable-component-update", "--disable-sync"),
        *("--no-first-run", "--window-size=1280,900", "--force-prefers-reduced-motion"),
    ):
        options.add_argument(argument)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    service = webdriver.ChromeService(DRIVER)
    with webdriver.Chrome(options=options, service=service) as started:
        yield started


class Replay:
    """A page in a browser."""

    def __init__(self, driver, path, address=""):
        self.driver = driver
        driver.get("about:blank")
        driver.get(path.as_uri() + address)
        self.until(lambda: self.clock is not None)

    def until(self, condition):
        deadline = time.monotonic() + 10
        while not condition():
            assert time.monotonic() < deadline, "waited for ten seconds"
            time.sleep(0.02)

    def run(self, script, *arguments):
        return self.driver.execute_script(script, *arguments)

    def part(self, name):
        return self.driver.find_element("css selector", f'[data-replay="{name}"]')

    def value(self, name):
        return self.part(name).get_property("value")

    @property
    def clock(self):
        text = self.part("clock").get_property("textContent")
        return float(text.split()[0]) if text else None

    @property
    def address(self):
        return self.run("return location.hash")

    def picture(self, side):
        return self.run(
            "return document.querySelector(`[data-replay='${arguments[0]}-stage'] canvas`)"
            ".toDataURL()",
            side,
        )

    def pixels(self, side, colour):
        """Number of pixels of just this colour."""
        return self.run(
            "const at = `[data-replay='${arguments[0]}-stage'] canvas`;"
            "const { width, height } = document.querySelector(at);"
            "const pen = document.querySelector(at).getContext('2d');"
            "const { data } = pen.getImageData(0, 0, width, height);"
            "const colour = arguments[1];"
            "const same = (k) => colour.every((value, c) => data[4 * k + c] === value);"
            "return [...Array(width * height).keys()].filter(same).length;",
            side,
            list(colour),
        )

    def choose(self, name, value):
        self.run(
            "arguments[0].value = arguments[1];"
            "arguments[0].dispatchEvent(new Event('change', {bubbles: true}));",
            self.part(name),
            value,
        )
        self.until(lambda: f"{name}=" in self.address)

    def scrub(self, time):
        self.run(
            "arguments[0].value = arguments[1];"
            "arguments[0].dispatchEvent(new Event('input', {bubbles: true}));",
            self.part("time"),
            time,
        )


@pytest.fixture
def shown(driver, report):
    return Replay(driver, report.page)


def test_page_opens_without_messages(shown):
    assert shown.driver.get_log("browser") == []
    assert shown.driver.title.startswith("tried-v1")
    assert shown.pixels("left", colours.DECK) > 100
    assert shown.value("left") == "scripted"
    assert shown.value("right") == f"{ODD}-0"
    assert shown.clock == 0.0


def test_sides_and_choices_have_pictures_of_their_own(shown):
    seen = {shown.picture("left"), shown.picture("right")}
    assert len(seen) == 2
    shown.choose("right", "random")
    seen.add(shown.picture("right"))
    shown.choose("condition", SUITE.conditions[1].name)
    shown.choose("seed", shown.run("return arguments[0].options[1].value", shown.part("seed")))
    seen.add(shown.picture("right"))
    assert len(seen) == 4
    shown.choose("right", "none")
    assert not shown.part("right-stage").is_displayed()


def test_play_advances_and_pause_stops(shown):
    button = shown.part("play")
    shown.run("arguments[0].value = '4'", shown.part("speed"))  # time enough to look
    assert button.get_attribute("aria-label") == "Play"
    button.click()
    shown.until(lambda: shown.clock > 1.0)
    assert button.get_attribute("aria-label") == "Pause"
    button.click()
    stopped = shown.clock
    time.sleep(0.2)
    assert shown.clock == stopped


def test_playing_ends_where_the_longer_episode_does(shown):
    shown.run("arguments[0].value = '40'", shown.part("speed"))
    shown.part("play").click()
    end = float(shown.part("time").get_attribute("max"))
    shown.until(lambda: shown.part("play").get_attribute("aria-label") == "Play")
    assert shown.clock == pytest.approx(end, abs=0.05)


def test_scrubbing_draws_another_moment(shown):
    before = shown.picture("left")
    shown.scrub(5.0)
    assert shown.clock == 5.0
    assert shown.picture("left") != before
    shown.scrub(0.0)
    assert shown.picture("left") == before


def test_boats_whose_thrusters_died_turn_grey(shown):
    shown.scrub(DEATH - 1)
    assert shown.pixels("left", colours.FAILED) == 0
    shown.scrub(DEATH + 1)
    assert shown.pixels("left", colours.FAILED) > 5


def test_keys_move_and_play(shown):
    slider = shown.part("time")
    shown.run("arguments[0].value = '4'", shown.part("speed"))
    slider.send_keys("\ue014")  # right
    assert shown.clock == 1.0
    slider.send_keys("\ue014\ue014\ue012")  # right, right, left
    assert shown.clock == 2.0
    slider.send_keys("\ue010")  # end
    assert shown.clock > 15.0
    slider.send_keys("\ue011")  # home
    slider.send_keys(" ")
    shown.until(lambda: shown.clock > 0.5)
    slider.send_keys(" ")
    assert shown.part("play").get_attribute("aria-label") == "Play"


def test_address_remembers_the_choice(shown, driver, report):
    shown.choose("condition", SUITE.conditions[1].name)
    shown.choose("left", f"{ODD}-1")
    shown.choose("right", "scripted")
    shown.choose("view", "near")
    shown.scrub(4.0)
    shown.run("arguments[0].dispatchEvent(new Event('change'))", shown.part("time"))
    shown.until(lambda: "t=4.0" in shown.address)
    names = ("condition", "seed", "left", "right", "view")
    chosen, picture = [shown.value(name) for name in names], shown.picture("left")
    again = Replay(driver, report.page, shown.address)
    again.until(lambda: again.clock == 4.0)
    assert [again.value(name) for name in names] == chosen
    assert again.picture("left") == picture


def test_the_link_of_a_condition_leads_to_its_episodes(shown):
    shown.choose("right", "random")
    shown.run("document.querySelectorAll('a.watch')[1].click()")
    shown.until(lambda: shown.value("condition") == SUITE.conditions[1].name)
    assert shown.value("right") == "random"
    shown.until(lambda: shown.run("return scrollY") > 0)


def test_episodes_are_listed_with_their_outcomes(shown, report):
    options = shown.run("return [...arguments[0].options].map((o) => o.text)", shown.part("seed"))
    for text in options:
        seed = int(text.split()[0])
        done = report.results.success("calm", "scripted")[0, seed - 10]
        assert f"scripted {'✓' if done else '✗'}" in text
        count = report.results.success("calm", ODD)[:, seed - 10].sum()
        assert f"{ODD} {count}/2" in text
    groups = shown.run(
        "return [...arguments[0].querySelectorAll('optgroup')].map((g) => g.label)",
        shown.part("seed"),
    )
    assert groups[0].startswith("A policy failed (")
    assert all(label.startswith("No policy but random failed (") for label in groups[1:])
    before = shown.value("seed")
    shown.part("next").click()
    shown.until(lambda: shown.value("seed") != before)


def test_all_fits_a_narrow_window(shown):
    shown.driver.execute_cdp_cmd(
        "Emulation.setDeviceMetricsOverride",
        {"width": 380, "height": 800, "deviceScaleFactor": 2, "mobile": False},
    )
    try:
        assert shown.run("return document.documentElement.scrollWidth") <= 380
        canvas = "document.querySelector('[data-replay=left-stage] canvas')"
        shown.until(lambda: shown.run(f"return {canvas}.width") > 600)
    finally:
        shown.driver.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})


def test_a_browser_that_cannot_unpack_episodes_says_so(driver, report, tmp_path):
    old = tmp_path / "old.html"
    old.write_text(
        report.html.replace("<body>", "<body><script>delete DecompressionStream;</script>")
    )
    driver.get(old.as_uri())
    needs = driver.find_element("css selector", '[data-replay="needs"]')
    assert needs.is_displayed()
    assert "needs JavaScript and a browser of 2023" in needs.text
    assert not driver.find_element("css selector", '[data-replay="root"]').is_displayed()
    assert not [entry for entry in driver.get_log("browser") if entry["level"] == "SEVERE"]


def test_pages_have_colours_in_browsers_that_know_no_newer_functions(report):
    """A colour that a browser cannot read leaves text on no background."""
    text = report.html
    assert "light-dark(" not in text
    light, dark = (dict(re.findall(r"(--\w+): (#\w+);", part)) for part in text.split(":root")[1:3])
    assert light.keys() == dark.keys()
    assert light["--paper"] != dark["--paper"]


def test_obstacles_are_embedded_without_the_walls(tmp_path):
    params = make_params("push", time_limit=1.0, obstacles="dock", water={"walls": 3.0})
    (log,) = runner.run(Idle, params, [0], 1, Label("idle"))
    kept = unpack_log(log.episode, packed(log))
    np.testing.assert_array_equal(kept.obstacle, log.obstacle)
    shown = replay.take(params, kept)["obstacles"]
    np.testing.assert_allclose(np.array(shown)[:, 0], log.obstacle[:3], atol=1e-4)
    corners = [(-2.0, 2.0), (2.0, 2.0), (2.0, 2.5)]
    params = make_params("push", time_limit=1.0, obstacles=[{"corners": corners}])
    (log,) = runner.run(Idle, params, [0], 1, Label("idle"))
    assert replay.take(params, log)["obstacles"] == [[list(corner) for corner in corners]]
