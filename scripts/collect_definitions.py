"""
Write satdyn_ros/messages/definitions.json from the message definitions of an installed ROS 2.

    python scripts/collect_definitions.py

collects every type of the topic table and all they are made of, .msg texts word for word and type
hashes, from share/<package>/msg of the environment (AMENT_PREFIX_PATH, else that of Python).
"""

import json
import os
import sys
from pathlib import Path

from satdyn_ros.actuators import earlier_types
from satdyn_ros.messages import schemas
from satdyn_ros.run.topics import TOPICS

TARGET = Path(schemas.__file__).with_name('definitions.json')

# tf2_msgs is part of geometry2, not of common_interfaces, and may be missing.
TF_MESSAGE = {
    'hash': 'RIHS01_e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087',
    'definition': 'geometry_msgs/TransformStamped[] transforms\n',
}


def installed(type_name: str) -> dict[str, str]:
    """Return {'hash', 'definition'} of a type as installed; FileNotFoundError where it is not."""
    package, _, name = type_name.split('/')
    prefixes = [*os.environ.get('AMENT_PREFIX_PATH', '').split(os.pathsep), sys.prefix]
    folders = [Path(prefix, 'share', package, 'msg') for prefix in prefixes if prefix]
    for folder in folders:
        if (folder / f'{name}.msg').is_file():
            # Bytes, not text: the line ends stay as they are.
            definition = (folder / f'{name}.msg').read_bytes().decode()
            hashes = json.loads((folder / f'{name}.json').read_text())['type_hashes']
            by_name = {entry['type_name']: entry['hash_string'] for entry in hashes}
            return {'hash': by_name[type_name], 'definition': definition}
    raise FileNotFoundError(f'{type_name} is not installed in {folders}')


def collect() -> dict[str, dict[str, str]]:
    """Return the data of definitions.json."""
    found: dict[str, dict[str, str]] = {}
    wanted = {topic.type for topic in TOPICS.values() if topic.role != 'diagnostics'}
    wanted |= {*earlier_types().values()}
    while wanted:
        name = wanted.pop()
        try:
            found[name] = installed(name)
        except FileNotFoundError:
            if name != 'tf2_msgs/msg/TFMessage':
                raise
            found[name] = TF_MESSAGE
        parts = (field.type for field in schemas.parse(name, found[name]['definition']))
        wanted |= {part for part in parts if '/' in part and part not in found}
    return dict(sorted(found.items()))


if __name__ == '__main__':
    TARGET.write_text(json.dumps(collect(), indent=1) + '\n', encoding='utf-8')
    print(TARGET)
