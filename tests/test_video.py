"""Videos hold the frames they were given, at the rate asked for."""

import numpy as np
import pytest
from helpers import no_larger_than
from test_render import SIZE, pushed

from asv_env.render import video


@pytest.fixture(scope="module")
def frames():
    return pushed(steps=11)[1]


def test_gif(frames, tmp_path):
    from PIL import Image

    path = video.save(iter(frames), tmp_path / "films" / "push.gif", fps=30)
    with Image.open(path) as film:
        assert film.n_frames == len(frames)
        assert film.size == SIZE
        assert film.info["loop"] == 0
        total = 0
        for k, frame in enumerate(frames):
            film.seek(k)
            total += film.info["duration"]
            error = np.abs(np.asarray(film.convert("RGB"), dtype=int) - frame)
            assert error.mean() < 3
            assert error.max() < 80
    assert total == pytest.approx(1000 * len(frames) / 30, abs=10)
    assert path.stat().st_size < 12_000 * len(frames)


def test_mp4(frames, tmp_path):
    import imageio.v3 as iio

    path = video.save(frames, tmp_path / "push.MP4", fps=25)
    read = iio.imread(path, plugin="FFMPEG")
    assert read.shape == (len(frames), SIZE[1], SIZE[0], 3)
    for frame, again in zip(frames, read, strict=True):
        assert np.abs(frame.astype(int) - again).mean() < 5
    meta = iio.immeta(path, plugin="FFMPEG")
    assert meta["fps"] == 25
    assert meta["pix_fmt"].startswith("yuv420p")


@pytest.mark.parametrize("name", ["push.avi", "push", "push.gif.txt"])
def test_unknown_suffix(frames, tmp_path, name):
    with pytest.raises(ValueError, match=r"\.gif or \.mp4"):
        video.save(frames, tmp_path / name, fps=10)


@pytest.mark.parametrize("name", ["push.gif", "push.mp4"])
def test_nothing_is_overwritten_unasked(frames, tmp_path, name):
    path = tmp_path / name
    path.write_text("precious")
    with pytest.raises(FileExistsError, match="overwrite=True"):
        video.save(frames, path, fps=10)
    assert path.read_text() == "precious"
    video.save(frames, path, fps=10, overwrite=True)
    assert path.stat().st_size > 1000


@pytest.mark.parametrize("fps", [0, -1, np.nan, np.inf, True])
def test_bad_rates(frames, tmp_path, fps):
    with pytest.raises(ValueError, match="fps"):
        video.save(frames, tmp_path / "push.mp4", fps=fps)


@pytest.mark.parametrize(
    ("bad", "name", "match"),
    [
        ([], "a.gif", "no frames"),
        ([np.zeros((64, 64), np.uint8)], "a.gif", "frame 0"),
        ([np.zeros((64, 64, 3))], "a.gif", "uint8"),
        ([np.zeros((64, 64, 3), np.uint8), np.zeros((64, 66, 3), np.uint8)], "a.mp4", "frame 1"),
        ([np.zeros((64, 65, 3), np.uint8)], "a.mp4", "even"),
        ([None], "a.gif", "frame 0"),
    ],
)
def test_bad_frames(tmp_path, bad, name, match):
    with pytest.raises(ValueError, match=match):
        video.save(bad, tmp_path / name, fps=10)
    assert not (tmp_path / name).exists()


def test_gif_refuses_rates_that_viewers_do_not_play(frames, tmp_path):
    with pytest.raises(ValueError, match="50"):
        video.save(frames, tmp_path / "push.gif", fps=60)


@pytest.mark.parametrize("name", ["push.gif", "push.mp4"])
@pytest.mark.parametrize("allowed", [0, 2_000])
def test_on_a_full_disk_the_old_film_stays(frames, tmp_path, name, allowed):
    """At the first byte, and in the middle."""
    path = tmp_path / name
    path.write_text("old")
    with (
        no_larger_than(allowed),
        pytest.raises(
            OSError, match=rf"{name} cannot be written: .*; free space and give"
        ) as error,
    ):
        video.save(frames, path, fps=10, overwrite=True)
    assert "\n" not in str(error.value)
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("name", ["file/push.mp4", "folder.gif"])
def test_what_cannot_be_a_film_is_named(frames, tmp_path, name):
    (tmp_path / "file").write_text("precious")
    (tmp_path / "folder.gif").mkdir()
    with pytest.raises(OSError, match=rf"{name} cannot be written: "):
        video.save(frames, tmp_path / name, fps=10, overwrite=True)


@pytest.mark.parametrize(
    "name", ["-y.mp4", "a:b.mp4", "file:x.mp4", "100%d.mp4", "é ü/ü.gif", "concat:a.mp4"]
)
def test_names_that_encoders_take_for_options_or_protocols(frames, tmp_path, monkeypatch, name):
    monkeypatch.chdir(tmp_path)
    assert video.save(frames[:2], name, fps=10).stat().st_size > 100
    assert [path.relative_to(tmp_path).as_posix() for path in tmp_path.rglob("*.*")] == [name]


def test_a_name_that_is_too_long_is_named_with_a_remedy(frames, tmp_path):
    with pytest.raises(OSError, match=r"xxx.*choose a shorter name"):
        video.save(frames[:2], tmp_path / f"{'x' * 300}.mp4", fps=10)
