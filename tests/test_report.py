"""The report of an evaluation: its numbers, its figures and, in a browser, its replay."""

import base64
import html.parser
import json
import re
import shutil
import time
import zlib
from types import SimpleNamespace

import numpy as np
import pytest

from asv_env.render import colours
from asv_env.tasks import TASKS
from baselines.evaluate.conditions import Condition, Suite
from baselines.evaluate.report import (
    bars,
    charts,
    document,
    durations,
    maps,
    packing,
    placement,
    replay,
    svg,
)
from baselines.evaluate.results import Results
from baselines.evaluate.store import Series, Store
from baselines.evaluate.summary import summarise
from baselines.evaluate.tables import formats, table
from baselines.rollout.episodes import (
    CAUSES,
    COLUMNS,
    Episode,
    PoseLog,
)

CHROMIUM, DRIVER = "/usr/bin/chromium", "/usr/bin/chromedriver"
ODD = "learned </script> & |$more$|"
SUITE = Suite(
    "tried-v1",
    "Episodes that were never run.",
    (
        Condition("calm", "goals over the plane"),
        Condition("rough & <windy>", "the same, scenario `noisy`", "calm", scenario="noisy"),
    ),
    seed=10,
    episodes=8,
)
POLICIES = {  # by name: fingerprints, one a training, and the share of successes
    "scripted": (["scripted"], 0.9),
    ODD: (["00112233445566aa", "00112233445566bb"], 0.5),
    "random": (["random"], 0.0),
}
DIES = 1  # boat whose thrusters die, in all episodes, after
DEATH = 6.0  # s


def invented_row(condition, policy, training, seed, share):
    rng = np.random.default_rng([seed, len(policy), training or 0])
    broken = policy != "scripted" and seed % 5 == 0
    success = not broken and bool(rng.random() < share)
    cause = "policy error" if broken else CAUSES[1 + seed % (len(CAUSES) - 1)]
    closed = success or cause not in ("policy error", "strayed", "no closure")
    away, ended = 0.02 + 0.2 * (not success), 20.0 + 10 * rng.random()
    values = dict.fromkeys(COLUMNS, 1.0) | {
        "seed": seed,
        "policy": policy,
        "training_seed": training,
        "condition": condition.name,
        "task": condition.task,
        "scenario": condition.scenario,
        "num_boats": condition.params.num_boats,
        "success": success,
        "cause": None if success else cause,
        "goal_x": rng.uniform(-1, 1),
        "goal_y": rng.uniform(-1, 1),
        "position_error": away * rng.uniform(0.5, 1.0),
        "min_position_error": away * rng.uniform(0.5, 1.0),
        "heading_error_at_min": rng.normal(0.0, 0.05),
        "time_to_closure": 0.4 * ended if closed else None,
        "closure_spread": 1.0 if closed else None,
        "time_to_goal": ended if success else None,
        "duration": round(ended, 1),
        "collisions": 2,
        "closure_lost": 0,
        "error": "ValueError: <no> | use" if broken else None,
    }
    values |= dict.fromkeys(TASKS[condition.task].not_applicable)
    return Episode(**values)


def invented_track(row):
    """Boats on circles round a vessel that drifts."""
    rng = np.random.default_rng(row.seed)
    times = np.append(np.arange(0.0, row.duration, 0.2), row.duration)
    poses = np.empty((len(times), 1 + row.num_boats, 3))
    for body in range(1 + row.num_boats):
        radius, speed, phase = (
            (1.0 if body else 0.1) * rng.uniform(0.5, 1.5),
            0.2,
            rng.uniform(0, 6),
        )
        angle = phase + speed * times * (1 if len(row.policy) % 2 else -1)
        poses[:, body] = np.stack(
            [radius * np.cos(angle), radius * np.sin(angle), (angle + 4) % (2 * np.pi) - np.pi], -1
        )
    failed = np.full(row.num_boats, np.inf)
    failed[DIES] = DEATH
    goal = np.array([row.goal_x or 0.0, row.goal_y or 0.0, 0.3])
    return PoseLog(row, poses, goal, failed)


