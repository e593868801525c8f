"""
Repairs a bag whose writer was killed, or which was damaged: everything readable is kept.

Indexes, statistics, summaries and metadata.yaml are rebuilt from the data.
"""

import os
import shutil
from collections.abc import Mapping
from contextlib import closing, suppress
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, DataEnd, Header, Metadata, Schema

from . import metadata
from .chunk import Contents
from .compression import compressor
from .errors import BagError, Damaged, Incomplete
from .integrity import CheckedFile, check_metadata
from .mcap_file import McapFile
from .metadata import BagMetadata
from .reader import bag_files, has_compressed_messages
from .records import written
from .scan import Block, Flaw, Found, scan
from .summary import SummaryBuilder

_LOST_HEADER = Header('ros2', 'satdyn_ros')
_MADE_ANEW = (Opcode.HEADER, Opcode.MESSAGE_INDEX, Opcode.DATA_END)


@dataclass(frozen=True)
class Recovered:
    """
    What recover did.

    files: those it rewrote, metadata.yaml among them where it is the only one.  message_count: of
    the bag.  losses: what was lost, a sentence for each file.
    """

    files: tuple[str, ...]
    message_count: int
    losses: tuple[str, ...]


def recover(path: str | Path, output: str | Path | None = None) -> Recovered:
    """
    Repair a bag: a directory, or a bare .mcap file.

    Everything readable is kept, before and after any damage; a chunk is kept or lost as a whole.
    A file is replaced when the new one is complete, and if anything was lost the old one stays
    beside it as NAME.damaged.  Complete files are left as they are.

    output: the new bag, which must not exist; the old one stays as it is.  BagError: path is not
    a bag, or cannot be kept whole.  OSError: the new file cannot be written.
    """
    path = Path(path)
    files, losses = _files(path)
    empty = [file for file in files if file.stat().st_size == 0]
    if len(empty) == len(files):
        raise BagError(f'{path} is not a bag: its files are empty')
    losses += [f'{file.name}: the file holds nothing' for file in empty]
    contents = BagMetadata(*_first_words(files))
    targets = files if output is None else _new_files(path, files, Path(output))
    rewritten = []
    for file, target in zip(files, targets, strict=True):
        try:
            last = CheckedFile(file)
            contents.add(target.name, last.summary)
            if target != file:
                shutil.copyfile(file, target)
        except Damaged:
            loss = _mend(file, target, contents)
            losses += [loss] if loss else []
            rewritten.append(file.name)
    is_new = output is not None or rewritten
    if path.is_dir() and (is_new or not _is_listed(path, contents, last)):
        contents.write(targets[0].parent)
        if output is None and not rewritten:
            rewritten.append(metadata.FILE_NAME)
    return Recovered(tuple(rewritten), sum(contents.counts.values()), tuple(losses))


def _files(path: Path) -> tuple[list[Path], list[str]]:
    """Return the files of a bag and those missing; a damaged metadata.yaml is ignored."""
    try:
        said = metadata.read(path / metadata.FILE_NAME)
    except (Damaged, FileNotFoundError, NotADirectoryError):
        return bag_files(path, None), []
    if has_compressed_messages(path, said):
        raise BagError(f'{path} has messages compressed by rosbag2, which recover does not keep')
    names = said['relative_file_paths']
    missing = [name for name in names if not (path / name).is_file()]
    files = bag_files(path, None if missing else said)
    # Others may be there under other names.
    return files, [f'{name}: the file is missing' for name in missing[: len(names) - len(files)]]


def _is_listed(path: Path, contents: BagMetadata, last: CheckedFile) -> bool:
    """Whether metadata.yaml agrees with the files."""
    file = path / metadata.FILE_NAME
    try:
        check_metadata(file, metadata.read(file), contents, last)
    except (Damaged, FileNotFoundError):
        return False
    return True


def _first_words(files: list[Path]) -> tuple[Mapping[str, str], str]:
    """Return custom_data and ros_distro from the first readable rosbag2 record."""
    for file in files:
        for found in scan(file):
            match found.item:
                case Metadata(metadata.NAME, {'serialized_metadata': text}):
                    with suppress(Damaged):
                        said = metadata.parse(text, file.name, len(text))
                        custom = said.get('custom_data')
                        custom = custom if isinstance(custom, dict) else {}
                        words = {str(key): str(value) for key, value in custom.items()}
                        return words, str(said.get('ros_distro') or '')
    return {}, ''


