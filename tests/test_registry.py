"""Things by name: what ``"module:NAME"`` finds and what not, and files that get in the way."""

import statistics
import sys
from pathlib import Path

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from asv_env import DIFFICULTIES, FEATURES, HULLS, OBSTACLES, SCENARIOS, TASKS, make_params
from asv_env.registry import LoadError, Registry, WrongKindError, load

REGISTRIES = (TASKS, SCENARIOS, HULLS, FEATURES, DIFFICULTIES, OBSTACLES)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """An empty current folder, in which Python does not look for modules."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", [place for place in sys.path if place])
    known = set(sys.modules)
    yield tmp_path
    for name in set(sys.modules) - known:
        del sys.modules[name]


def test_module_of_the_current_folder_is_found_and_what_it_imports(folder):
    (folder / "sibling_.py").write_text("MURKY = {'sensors': {'position_noise': 0.5}}")
    (folder / "own_.py").write_text("from sibling_ import MURKY")
    assert make_params(scenario="own_:MURKY").sensors.position_noise == 0.5
    assert sys.path[-1] == str(folder)


def test_module_of_another_alphabet_and_of_a_package_is_found(folder):
    (folder / "пакет").mkdir()
    (folder / "пакет/größe.py").write_text("ÄNDERUNG = {'length': 0.6}")
    assert make_params(vessel="пакет.größe:ÄNDERUNG").vessel.length == 0.6


@pytest.mark.parametrize("name", ["statistics", "numpy", "asv_env", "wave"])
def test_file_of_the_current_folder_takes_the_place_of_no_library(folder, name):
    (folder / f"{name}.py").write_text("raise SystemExit('shadow')")
    (folder / "own_.py").write_text("LONG = {'length': 0.6}")
    sys.modules.pop("wave", None)
    load("own_:LONG")
    with pytest.raises(LoadError, match="not the file in the current folder: give that file"):
        load(f"{name}:LONG")
    import wave

    assert Path(wave.__file__).parent == Path(statistics.__file__).parent


def test_current_folder_is_only_looked_in_for_what_is_asked_for(folder):
    before = list(sys.path)
    with pytest.raises(LoadError, match="No module named 'no_module_'"):
        load("no_module_:NAME")
    load("statistics:mean")
    assert sys.path == before


def test_folder_that_has_the_name_of_a_module_does_not_hide_it(folder, monkeypatch):
    (folder / "elsewhere/own_").mkdir(parents=True)
    (folder / "own_.py").write_text("LONG = {'length': 0.6}")
    monkeypatch.syspath_prepend(str(folder / "elsewhere"))
    assert load("own_:LONG") == {"length": 0.6}


@pytest.mark.parametrize(
    ("code", "message"),
    [
        ("def broken(:", "failed with SyntaxError: .*own_.py, line 1"),
        ("1 / 0", "failed with ZeroDivisionError: division by zero"),
        ("raise SystemExit(3)", "failed with SystemExit: 3"),
        ("import no_module_", "failed with ModuleNotFoundError: No module named 'no_module_'"),
        ("raise ValueError('a\\n\\x1b[31mb' + 'c' * 10**6)", "failed with ValueError: a \\\\x1b"),
        (
            "class E(Exception):\n def __str__(self): 1 / 0\nraise E",
            "failed with E: its text cannot be read",
        ),
        ("def __getattr__(name): raise AttributeError(name)", "has no attribute 'NAME'"),
        ("OTHER = 1", r"has no attribute 'NAME' \(.*own_.py\)"),
    ],
)
def test_error_of_a_module_is_one_line_that_names_it(folder, code, message):
    (folder / "own_.py").write_text(code)
    for kind in (ValueError, ImportError):
        with pytest.raises(kind, match=f"^task = 'own_:NAME': .*{message}") as caught:
            make_params("own_:NAME")
    assert str(caught.value).isprintable()
    assert len(str(caught.value)) < 500


def test_interrupt_while_a_module_is_imported_goes_on(folder):
    (folder / "own_.py").write_text("raise KeyboardInterrupt")
    with pytest.raises(KeyboardInterrupt):
        load("own_:NAME")


@given(word=st.text(st.sampled_from(":.ab_ /\\-é\n\0"), max_size=6))
@example("")
@example(":")
@example("a:")
@example(":b")
@example("a:b:c")
@example(".a:b")
@example("a.:b")
@example("..:b")
@example("a b:c")
@example("os:path.join")
def test_word_of_another_form_is_refused(word):
    with pytest.raises(LoadError):
        load(word)


@pytest.mark.parametrize("registry", REGISTRIES, ids=lambda registry: registry._kind)
@pytest.mark.parametrize(
    "word", ["os:path", "math:pi", "sys:version", 3, None, ["nominal"]], ids=repr
)
def test_thing_of_another_kind_is_refused(registry, word):
    for kind in (TypeError, ValueError, WrongKindError):
        with pytest.raises(kind, match=f"give the name of a {registry._kind}"):
            registry.find(word)
    if not isinstance(word, str):
        with pytest.raises(WrongKindError):
            registry.register("another_", word)
    assert "another_" not in registry


@pytest.mark.parametrize("name", ["", "a:b", 3, None, ("a",)], ids=repr)
def test_what_cannot_be_a_name_is_refused(name):
    with pytest.raises(ValueError, match="name"):
        Registry("thing").register(name, 1)
    assert name not in Registry("thing")


def test_registered_word_is_imported_when_it_is_asked_for(folder):
    things = Registry("thing", {"late": "own_:NAME"}, lambda thing: thing == 1)
    with pytest.raises(LoadError, match="No module named"):
        things["late"]
    (folder / "own_.py").write_text("NAME = 1")
    assert things["late"] == things.find("late") == 1
    with pytest.raises(ValueError, match="Did you mean 'late'"):
        things.find("lat")
