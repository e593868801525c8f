"""Packs the samples of a scenario into the messages of any of its topics."""

from ..run.scenario import Scenario
from .measured import SensorPacker
from .topics import TOPICS, Packer


def packer(name: str, scenario: Scenario) -> Packer | SensorPacker:
    """
    Return what packs samples for a topic: pack(samples) -> its messages as rows.

    name: as in TOPICS.  ValueError: the scenario has no such topic.
    """
    if name in scenario.sensors:
        return SensorPacker(name, scenario)
    return TOPICS[name].packer(scenario.frames, scenario.system)


def is_at_every_tick(topic: Packer | SensorPacker) -> bool:
    """Whether a topic has a message at every tick; others are packed as SomeRows."""
    return not isinstance(topic, SensorPacker) or topic.is_at_every_tick
