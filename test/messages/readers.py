"""Three foreign readers of CDR messages, and what they read as nested dicts of plain values."""

import array
import dataclasses
import importlib

import numpy as np
from mcap.records import Schema
from mcap_ros2.decoder import DecoderFactory
from rclpy.serialization import deserialize_message, serialize_message
from rosbags.typesys import Stores, get_typestore

from satdyn_ros.messages import schemas

TYPESTORE = get_typestore(Stores.ROS2_JAZZY)


def message_class(type_name):
    """Return the class of the installed package, None where it is not installed."""
    package, _, name = type_name.split('/')
    try:
        return getattr(importlib.import_module(f'{package}.msg'), name)
    except ModuleNotFoundError:
        return None


def read(type_name, data):
    """Return what each reader makes of a message, by the reader's name."""
    schema = Schema(1, schemas.schema_text(type_name).encode(), 'ros2msg', type_name)
    decode = DecoderFactory().decoder_for('cdr', schema)
    assert decode is not None
    messages = {
        'rosbags': TYPESTORE.deserialize_cdr(data, type_name),
        'mcap_ros2': decode(data),
    }
    if message_class(type_name):
        messages['rclpy'] = deserialize_message(data, message_class(type_name))
    return {reader: plain(message) for reader, message in messages.items()}


def plain(value):
    """Return a message as dict, lists, numbers and strings."""
    if hasattr(value, 'get_fields_and_field_types'):
        names = list(value.get_fields_and_field_types())
    elif dataclasses.is_dataclass(value):
        names = [field.name for field in dataclasses.fields(value) if field.name[0] != '_']
    elif isinstance(value, list | tuple | bytes | array.array | np.ndarray):
        return [plain(item) for item in value]
    elif getattr(value, '__slots__', ()) and not isinstance(value, np.generic):
        names = value.__slots__
    else:
        return value.item() if isinstance(value, np.generic) else value
    # Some readers show a type's constants beside its fields.
    return {name: plain(getattr(value, name)) for name in names if not name.isupper()}


def default(type_name, **given):
    """Return a message with ROS's defaults where nothing is given, as plain values."""
    return _merged(plain(message_class(type_name)()), given)


def _merged(defaults, given):
    assert given.keys() <= defaults.keys(), given.keys() - defaults.keys()
    return {
        name: _merged(value, given[name])
        if isinstance(given.get(name), dict)
        else plain(given.get(name, value))
        for name, value in defaults.items()
    }


def canonical(type_name, data):
    """
    Return the bytes that ROS writes for a message, with zeros for padding.

    ROS's own padding holds garbage; rosbags reads what ROS writes and writes it again.  Where
    sequences are empty ROS returns a buffer longer than what it wrote into it.
    """
    if message_class(type_name):
        written = bytes(serialize_message(deserialize_message(data, message_class(type_name))))
        assert len(written) >= len(data)
        data = written[: len(data)]
    return bytes(TYPESTORE.serialize_cdr(TYPESTORE.deserialize_cdr(data, type_name), type_name))
