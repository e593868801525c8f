"""Whether all parts of a bag agree: its data, their indexes, the summaries, metadata.yaml."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from mcap.records import Metadata

from . import metadata
from .data_section import DataSection
from .errors import Damaged
from .metadata import BagMetadata
from .reader import Bag, TopicBlock
from .scan import scan
from .summary import read_summary, summary_section

# What metadata.yaml counts in the files of any bag, the last two if there are messages.
_COUNTED = ('message_count', 'relative_file_paths', 'starting_time', 'duration')
_ONLY_IN_CLOSING = ('custom_data', 'ros_distro')


def check(
    bag: Bag, pass_on: Callable[[TopicBlock | Metadata], None] = lambda _: None
) -> list[str]:
    """
    Check everything in a bag against everything else; return in words what cannot be checked.

    pass_on: called with each item of the bag, as Bag.items yields them, once it is checked.
    Damaged: the first contradiction, by file and record.  Incomplete: a file is cut off.
    """
    files = [check_file(path, pass_on) for path in bag.files]
    if bag.information is not None:
        check_metadata(bag.path / metadata.FILE_NAME, bag.information, files)
    return [f'{file.path.name} has no checksum of its data' for file in files if not file.crc]


def check_file(
    path: Path, pass_on: Callable[[TopicBlock | Metadata], None] = lambda _: None
) -> DataSection:
    """
    Check the records of a file against each other; return its data.

    Their summary has what the summary of the file declares besides.  pass_on and errors: as of
    check.
    """
    data = DataSection(path, pass_on)
    items = scan(path)
    if not any(data.take(found) for found in items):
        raise Damaged(f'{path} is damaged: its data section has no end')
    for found in items:
        found.sound(path)
    check_summary(data)
    return data


def check_summary(data: DataSection) -> None:
    """
    Check the summary of a file against its data; add to theirs what only the summary declares.

    What satdyn_ros wrote must be what it writes; others leave parts out.  Damaged: it is not.
    """
    path, held = data.path, data.summary
    start, section = summary_section(path)
    if start != data.end:
        raise Damaged(f'{path} is damaged: its summary does not follow its data')
    summary = read_summary(path)
    agrees = True
    # Some writers list channels without messages, and count those that the data declare.
    counted = [None, held.counted()]
    for name in ('schemas', 'channels'):
        own, listed = getattr(held, name), getattr(summary, name)
        agrees &= not listed or own.items() <= listed.items()
        own |= listed
    if data.has_every_checksum:
        agrees &= section == held.end_of_file(start)
    else:
        for name in ('chunk_indexes', 'metadata_indexes', 'attachment_indexes'):
            own, listed = _sorted(getattr(held, name)), _sorted(getattr(summary, name))
            agrees &= not listed or own == listed
        agrees &= summary.statistics in [*counted, held.counted()]
    if not agrees:
        raise Damaged(f'{path} is damaged: its summary does not say what its data hold')


def _sorted(indexes: list[Any]) -> list[Any]:
    return sorted(indexes, key=lambda i: getattr(i, 'chunk_start_offset', None) or i.offset)


def check_metadata(path: Path, said: dict[str, Any], files: list[DataSection]) -> None:
    """
    Check metadata.yaml against the files; for satdyn_ros also against their closing records.

    Each key may say what its writer wrote, or what `ros2 bag reindex` does.

    Damaged: the first contradiction, by its key.
    """
    contents = BagMetadata()
    for file in files:
        contents.add(file.path.name, file.summary)
    held = contents.said()
    reindexed = metadata.as_reindexed(held, [file.summary.statistics for file in files])
    last = files[-1]
    if last.is_ours:
        closing = metadata.parse(last.closing, f'the last Metadata record of {last.path}')
        held = closing | {key: held[key] for key in held if key not in _ONLY_IN_CLOSING}
    else:
        keys = _COUNTED if held['message_count'] else _COUNTED[:2]
        held = {key: held[key] for key in keys}
    for key in [*held, *said]:
        allowed = held.get(key), reindexed.get(key, held.get(key))
        if (key in held or last.is_ours) and said.get(key) not in allowed:
            raise Damaged(f'{path} is damaged: its {key} is not what the files say')
