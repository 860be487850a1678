"""Writes frames to a GIF or an MP4 file."""

import math
import os
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from asv_env import files
from asv_env.types import Frame

SUFFIXES = (".gif", ".mp4")
FASTEST_GIF = 50  #: most frames per second that viewers play of a GIF
SAMPLES = 12  #: number of frames from which the palette of a GIF is made
RARITY = 0.5  #: power of a colour's pixels that is its weight; with 1 most colours were of water
COLOURS = 255  #: number of colours in the palette; one more stands for pixels that do not change
QUALITY = 20  #: constant rate factor of H.264: 18 looks like the original, 28 is coarse


def save(
    frames: Iterable[Frame], path: str | os.PathLike[str], fps: float, overwrite: bool = False
) -> Path:
    """Writes frames to a video and returns its path.

    Args:
        frames: each (height, width, 3) uint8, all of one size; for MP4 both sides even.
        path: ends in ".gif" or ".mp4"; missing folders are made.
        fps: frames per second, at most 50 for a GIF.
        overwrite: whether a file that exists may be replaced.

    Raises:
        ValueError: one of these is not so, or there are no frames.
        FileExistsError: the file exists and ``overwrite`` is False.
    """
    path = Path(path)
    suffix = path.suffix.lower()
    if suffix not in SUFFIXES:
        raise ValueError(f"{path}: unknown video suffix {path.suffix!r}; use .gif or .mp4")
    if isinstance(fps, bool) or not (math.isfinite(fps) and fps > 0):
        raise ValueError(f"fps = {fps!r}: must be a positive number")
    if suffix == ".gif" and fps > FASTEST_GIF:
        raise ValueError(f"fps = {fps!r}: a GIF plays at most {FASTEST_GIF} frames a second")
    if os.path.exists(path) and not overwrite:  # False where the name cannot be one
        raise FileExistsError(f"{path} exists; pass overwrite=True to replace it")
    checked = _checked(frames)
    save = {".gif": _save_gif, ".mp4": _save_mp4}[suffix]
    files.write(path, lambda part: save(checked, part, fps))
    return path


def _checked(frames: Iterable[Frame]) -> list[Frame]:
    checked = [np.asarray(frame) for frame in frames]
    if not checked:
        raise ValueError("no frames to save")
    for k, frame in enumerate(checked):
        fine = frame.ndim == 3 and frame.shape[2] == 3 and frame.dtype == np.uint8
        if not fine or frame.shape != checked[0].shape:
            raise ValueError(
                f"frame {k} of shape {frame.shape} and type {frame.dtype}: must be "
                f"(height, width, 3) uint8 like the first, {checked[0].shape}"
            )
    return checked


def _save_gif(frames: list[Frame], path: Path, fps: float) -> None:
    """Writes one palette for all frames, without dithering: what does not change costs nothing."""
    from PIL import Image  # an extra

    palette = _palette(Image, frames)
    plain = Image.Dither.NONE
    indexed = [Image.fromarray(frame).quantize(palette=palette, dither=plain) for frame in frames]
    # Whole hundredths of a second whose sum does not drift from the true time.
    times = np.round(100 * np.arange(len(frames) + 1) / fps).astype(int)
    durations = (10 * np.diff(times)).tolist()
    first, *others = indexed
    first.save(
        path, "GIF", save_all=True, append_images=others, duration=durations, loop=0, optimize=True
    )


def _palette(image: Any, frames: Sequence[Frame]) -> Any:
    """Returns an image whose palette suits all frames, also their rare colours."""
    chosen = np.unique(np.linspace(0, len(frames) - 1, SAMPLES).round().astype(int))
    pixels = np.concatenate([frames[k].reshape(-1, 3) for k in chosen]).astype(np.int32)
    packed, counts = np.unique(pixels @ (1 << 16, 1 << 8, 1), return_counts=True)
    weighed = np.repeat(packed, np.ceil(counts**RARITY).astype(int))
    colours = np.stack([weighed >> 16, weighed >> 8 & 255, weighed & 255], axis=-1)
    swatch = image.fromarray(colours[None].astype(np.uint8))
    return swatch.quantize(COLOURS, method=image.Quantize.MEDIANCUT, kmeans=2)


def _save_mp4(frames: list[Frame], path: Path, fps: float) -> None:
    height, width = frames[0].shape[:2]
    if height % 2 or width % 2:
        raise ValueError(f"frames of {width} x {height} px: MP4 needs even sides")
    from imageio_ffmpeg import count_frames_and_secs, write_frames  # an extra

    output = ["-crf", str(QUALITY), "-movflags", "+faststart"]
    size = width, height
    writer = write_frames(
        os.fspath(path), size, fps=fps, codec="libx264", macro_block_size=2, output_params=output
    )
    writer.send(None)
    try:
        for frame in frames:
            writer.send(np.ascontiguousarray(frame))
        writer.close()
        complete = path.exists() and count_frames_and_secs(os.fspath(path))[0] == len(frames)
    except (OSError, RuntimeError):  # with the whole command of the encoder in its text
        complete = False
    finally:
        writer.close()
    if not complete:
        raise OSError(f"the encoder has failed, as it says above; {files.SPACE}")
