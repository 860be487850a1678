"""Reads NPZ files that may be damaged, or come from a stranger.

NumPy's own reader raises whatever its libraries do, and takes as much memory as a file claims.
"""

import io
import math
import zipfile
from collections.abc import Collection
from pathlib import Path
from typing import Any

import numpy as np

LARGEST = 2**31  #: number of bytes that the arrays of a file may take


def read(path: Path, names: Collection[str] | None = None) -> dict[str, np.ndarray[Any, Any]]:
    """Returns the arrays of a file by their names, or those with some names.

    Nothing is unpickled, and checksums are compared.

    Raises:
        ValueError: the file is no NPZ, is damaged, too large, or lacks one of the names.
        OSError: it cannot be opened.
    """
    with path.open("rb") as file:
        try:
            with zipfile.ZipFile(file) as archive:
                members = {info.filename.removesuffix(".npy"): info for info in archive.infolist()}
                wanted = members if names is None else {name: members[name] for name in names}
                size = sum(info.file_size for info in wanted.values())
                if size > LARGEST:
                    raise ValueError(f"it claims {size:,} bytes, at most {LARGEST:,} are read")
                return {name: _array(archive.read(info)) for name, info in wanted.items()}
        except KeyError as error:
            raise ValueError(f"it has no {error}") from error
        except Exception as error:  # libraries raise whatever they meet
            reason = " ".join(str(error).split())
            raise ValueError(reason or type(error).__name__) from error


def _array(content: bytes) -> np.ndarray[Any, Any]:
    """Returns the array of an NPY file."""
    stream = io.BytesIO(content)
    version = np.lib.format.read_magic(stream)
    header = {
        (1, 0): np.lib.format.read_array_header_1_0,
        (2, 0): np.lib.format.read_array_header_2_0,
    }[version]
    shape, fortran, dtype = header(stream)
    if dtype.hasobject:
        raise ValueError("it holds objects, which are not read")
    count, left = math.prod(shape), len(content) - stream.tell()
    if min(shape, default=0) < 0 or count * dtype.itemsize != left:
        raise ValueError(f"an array of {count:,} times {dtype} has {left:,} bytes")
    if not left:
        return np.zeros(shape, dtype)
    flat = np.frombuffer(content, dtype, offset=stream.tell())
    return flat.reshape(shape, order="F" if fortran else "C").copy()
