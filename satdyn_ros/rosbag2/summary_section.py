"""The summary of a file checked against the data that it sums up."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from mcap.opcode import Opcode
from mcap.records import (
    AttachmentIndex,
    Channel,
    ChunkIndex,
    Footer,
    McapRecord,
    MetadataIndex,
    Schema,
    Statistics,
    SummaryOffset,
)

from .data_section import DataSection
from .errors import Damaged
from .scan import Found
from .summary import summary_bytes

# What a summary consists of, beside where its groups are.
_OPCODES = {
    Schema: Opcode.SCHEMA,
    Channel: Opcode.CHANNEL,
    Statistics: Opcode.STATISTICS,
    ChunkIndex: Opcode.CHUNK_INDEX,
    MetadataIndex: Opcode.METADATA_INDEX,
    AttachmentIndex: Opcode.ATTACHMENT_INDEX,
}


class SummarySection:
    """What follows the data of a file: found, in order."""

    def __init__(self, path: Path, data: DataSection, found: list[Found]):
        self._path = path
        self._data = data
        self._found = found
        if not found or not isinstance(found[-1].item, Footer):
            raise Damaged(f'{path} is damaged: there is no Footer record at its end')

    def check(self) -> None:
        """
        Check the summary against the data; add to their summary what only the summary declares.

        Damaged: the first contradiction, by file and record.
        """
        footer_found = self._found[-1]
        footer = footer_found.item
        summary_bytes(self._path)
        if self._data.is_ours and footer.summary_crc == 0:
            raise self._damaged(footer_found, 'the checksum of the summary is missing')
        starts = {type(found.item): found.start for found in reversed(self._found)}
        begin = self._data.end if len(self._found) > 1 else 0
        if (footer.summary_start, footer.summary_offset_start) != (
            begin if footer.summary_start else 0,
            starts.get(SummaryOffset, 0) if footer.summary_offset_start else 0,
        ):
            raise self._damaged(footer_found, 'it does not point at the summary')
        self._check_kinds()
        # Some writers list channels without messages, and count those that the data declare.
        counted = [] if self._data.is_ours else [self._counted()]
        self._check_declarations()
        self._check_indexes(ChunkIndex, self._data.summary.chunk_indexes)
        self._check_indexes(MetadataIndex, self._data.summary.metadata_indexes)
        self._check_indexes(AttachmentIndex, self._data.summary.attachment_indexes)
        self._check_statistics([*counted, self._counted()])
        self._check_offsets()

    def _counted(self) -> Statistics:
        """Return the statistics of what has been declared so far."""
        self._data.summary.close()
        return replace(self._data.summary.statistics)

    def _of(self, kind: type) -> list[Found]:
        return [found for found in self._found if isinstance(found.item, kind)]

    def _check_kinds(self) -> None:
        for found in self._found[:-1]:
            # Readers skip records that MCAP does not define.
            is_foreign = found.item is None and not self._data.is_ours
            if not (is_foreign or type(found.item) in {*_OPCODES, SummaryOffset}):
                raise self._damaged(found, 'it does not belong in the summary')

    def _check_declarations(self) -> None:
        summary = self._data.summary
        for kind, declared in ((Schema, summary.schemas), (Channel, summary.channels)):
            listed = self._of(kind)
            missing = declared.keys() - {found.item.id for found in listed}
            if missing and (listed or self._data.is_ours):
                raise self._missing(f'{kind.__name__} {min(missing)}')
            for found in listed:
                if declared.setdefault(found.item.id, found.item) != found.item:
                    raise self._damaged(found, 'another of this id is declared before it')

    def _check_indexes(self, kind: type, expected: Mapping[int, McapRecord]) -> None:
        listed = self._of(kind)
        places = set()
        for found in listed:
            index = found.item
            place = index.chunk_start_offset if kind is ChunkIndex else index.offset
            if expected.get(place) != index:
                raise self._damaged(found, f'it does not match what is at byte {place}')
            if place in places:
                raise self._damaged(found, f'another one points at byte {place}')
            places.add(place)
        if expected.keys() - places and (listed or self._data.is_ours):
            raise self._missing(f'{kind.__name__} of byte {min(expected.keys() - places)}')

    def _check_statistics(self, allowed: list[Statistics]) -> None:
        listed = self._of(Statistics)
        for found in listed:
            if found.item not in allowed:
                raise self._damaged(found, 'it does not count what the data hold')
        if not listed and self._data.is_ours:
            raise self._missing('Statistics')

    def _check_offsets(self) -> None:
        groups: dict[int, tuple[int, int]] = {}
        for found in self._found[:-1]:
            if opcode := _OPCODES.get(type(found.item)):
                start = groups.get(opcode, (found.start, 0))[0]
                groups[opcode] = start, found.end - start
        for found in self._of(SummaryOffset):
            offset = found.item
            group = groups.get(offset.group_opcode, (offset.group_start, 0))
            if group != (offset.group_start, offset.group_length):
                raise self._damaged(found, 'it does not point at its group')

    def _missing(self, what: str) -> Damaged:
        return Damaged(f'{self._path} is damaged: its summary has no {what}')

    def _damaged(self, found: Found, why: str) -> Damaged:
        return found.damaged(self._path, why)