def invented(folder, suite=SUITE, policies=POLICIES, replays=3):
    """A report on invented episodes, and all that it was made from."""
    rows = {
        (condition.name, name): [
            [
                invented_row(condition, name, number if len(prints) > 1 else None, seed, share)
                for seed in suite.seeds
            ]
            for number in range(len(prints))
        ]
        for condition in suite.conditions
        for name, (prints, share) in policies.items()
    }
    results = Results(suite, tuple(policies), rows)
    prints = {name: prints for name, (prints, _) in policies.items()}
    origin = {
        "set of episodes": "feedfeedfeedfeed",
        "state of the code": "c0dec0dec0dec0de",
        "set of libraries": {"numpy": "2.0"},
    }
    store = Store(folder, {}, prints, replace=False)
    for (condition, policy), trainings in rows.items():
        for number, training in enumerate(trainings):
            for row in training:
                store.add(Series(condition, policy, number), invented_track(row))
    summary = {
        "suite": suite.name,
        "about": suite.about,
        "seeds": [suite.seeds[0], suite.seeds[-1]],
        "origin": origin,
        "policies": prints,
        **summarise(results),
    }
    page, twin = document.write(folder, results, summary, store, replays)
    return SimpleNamespace(
        page=page, html=page.read_text(), markdown=twin.read_text(), results=results,
        summary=summary, store=store, cast=replay.cast(results, prints),
    )  # fmt: skip


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    return invented(tmp_path_factory.mktemp("report"))


class Page(html.parser.HTMLParser):
    """What a page holds; fails where tags do not match."""

    VOID = {"meta", "link", "input", "br"}

    def __init__(self, text):
        super().__init__()
        self.open, self.ids, self.links, self.cells, self.data = [], [], [], [], {}
        self.tags, self.text = [], ""
        self.feed(text)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag, attributes):
        found = dict(attributes)
        self.tags.append((tag, found))
        self.ids += [found["id"]] if "id" in found else []
        self.links += [found[k] for k in ("href", "src", "xlink:href") if k in found]
        if tag in ("td", "th"):
            self.cells.append("")
        if tag not in self.VOID:
            self.open.append((tag, found))

    def handle_startendtag(self, tag, attributes):
        self.handle_starttag(tag, attributes)
        self.handle_endtag(tag)

    def handle_endtag(self, tag):
        assert self.open
        assert self.open.pop()[0] == tag

    def handle_data(self, text):
        tags = [tag for tag, _ in self.open]
        self.text += text if "script" not in tags else ""
        if "td" in tags or "th" in tags:
            self.cells[-1] += text
        elif tags and tags[-1] == "script" and "type" in self.open[-1][1]:
            self.data[self.open[-1][1].get("data-condition", "world")] = json.loads(text)


@pytest.fixture(scope="module")
def page(made):
    return Page(made.html)


def tables(summary):
    yield from (table.results(summary), table.measures(summary), table.comparisons(summary))
    yield table.controls(summary)
    yield from (table.of_condition(summary, condition) for condition in summary["conditions"])


# What the page is made of


def test_page_needs_nothing_beside_it(made, page):
    assert not re.search(r"https?:|@import|url\((?!#|\"data:)", made.html)
    assert [link for link in page.links if not link.startswith(("#", "data:"))] == []


def test_names_in_the_page_are_unique_and_all_links_lead_somewhere(page):
    assert len(set(page.ids)) == len(page.ids)
    targets = {link[1:] for link in page.links if link.startswith("#") and "=" not in link}
    assert targets <= set(page.ids)


def test_every_figure_is_described(page):
    drawings = [found for tag, found in page.tags if tag == "svg" and found.get("role") == "img"]
    assert len(drawings) == 1 + 2 * 6  # the overview, and six of each condition
    assert all(found["aria-label"] for found in drawings)


def test_page_and_twin_hold_all_cells_of_all_tables(made, page):
    shown = iter(page.cells)
    for one in tables(made.summary):
        for row in one.rows:
            for column, cell in zip(one.columns, row, strict=True):
                if column.head not in (
                    "condition",
                    "control",
                ):  # which stand once for several lines
                    assert cell in shown, cell
            line = " | ".join(cell.replace("|", "\\|") for cell in row)
            assert f"| {line} |\n" in made.markdown


def test_numbers_are_those_of_the_rows(made):
    shown = table.results(made.summary)
    line = dict(zip(shown.titles, shown.rows[0], strict=True))
    success = made.results.success("calm", "scripted")
    assert line["success"] == f"{success.mean():.1%}"
    assert sum(map(int, re.findall(r"\d+", line["failures"]))) == (~success).sum()
    distance = 100 * np.median(made.results.column("calm", "scripted", "min_position_error"))
    assert table.measures(made.summary).rows[0][2] == f"{distance:.2f}"


def test_table_of_the_terminal_has_a_line_a_policy_and_arm(made):
    lines = table.text_table(made.summary).splitlines()
    assert len(lines) == 1 + 2 * 3
    assert lines[1].startswith("calm             scripted")
    assert "95 % interval" in lines[0]
    assert lines[0].encode("ascii")