def _new_files(path: Path, files: list[Path], output: Path) -> list[Path]:
    """Return the files of the repaired bag; its directory is made if the bag is one."""
    if output.exists():
        raise FileExistsError(f'{output} already exists; a recovered bag needs a new path')
    if not path.is_dir():
        return [output]
    output.mkdir(parents=True)
    return [output / file.name for file in files]


def _mend(path: Path, target: Path, contents: BagMetadata) -> str | None:
    """Rewrite a file with all that can be recovered, then replace it; return what is lost."""
    remains = _Remains(path)
    unfinished = target.with_suffix('.recovering')
    try:
        unfinished.unlink(missing_ok=True)
        with closing(McapFile(unfinished, remains.header)) as file:
            _copy(path, file, remains)
            file.summary.schemas |= remains.known.schemas
            file.summary.channels |= remains.known.channels
            contents.add(target.name, file.summary)
            # A file has two: the first at its start, the second with what is known at its end.
            for _ in range(_names(file).count(metadata.NAME), 2):
                file.write_metadata(metadata.NAME, contents.record(target.name, file.summary))
            loss = remains.loss(file.crc)
            file.finish()
        if loss is not None and target == path:
            _keep(path)
        unfinished.replace(target)
    except OSError as error:
        raise OSError(f'{unfinished} cannot be written: {error.strerror}') from error
    finally:
        unfinished.unlink(missing_ok=True)
    return loss


class _Remains:
    """
    What a damaged file still says, read once from start to end.

    known: the schemas and channels that its data or its summary declare.  lost: bytes that cannot
    be read.  BagError: it cannot be kept whole.
    """

    def __init__(self, path: Path):
        self.header = _LOST_HEADER
        self.known = SummaryBuilder()
        self._path = path
        self.lost: list[Found] = []
        self._crc: int | None = None
        self._is_doubtful = False
        for found in scan(path):
            match found.item:
                case Header():
                    self.header = found.item
                case Block(contents):
                    self.known.add_messages(contents)
                case Schema():
                    self.known.schemas.setdefault(found.item.id, found.item)
                case Channel():
                    self.known.channels.setdefault(found.item.id, found.item)
                case DataEnd():
                    self._crc = found.item.data_section_crc
                case Attachment():
                    raise BagError(f'{path.name} has attachments, which rosbag2 does not support')
                case Flaw(error, opcode) if self._crc is None and found.start:
                    if opcode == Opcode.DATA_END:
                        self._is_doubtful = not isinstance(error, Incomplete)
                    if opcode not in _MADE_ANEW and found.end > found.start:
                        self.lost.append(found)
        for id_ in self.known.statistics.channel_message_counts:
            # Its messages may be all that is left of a channel.
            self.known.channels.setdefault(id_, Channel(id_, f'/channel_{id_}', 'cdr', {}, 0))

    def loss(self, crc: int) -> str | None:
        """Return in words what is lost, if anything; crc: of the data written again."""
        if crc == self._crc:
            return None
        if self.lost:
            count = sum(found.end - found.start for found in self.lost)
            return f'{self._path.name}: {count} bytes lost, the first at byte {self.lost[0].start}'
        if self._is_doubtful:
            return (
                f'{self._path.name}: a Header or Metadata record is not as it was written; '
                'all are kept as they are'
            )
        return None


def _copy(path: Path, file: McapFile, remains: _Remains) -> None:
    """Write what can be recovered of a file, but for closing words that count what is lost."""
    known = remains.known
    for found in scan(path):
        match found.item:
            case Metadata(name=name, metadata=mapping):
                is_last = name == metadata.NAME and name in _names(file)
                if not (is_last and remains.lost):
                    file.write_metadata(name, mapping)
            case Block(contents, chunk) if len(contents):
                declared = contents.declarations[1], file.summary.channels
                if not all(any(i in some for some in declared) for i in contents.counts):
                    # The chunk that declared them is lost.
                    data = written([*known.schemas.values(), *known.channels.values()])
                    file.write_chunk(Contents(np.frombuffer(data, np.uint8)), '', data)
                if chunk is not None:
                    file.write_chunk(contents, chunk.compression, chunk.data)
                else:
                    file.write_chunk(contents, 'zstd', compressor('zstd')(contents.data))


def _names(file: McapFile) -> list[str]:
    """Return the names of the metadata records in a file."""
    return [index.name for index in file.summary.metadata_indexes]


def _keep(path: Path) -> None:
    """Keep a copy of a file beside it under an unused name."""
    number, kept = 1, path.with_name(f'{path.name}.damaged')
    while kept.exists():
        number += 1
        kept = path.with_name(f'{path.name}.damaged.{number}')
    try:
        os.link(path, kept)
    except OSError:
        shutil.copy2(path, kept)
