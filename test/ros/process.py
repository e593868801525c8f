"""What a process holds: memory and file descriptors."""

from contextlib import suppress
from pathlib import Path


def memory_bytes(pid: int | str = 'self') -> int:
    """Return the resident memory of a process."""
    status = Path(f'/proc/{pid}/status').read_text()
    (line,) = (line for line in status.splitlines() if line.startswith('VmRSS:'))
    return int(line.split()[1]) * 1024


def descriptors(pid: int | str = 'self') -> list[str]:
    """Return the names of the files, sockets and the like that a process holds open."""
    names = []
    for link in Path(f'/proc/{pid}/fd').iterdir():
        # One may be closed meanwhile.
        with suppress(FileNotFoundError):
            names.append(str(link.readlink()))
    return names


def descriptor_count(pid: int | str = 'self') -> int:
    """Return how many files, sockets and the like a process holds open."""
    return len(descriptors(pid))
