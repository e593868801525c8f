"""
Repairs a bag whose writer was killed, or which was damaged: everything readable is kept.

Indexes, statistics, summaries and metadata.yaml are rebuilt from the data.
"""

import os
import shutil
from collections.abc import Mapping
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from mcap.records import Header, Metadata

from . import metadata
from .chunk import Contents
from .compression import compressor
from .damaged_file import DamagedFile, Loss
from .data_section import DataSection
from .errors import BagError, Damaged
from .integrity import check_file, check_metadata
from .mcap_file import McapFile
from .metadata import BagMetadata
from .reader import bag_files, has_compressed_messages
from .records import written
from .scan import Block, scan

_LOST_HEADER = Header('ros2', 'satdyn_ros')


@dataclass(frozen=True)
class Recovered:
    """
    What recover did.

    files: those it rewrote, metadata.yaml among them where it is the only one.  message_count: of
    the bag.  losses: what was lost.
    """

    files: tuple[str, ...]
    message_count: int
    losses: tuple[Loss, ...]


def recover(path: str | Path, output: str | Path | None = None) -> Recovered:
    """
    Repair a bag: a directory, or a bare .mcap file.

    Everything readable is kept, before and after any damage; from a chunk that is cut off, its
    complete messages.  A file is replaced when the new one is complete, and where anything was
    lost the old one stays beside it as NAME.damaged.  Complete files are left as they are.

    output: the new bag, which must not exist; the old one stays as it is.  BagError: path is not
    a bag, or cannot be kept whole.  OSError: the new file cannot be written.
    """
    path = Path(path)
    files, losses = _files(path)
    empty = [file for file in files if file.stat().st_size == 0]
    if len(empty) == len(files):
        raise BagError(f'{path} is not a bag: its files are empty')
    losses += [Loss(file.name, None, is_empty=True) for file in empty]
    contents = BagMetadata(*_first_words(files))
    directory = path if path.is_dir() else path.parent
    if output is not None:
        directory = _new_place(path, Path(output))
    rewritten, checked = [], []
    for file in files:
        target = directory / file.name if output is None or path.is_dir() else Path(output)
        try:
            checked.append(check_file(file))
            contents.add(target.name, checked[-1].summary)
            if target != file:
                shutil.copyfile(file, target)
        except Damaged:
            loss = _mend(file, target, contents)
            losses += [loss] if loss else []
            rewritten.append(file.name)
            checked.append(check_file(target))
    if path.is_dir() and (output is not None or rewritten or not _is_listed(path, checked)):
        contents.write(directory)
        if output is None and not rewritten:
            rewritten.append(metadata.FILE_NAME)
    return Recovered(tuple(rewritten), sum(contents.counts.values()), tuple(losses))


def _files(path: Path) -> tuple[list[Path], list[Loss]]:
    """Return the files of a bag and those missing; a damaged metadata.yaml is ignored."""
    try:
        said = metadata.read(path / metadata.FILE_NAME)
    except (Damaged, FileNotFoundError, NotADirectoryError):
        return bag_files(path, None), []
    if has_compressed_messages(path, said):
        raise BagError(f'{path} has messages compressed by rosbag2, which recover does not keep')
    names = said['relative_file_paths']
    present = [path / name for name in names if (path / name).is_file()]
    if len(present) == len(names):
        return bag_files(path, said), []
    files = bag_files(path, None)
    missing = [name for name in names if not (path / name).is_file()][: len(names) - len(files)]
    return files, [Loss(name, None) for name in missing]


def _is_listed(path: Path, files: list[DataSection]) -> bool:
    """Whether metadata.yaml agrees with the files."""
    file = path / metadata.FILE_NAME
    try:
        check_metadata(file, metadata.read(file), files)
    except (Damaged, FileNotFoundError):
        return False
    return True


def _first_words(files: list[Path]) -> tuple[Mapping[str, str], str]:
    """Return custom_data and ros_distro from the first readable rosbag2 record."""
    for file in files:
        for found in scan(file):
            item = found.item
            if not (isinstance(item, Metadata) and item.name == metadata.NAME):
                continue
            try:
                said = metadata.parse(item.metadata.get('serialized_metadata', ''), file.name)
            except Damaged:
                continue
            custom, distro = said.get('custom_data'), said.get('ros_distro')
            custom = custom if isinstance(custom, dict) else {}
            return {str(k): str(v) for k, v in custom.items()}, str(distro or '')
    return {}, ''


def _new_place(path: Path, output: Path) -> Path:
    """Return the directory of the repaired bag, created if the bag is a directory."""
    if output.exists():
        raise FileExistsError(f'{output} already exists; a recovered bag needs a new place')
    if path.is_dir():
        output.mkdir(parents=True)
        return output
    return output.parent


def _mend(path: Path, target: Path, contents: BagMetadata) -> Loss | None:
    """Rewrite a file with all that can be recovered of it, then replace it."""
    damaged = DamagedFile(path)
    unfinished = target.with_suffix('.recovering')
    try:
        unfinished.unlink(missing_ok=True)
        with closing(McapFile(unfinished, damaged.header or _LOST_HEADER)) as file:
            _copy(path, file, damaged)
            file.summary.schemas |= damaged.summary.schemas
            file.summary.channels |= damaged.summary.channels
            contents.add(target.name, file.summary)
            # A file has two: the first at its start, the second with what is known at its end.
            for _ in range(_names(file).count(metadata.NAME), 2):
                file.write_metadata(metadata.NAME, contents.record())
            loss = damaged.loss(file.crc)
            file.finish()
        if loss is not None and target == path:
            _keep(path)
        unfinished.replace(target)
    except OSError as error:
        raise OSError(f'{unfinished} cannot be written: {error.strerror}') from error
    finally:
        unfinished.unlink(missing_ok=True)
    return loss


def _copy(path: Path, file: McapFile, damaged: DamagedFile) -> None:
    """Write what can be recovered of a file; a channel that lost its declaration gets it back."""
    known = damaged.summary
    compression = ''
    for found in scan(path):
        match found.item:
            case Metadata(name=name, metadata=mapping):
                is_last = name == metadata.NAME and name in _names(file)
                if damaged.lost_bytes == 0 or not is_last:
                    file.write_metadata(name, mapping)
            case Block(contents, chunk) if len(contents):
                declared = contents.declarations[1], file.summary.channels
                lost_ids = [i for i in contents.counts if not any(i in some for some in declared)]
                channels = [known.channels[i] for i in lost_ids]
                schemas = {c.schema_id: known.schemas.get(c.schema_id) for c in channels}
                compression = chunk.compression if chunk else compression
                if chunk is not None and not channels:
                    file.write_chunk(contents, compression, chunk.data)
                    continue
                lost = written([*(s for s in schemas.values() if s is not None), *channels])
                data = np.concatenate([np.frombuffer(lost, np.uint8), contents.data])
                file.write_chunk(Contents(data), compression, compressor(compression)(data))


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