def test_what_was_run_is_told(made):
    for text in (made.html, made.markdown):
        for words in ("tried-v1", "seeds 10 to 17", "00112233445566bb", "c0dec0de", "numpy"):
            assert words in text


def test_broken_episodes_are_named(made, page):
    broken = [row for row in made.results if row.error]
    assert {row.policy for row in broken} == {ODD, "random"}
    for row in broken:
        number = "" if row.training_seed is None else f", training {row.training_seed}"
        line = f"{row.policy}{number}, {row.condition}, seed {row.seed}: ValueError: <no> | use"
        assert line in page.text
        assert line in made.markdown


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        (formats.share(0.983), "98.3%"),
        (formats.quantity(-0.0004, "cm"), "0.00"),
        (formats.quantity(-0.0123, "rad"), "−0.012"),
        (formats.quantity(0.012, "cm", 100.0), "1.20"),
        (formats.quantity(None, "s"), "–"),
        (formats.estimate({"value": 2.0, "low": None, "high": None}, "s"), "2.0"),
        (formats.points({"value": -0.05, "low": -0.1, "high": 0.02}), "−5.0 [−10.0, +2.0]"),
        (formats.share_estimate({"value": 0.5, "low": 0.25, "high": 0.75}), "50.0% [25.0, 75.0]"),
        (formats.p_value(0.00002), "< 0.001"),
        (formats.p_value(0.25), "0.250"),
        (formats.p_value(None), "–"),
    ],
)
def test_numbers_are_written_alike_everywhere(text, wanted):
    assert text == wanted


# Any evaluation has a report


@pytest.mark.parametrize(
    ("task", "share"), [("approach", 1.0), ("push", 0.0), ("transport", 0.0), ("transport", 1.0)]
)
def test_one_episode_of_one_policy_is_enough(task, share, tmp_path):
    suite = Suite(
        "one-v1", "A single episode.", (Condition("only", task=task),), seed=3, episodes=1
    )
    made = invented(tmp_path, suite, {"own": (["aabbccddeeff0011"], share)})
    found = Page(made.html)
    assert found.data["only"]["seeds"] == [3]
    assert ("smallest distance" in made.markdown) == (task != "approach")
    assert "Comparison" not in made.html
    assert "nan" not in " ".join(found.cells)


def test_report_stands_without_a_replay(tmp_path):
    made = invented(tmp_path, replays=0)
    assert "0 of 8 episodes of a condition" in made.html
    assert 'class="watch"' not in made.html


def test_goals_are_drawn_only_where_they_differ(made):
    condition = Condition("fixed", options={"goal": (0.5, -0.9, 0.1)})
    with svg.look():
        names = [chart.name for chart in charts.of_condition(made.results, SUITE.conditions[0], {})]
        results = Results(
            SUITE,
            made.results.policies,
            {("fixed", p): made.results.rows["calm", p] for p in made.results.policies},
        )
        fixed = [chart.name for chart in charts.of_condition(results, condition, {})]
    assert names == ["profile", "times", "failures", "errors", "goals"]
    assert fixed == ["profile", "times", "failures", "errors"]


COLOURS = {"one": "#0072B2", "other": "#D55E00"}
MISSING = np.full((1, 1), np.nan)


@pytest.mark.parametrize("episodes", [1, 3000])
@pytest.mark.parametrize("done", [False, True])
def test_figures_stand_few_and_many_episodes_none_or_all_done(episodes, done):
    rng = np.random.default_rng(0)
    success = np.full((2, episodes), done)
    times = rng.uniform(20, 60, (2, episodes))
    outline = np.array([[0.2, 0.1], [-0.2, 0.1], [-0.2, -0.1], [0.2, -0.1]])
    with svg.look():
        drawn = [
            durations.profile({"one": np.where(success, times, np.inf)}, 60.0, COLOURS),
            durations.times(
                {"one": np.where(success, times, np.nan), "other": MISSING}, "time", 60.0, COLOURS
            ),
            bars.failures(
                {"one": {} if done else {"strayed": episodes}, "other": {"not settled": 1}},
                {"one": episodes, "other": 1},
            ),
            placement.errors(
                {"one": 10 * rng.random((2, episodes)), "other": MISSING},
                {"one": rng.normal(size=(2, episodes)), "other": MISSING},
                {"one": success, "other": np.zeros((1, 1), dtype=bool)},
                (5.0, 0.1),
                ((4.88, 1.8), (-0.26, 0.44)),
                COLOURS,
            ),
            maps.goals(rng.normal(size=(episodes, 2)), {"one": success}, outline, 1.2, COLOURS),
            maps.paths({"one": [rng.random((9, 2))]}, {"one": [done]}, outline, None, COLOURS),
            bars.overview(["a"], [None], {"one": np.array([[done, 0.0, 1.0]])}, COLOURS),
        ]
        texts = [svg.inline(figure, f"f{k}", "about") for k, figure in enumerate(drawn)]
    for text in texts:
        Page(text)
        assert "nan" not in text
        assert len(text) < 400_000


