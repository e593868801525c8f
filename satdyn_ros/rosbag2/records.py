"""The records of MCAP as the mcap package has them, read strictly."""

import io
import struct
from collections.abc import Iterable
from typing import Any

import mcap.records
from mcap.data_stream import ReadDataStream, RecordBuilder
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import McapRecord, MessageIndex

from .errors import Damaged

# Opcode and length of the content.
PREFIX = struct.Struct('<BQ')
# What mcap raises for bytes that are no record.
UNREADABLE = (McapError, struct.error, UnicodeError, OverflowError)
# A message's content has no length of its own to be read by.
_KINDS: dict[int, Any] = {
    opcode: getattr(mcap.records, opcode.name.title().replace('_', ''))
    for opcode in Opcode
    if opcode != Opcode.MESSAGE
}


def read(opcode: int, content: bytes) -> McapRecord | None:
    """
    Return the record of a content, of a MessageIndex without its entries.

    None: a message, or a kind that MCAP does not define.  Damaged: it is not what a writer writes.
    """
    if opcode not in _KINDS:
        return None
    stream = ReadDataStream(io.BytesIO(content))
    try:
        if opcode == Opcode.MESSAGE_INDEX:
            # Each of its entries would become an object, and nobody here needs one.
            record, size = MessageIndex(stream.read2(), []), stream.read4()
            is_whole = stream.count + size == len(content)
        else:
            record = _KINDS[opcode].read(stream)
            is_whole = written([record])[PREFIX.size :] == content
    except UNREADABLE:
        raise Damaged('it cannot be read') from None
    if not is_whole:
        raise Damaged('it is not what a writer writes')
    return record


def written(records: Iterable[McapRecord]) -> bytes:
    """Return the bytes of records in a file."""
    builder = RecordBuilder()
    for record in records:
        record.write(builder)
    return builder.end()
