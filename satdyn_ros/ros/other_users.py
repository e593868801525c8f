"""Fast DDS between the users of one machine: what it finds it may not reach."""

import os
import pwd
from contextlib import suppress
from pathlib import Path

import rclpy

# Where Fast DDS keeps the memory that its processes share.
_SHARED = Path('/dev/shm')


def unreached(shared: Path = _SHARED) -> str:
    """
    Return the end of a sentence about a node that is found but not heard, or ''.

    Each process of Fast DDS takes messages from memory that processes of other users cannot open
    for writing; they find each other nevertheless, by UDP.  shared: the directory of that memory.
    """
    is_fast_dds = rclpy.get_rmw_implementation_identifier().startswith('rmw_fastrtps')
    if not is_fast_dds or 'FASTDDS_BUILTIN_TRANSPORTS' in os.environ:
        return ''
    owners = set()
    for file in shared.glob('fastrtps_*'):
        with suppress(FileNotFoundError):
            owners.add(file.stat().st_uid)
    others = sorted(map(_name, owners - {os.geteuid()}))
    if not others:
        return ''
    return (
        f'; there are processes of {" and ".join(others)} on this machine, and Fast DDS does not '
        'share memory across users: messages pass if one side has '
        'FASTDDS_BUILTIN_TRANSPORTS=UDPv4 in its environment'
    )


def _name(uid):
    try:
        return pwd.getpwuid(uid).pw_name
    except KeyError:
        return f'the user {uid}'
