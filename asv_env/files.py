"""Files that are written all at once, and errors that name the file and a remedy.

A file is written beside the one that it replaces, brought to the disk, and renamed. So whoever
reads it, is killed or finds the disk full, finds the old file or the new one, whole.
"""

import errno
import os
import platform
import secrets
import shutil
import stat
import time
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

PREFIX = ".part-"  #: beginning of the names of files that are half written
LONGEST_SUFFIX = 16  #: letters of a suffix that such a name keeps
OLD = 86400.0  #: age from which on such a file of another machine is of a killed run, s
SPACE = "free space and give the same command: what is finished is kept"
PERMISSION = "choose another place, or change its permissions"
REMEDIES = {
    **dict.fromkeys((errno.ENOSPC, errno.EDQUOT, errno.EFBIG), SPACE),
    **dict.fromkeys((errno.EACCES, errno.EPERM, errno.EROFS), PERMISSION),
    errno.ENAMETOOLONG: "choose a shorter name",
    errno.EISDIR: "name a file, not a folder",
    errno.ELOOP: "remove the link",
}
"""What to do about errors of the system."""
ELSEWHERE = "choose another place"  #: what to do about any other

_under_way: set[str] = set()


def write(path: str | os.PathLike[str], save: Callable[[Path], object]) -> None:
    """Writes a file all at once: whoever reads it, or is killed, leaves the old or the new one.

    Missing folders are made. A link stays, and its target is replaced. The file has the permissions
    of the one that it replaces, else those of any new file.

    Args:
        path: file that is written or replaced.
        save: writes the file under the name that it is given, which has the same suffix.

    Raises:
        OSError: the file cannot be written; the message names it and a remedy. It is of the kind
            that Python has for the cause, such as PermissionError.
    """
    path = Path(path)
    with named(path):
        target = Path(os.path.realpath(path))
        mode = _mode(target)
        target.parent.mkdir(parents=True, exist_ok=True)
        part = target.with_name(_part_name(target.suffix))
        _under_way.add(part.name)
        try:
            save(part)
            with part.open("rb+") as file:
                os.fsync(file.fileno())
            if mode is not None:
                with suppress(PermissionError):  # of file systems that know no permissions
                    part.chmod(mode)
            part.replace(target)
        finally:
            _under_way.discard(part.name)
            part.unlink(missing_ok=True)


def write_bytes(path: str | os.PathLike[str], content: bytes) -> None:
    """Writes bytes all at once; see ``write``."""
    write(path, lambda part: part.write_bytes(content))


def write_text(path: str | os.PathLike[str], text: str) -> None:
    """Writes a text file in UTF-8 all at once, line ends as they are; see ``write``.

    What UTF-8 cannot express, such as parts of strange file names, is escaped.
    """
    write_bytes(path, text.encode(errors="backslashreplace"))


@contextmanager
def named(path: str | os.PathLike[str], what: str = "cannot be written") -> Iterator[None]:
    """Turns errors of the system into those that name a file, and a remedy.

    An error of a library that follows from one of the system counts as that one.
    """
    try:
        yield
    except Exception as error:
        cause = _system_error(error)
        if cause is None:
            raise
        raise _worded(cause, f"{path} {what}") from error


def remove_parts(folder: Path) -> None:
    """Removes what killed runs have left half written, but nothing that is being written."""
    for part in folder.glob(f"{PREFIX}*"):
        with named(part, "cannot be removed"):
            if _is_stale(part):
                part.unlink(missing_ok=True)


def remove(path: Path) -> None:
    """Removes a file, a link, or a folder with all that is in it, if it is there."""
    with named(path, "cannot be removed"):
        if path.is_dir() and not path.is_symlink():
            shutil.rmtree(path)
        else:
            path.unlink(missing_ok=True)


def _mode(target: Path) -> int | None:
    """Returns the permissions of a file, None where there is none; refuses what is no file."""
    try:
        mode = target.stat().st_mode
    except FileNotFoundError:
        return None
    if stat.S_ISDIR(mode):
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))
    if not stat.S_ISREG(mode):
        raise OSError(errno.EINVAL, "It is not a regular file")
    if not os.access(target, os.W_OK):
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))
    return stat.S_IMODE(mode)


def _machine() -> str:
    return f"{zlib.crc32(platform.node().encode()):08x}"


def _part_name(suffix: str) -> str:
    """Returns a name for a file that is half written: of this machine and process, and random."""
    kept = suffix if len(suffix) <= LONGEST_SUFFIX else ""
    return f"{PREFIX}{_machine()}-{os.getpid()}-{secrets.token_hex(4)}{kept}"


def _is_stale(part: Path) -> bool:
    """Returns whether the process that was writing a file is gone."""
    machine, _, rest = part.name.removeprefix(PREFIX).partition("-")
    number = rest.partition("-")[0]
    if machine != _machine() or not number.isdecimal() or os.name != "posix":
        try:
            return time.time() - part.stat().st_mtime > OLD
        except FileNotFoundError:
            return False
    if int(number) == os.getpid():
        return part.name not in _under_way
    try:
        os.kill(int(number), 0)
    except (ProcessLookupError, OverflowError):
        return True
    except PermissionError:  # the process of another user
        return False
    return False


def _system_error(error: BaseException | None) -> OSError | None:
    """Returns the error of the system from which another one follows, itself perhaps."""
    seen: set[int] = set()
    while error is not None and id(error) not in seen:
        if isinstance(error, OSError):
            return error
        seen.add(id(error))
        error = error.__cause__ or error.__context__
    return None


def _worded(error: OSError, what: str) -> OSError:
    """Returns an error of the same kind that says what cannot be done, why, and the remedy."""
    code = error.errno
    if code is not None and error.strerror is None:
        return error  # it is worded already
    if code is None:
        return OSError(f"{what}: {error}".splitlines()[0])
    reason = (error.strerror or os.strerror(code)).splitlines()[0]
    text = f"{what}: {reason[:1].lower()}{reason[1:]}; {REMEDIES.get(code, ELSEWHERE)}"
    worded = type(OSError(code, ""))(text)
    worded.errno = code
    return worded
