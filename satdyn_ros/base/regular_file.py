"""The door to the files that are read: what has no end would hold its reader for ever."""

import errno
import os
import stat
from pathlib import Path

_KINDS = {
    stat.S_IFDIR: 'a directory',
    stat.S_IFIFO: 'a FIFO',
    stat.S_IFCHR: 'a device',
    stat.S_IFBLK: 'a device',
    stat.S_IFSOCK: 'a socket',
}


def regular_file(path: str | Path) -> Path:
    """
    Return the path of a file that can be read to its end, or of a link to one.

    OSError: there is none, or it is a directory, a FIFO, a device or a socket.
    """
    kind = stat.S_IFMT(os.stat(path).st_mode)
    if kind != stat.S_IFREG:
        said = f'it is {_KINDS.get(kind, "something else")}, not a file'
        raise OSError(errno.EINVAL, said, str(path))
    return Path(path)