def test_labels_of_axes_are_kept_to_the_last_digit():
    with svg.look():
        figure = durations.times({"one": np.array([[0.001]])}, "time", 0.005, COLOURS)
        figure.axes[0].set_xticks([0.0, 0.00125])
        drawn = svg.inline(figure, "f", "about")
    assert ">0.00125<" in drawn
    assert not re.search(r"[ \"]\d+\.\d{3}", drawn)


# What is replayed


def unpacked(text, frames):
    """Poses (T, B, 3) as the page unpacks them, headings not wrapped."""
    planes = np.frombuffer(zlib.decompress(base64.b64decode(text)), np.uint8).reshape(2, -1)
    unsigned = planes[0].astype(np.int64) | planes[1].astype(np.int64) << 8
    bends = ((unsigned >> 1) ^ -(unsigned & 1)).reshape(-1, 3, frames)
    return np.moveaxis(bends.cumsum(axis=-1).cumsum(axis=-1), -1, 0) * np.array(packing.UNITS)


def test_poses_in_the_page_are_those_of_the_store(made, page):
    for condition in SUITE.conditions:
        block = page.data[condition.name]
        for player in made.cast.players:
            for seed, take in zip(block["seeds"], block["takes"][player.key], strict=True):
                track = made.store.log(Series(condition.name, player.policy, player.number), seed)
                poses = unpacked(take["poses"], take["frames"])
                wanted = packing.thinned(condition.params, track.poses)
                off = poses - wanted
                off[..., 2] = (off[..., 2] + np.pi) % (2 * np.pi) - np.pi
                assert np.abs(off).max() <= 0.5001e-3
                assert take["end"] == track.episode.duration
                assert take["failures"][DIES] == DEATH


def test_headings_are_packed_without_drift_over_many_turns():
    poses = np.zeros((500, 2, 3))
    poses[:, 1, 2] = (np.arange(500) * 2.9 + np.pi) % (2 * np.pi) - np.pi
    poses[:, 1, 0] = 27.8
    back = unpacked(packing.pack(poses), 500)
    off = (back - poses)[:, 1]
    assert np.abs(off[:, 0]).max() < 1e-9
    assert np.abs((off[:, 2] + np.pi) % (2 * np.pi) - np.pi).max() < 1e-3


def test_first_episodes_are_embedded_and_as_many_failures(made):
    assert made.cast.trivial == ["random"]
    seeds = replay.chosen(made.results, "calm", made.cast, 2)
    assert seeds[:2] == [10, 11]
    assert len(seeds) <= 4
    judged = [made.results.success("calm", name) for name in ("scripted", ODD)]
    failed = ~np.concatenate(judged).all(axis=0)
    assert all(failed[seed - 10] for seed in seeds[2:])
    assert replay.chosen(made.results, "calm", made.cast, 99) == list(range(10, 18))


def test_page_says_how_many_episodes_it_embeds(made, page):
    number = len(page.data["calm"]["seeds"])
    assert 3 < number < 8
    assert re.search(r"\d (to \d )?of 8 episodes of a condition are in this page", made.html)
    assert "--replays N" in made.html


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
def watched(driver, made):
    return Replay(driver, made.page)


def test_page_opens_without_complaints(watched):
    assert watched.driver.get_log("browser") == []
    assert watched.driver.title.startswith("tried-v1")
    assert watched.pixels("left", colours.DECK) > 100
    assert watched.value("left") == "scripted"
    assert watched.value("right") == f"{ODD}-0"
    assert watched.clock == 0.0


def test_sides_and_choices_have_pictures_of_their_own(watched):
    seen = {watched.picture("left"), watched.picture("right")}
    assert len(seen) == 2
    watched.choose("right", "random")
    seen.add(watched.picture("right"))
    watched.choose("condition", SUITE.conditions[1].name)
    watched.choose(
        "seed", watched.run("return arguments[0].options[1].value", watched.part("seed"))
    )
    seen.add(watched.picture("right"))
    assert len(seen) == 4
    watched.choose("right", "none")
    assert not watched.part("right-stage").is_displayed()


