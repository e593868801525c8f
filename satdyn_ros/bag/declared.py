"""Whether a bag declares its topics as satdyn_ros publishes them."""

from mcap.records import Schema

from ..actuators import earlier_types
from ..messages import schemas
from ..rosbag2.errors import Damaged
from .read_run import RecordedRun


def check_declarations(run: RecordedRun) -> None:
    """
    Check the type, its definition and the encoding of each topic, and its channel, in all files.

    Damaged: with what a file declares, readers would take the messages for something else.
    """
    names = {topic: name for name, topic in run.names.items()}
    known = {name: topic.type for name, topic in run.scenario.topic_table.items()}
    known |= earlier_types()
    for path, (types, channels) in zip(run.bag.files, run.bag.declarations, strict=True):
        for channel_id, channel in channels.items():
            topic = channel.topic
            type_name = known.get(names.get(topic, ''))
            if type_name is None:
                continue
            schema = types.get(channel.schema_id)
            if channel.message_encoding != 'cdr' or not _defines(schema, type_name):
                raise Damaged(
                    f'{path} is damaged: it does not declare {topic} as {type_name} in CDR, with '
                    'the definition of ROS 2'
                )
            if channel_id != run.bag.channel_ids[topic]:
                raise Damaged(
                    f'{path} is damaged: the channel of {topic} is {channel_id} and elsewhere '
                    f'{run.bag.channel_ids[topic]}'
                )


def _defines(schema: Schema | None, type_name: str) -> bool:
    if schema is None or (schema.name, schema.encoding) != (type_name, 'ros2msg'):
        return False
    said = schema.data.decode(errors='replace')
    return _bare(said) == _bare(schemas.schema_text(type_name))


def _bare(definition):
    """Return the words of each line without comments, which differ between versions of ROS."""
    lines = (line.split('#')[0].split() for line in definition.splitlines())
    return [words for words in lines if words]
