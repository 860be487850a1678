"""One run at a time in a folder: evaluation, training, reproduction and publishing share a lock.

The system gives a lock back when its process ends, however it ends. What stays is an empty file.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from filelock import BaseFileLock, FileLock, Timeout

from asv_env.files import named, remove_parts

NAME = ".lock"  #: file name of the lock of a folder


def lock(folder: Path) -> BaseFileLock:
    """Takes a folder, which is made if there is none, for one run; ``release()`` gives it back.

    What killed runs have left half written in it is removed.

    Raises:
        FileExistsError: another run has it, in this process or in another one.
        OSError: nothing can be written there, or its file system knows no locks.
    """
    path = folder / NAME
    with named(folder, "cannot be used"):
        folder.mkdir(parents=True, exist_ok=True)
    with named(path, "cannot be locked"):
        taken = FileLock(path, timeout=0, thread_local=False)
        try:
            taken.acquire()
        except Timeout:
            if not path.exists():  # nothing can be created there
                raise OSError("nothing can be created there; choose another folder") from None
        except NotImplementedError as error:
            raise OSError("its file system knows no locks; choose another folder") from error
    if not taken.is_locked:
        raise FileExistsError(
            f"{folder} is in use by another run: wait for it, or choose another folder with --out"
        )
    try:
        remove_parts(folder)
    except BaseException:
        taken.release()
        raise
    return taken


@contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Takes a folder for the time of a block; see ``lock``."""
    taken = lock(folder)
    try:
        yield
    finally:
        taken.release()
