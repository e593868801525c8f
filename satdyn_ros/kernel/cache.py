"""
The folder where compiled code is kept for the next start.

What is in it will be executed, so nobody but this user and root may be able to change it.
"""

import atexit
import grp
import os
import pwd
import shutil
import stat
import tempfile
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

_PACKAGE = Path(__file__).parents[1]


def find(chosen: str = '') -> Path | None:
    """
    Return the first folder of these that can be written and that no other user can change.

    chosen, where it is not empty; one in the package; one in the user's cache folder; a temporary
    one, removed when this process ends.  None: not even that is possible.
    """
    for folder in _kept(chosen):
        with suppress(OSError):
            folder.mkdir(mode=0o700, parents=True, exist_ok=True)
            # Permissions alone do not show whether a file system is read-only or full.
            tempfile.TemporaryFile(dir=folder).close()
            if is_safe(folder):
                return folder
    return _temporary()


def is_temporary(folder: Path | None) -> bool:
    """Return whether what is in a folder is gone at the next start."""
    return folder is None or folder in _TEMPORARY


def is_safe(folder: Path) -> bool:
    """Return whether no user but this one and root can change what is in a folder, or swap it."""
    folder = folder.resolve()
    return not _is_open_to_others(folder) and not any(
        # In a sticky folder, such as /tmp, users can swap only what is theirs.
        _is_open_to_others(parent) and not parent.stat().st_mode & stat.S_ISVTX
        for parent in folder.parents
    )


def remove_others(folder: Path, pattern: str) -> None:
    """Remove the folders of a pattern beside a folder."""
    with suppress(OSError):
        for old in folder.parent.glob(pattern):
            if old != folder:
                shutil.rmtree(old, ignore_errors=True)


def _kept(chosen: str) -> Iterator[Path]:
    if chosen:
        yield Path(chosen, 'satdyn_ros')
    if os.access(_PACKAGE, os.W_OK):
        yield _PACKAGE / '__pycache__' / 'compiled'
    # RuntimeError: a user without a home folder.
    with suppress(RuntimeError):
        yield Path(os.environ.get('XDG_CACHE_HOME') or Path.home() / '.cache', 'satdyn_ros')


_TEMPORARY: list[Path] = []


def _temporary():
    try:
        folder = tempfile.mkdtemp(prefix='satdyn_ros-')
    except OSError:
        return None
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    # The processes that this one starts share it.
    os.environ['NUMBA_CACHE_DIR'] = folder
    _TEMPORARY.append(Path(folder, 'satdyn_ros'))
    return _TEMPORARY[0]


def _is_open_to_others(folder):
    """Return whether a user other than this one and root owns a folder or can write to it."""
    status = folder.stat()
    if status.st_uid not in (0, os.geteuid()) or status.st_mode & stat.S_IWOTH:
        return True
    return bool(status.st_mode & stat.S_IWGRP) and not _is_own_group(status.st_gid)


def _is_own_group(gid):
    """Return whether a group is root's or the one that this user alone is in."""
    try:
        group, user = grp.getgrgid(gid), pwd.getpwuid(os.geteuid()).pw_name
    except KeyError:
        return gid == 0
    return gid == 0 or (group.gr_name == user and not set(group.gr_mem) - {user})