def test_play_advances_and_pause_stops(watched):
    button = watched.part("play")
    watched.run("arguments[0].value = '4'", watched.part("speed"))  # time enough to look
    assert button.get_attribute("aria-label") == "Play"
    button.click()
    watched.until(lambda: watched.clock > 1.0)
    assert button.get_attribute("aria-label") == "Pause"
    button.click()
    stopped = watched.clock
    time.sleep(0.2)
    assert watched.clock == stopped


def test_playing_ends_where_the_longer_episode_does(watched):
    watched.run("arguments[0].value = '40'", watched.part("speed"))
    watched.part("play").click()
    end = float(watched.part("time").get_attribute("max"))
    watched.until(lambda: watched.part("play").get_attribute("aria-label") == "Play")
    assert watched.clock == pytest.approx(end, abs=0.05)


def test_scrubbing_draws_another_moment(watched):
    before = watched.picture("left")
    watched.scrub(5.0)
    assert watched.clock == 5.0
    assert watched.picture("left") != before
    watched.scrub(0.0)
    assert watched.picture("left") == before


def test_boats_whose_thrusters_died_turn_grey(watched):
    watched.scrub(DEATH - 1)
    assert watched.pixels("left", colours.FAILED) == 0
    watched.scrub(DEATH + 1)
    assert watched.pixels("left", colours.FAILED) > 5


def test_keys_move_and_play(watched):
    slider = watched.part("time")
    watched.run("arguments[0].value = '4'", watched.part("speed"))
    slider.send_keys("\ue014")  # right
    assert watched.clock == 1.0
    slider.send_keys("\ue014\ue014\ue012")  # right, right, left
    assert watched.clock == 2.0
    slider.send_keys("\ue010")  # end
    assert watched.clock > 15.0
    slider.send_keys("\ue011")  # home
    slider.send_keys(" ")
    watched.until(lambda: watched.clock > 0.5)
    slider.send_keys(" ")
    assert watched.part("play").get_attribute("aria-label") == "Play"


def test_address_remembers_the_choice(watched, driver, made):
    watched.choose("condition", SUITE.conditions[1].name)
    watched.choose("left", f"{ODD}-1")
    watched.choose("right", "scripted")
    watched.choose("view", "near")
    watched.scrub(4.0)
    watched.run("arguments[0].dispatchEvent(new Event('change'))", watched.part("time"))
    watched.until(lambda: "t=4.0" in watched.address)
    names = ("condition", "seed", "left", "right", "view")
    chosen, picture = [watched.value(name) for name in names], watched.picture("left")
    again = Replay(driver, made.page, watched.address)
    again.until(lambda: again.clock == 4.0)
    assert [again.value(name) for name in names] == chosen
    assert again.picture("left") == picture


def test_an_arm_leads_to_its_episodes(watched):
    watched.choose("right", "random")
    watched.run("document.querySelectorAll('a.watch')[1].click()")
    watched.until(lambda: watched.value("condition") == SUITE.conditions[1].name)
    assert watched.value("right") == "random"
    watched.until(lambda: watched.run("return scrollY") > 0)


def test_episodes_can_be_picked_by_what_became_of_them(watched, made):
    options = watched.run(
        "return [...arguments[0].options].map((o) => o.text)", watched.part("seed")
    )
    for text in options:
        seed = int(text.split()[0])
        done = made.results.success("calm", "scripted")[0, seed - 10]
        assert f"scripted {'✓' if done else '✗'}" in text
        count = made.results.success("calm", ODD)[:, seed - 10].sum()
        assert f"{ODD} {count}/2" in text
    groups = watched.run(
        "return [...arguments[0].querySelectorAll('optgroup')].map((g) => g.label)",
        watched.part("seed"),
    )
    assert groups[0].startswith("A policy failed (")
    assert all(label.startswith("No policy but random failed (") for label in groups[1:])
    before = watched.value("seed")
    watched.part("next").click()
    watched.until(lambda: watched.value("seed") != before)


def test_all_fits_a_narrow_window(watched):
    watched.driver.execute_cdp_cmd(
        "Emulation.setDeviceMetricsOverride",
        {"width": 380, "height": 800, "deviceScaleFactor": 2, "mobile": False},
    )
    try:
        assert watched.run("return document.documentElement.scrollWidth") <= 380
        canvas = "document.querySelector('[data-replay=left-stage] canvas')"
        watched.until(lambda: watched.run(f"return {canvas}.width") > 600)
    finally:
        watched.driver.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})
