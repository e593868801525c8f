"""A scenario as a ROS 2 parameter file: its sections and nested keys, from and to dotted names."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import yaml

from ..base import ros_yaml
from ..base.key import listed
from . import shipped

# rclpy's own parameters, which it adds to every node's.
RCLPY_PARAMETERS = ('use_sim_time', 'start_type_description_service', 'qos_overrides')


def scenario_text(path: str | Path) -> str:
    """Return the text of a scenario by its path, or by its name if it is shipped; ValueError."""
    return ros_yaml.read_text(shipped.scenario_path(path), 'the scenario')


def sections_of_yaml(text: str, origin: str) -> Mapping[Any, Any]:
    """Return the sections of a ROS 2 parameter file, as they are, by their names; ValueError."""
    document = ros_yaml.load(text, origin)
    if not isinstance(document, Mapping):
        raise ValueError(f'{origin} is not a parameter file: it must have sections such as /**')
    return document


def parameters_of_yaml(text: str, origin: str) -> dict[str, Any]:
    """
    Return the parameters, dotted, that a ROS 2 parameter file has for this node.

    The sections /**, satdyn and /satdyn count, in this order.  ValueError: no such file.
    """
    sections = sections_of_yaml(text, origin)
    found = [sections[name] for name in ('/**', 'satdyn', '/satdyn') if name in sections]
    if not found:
        raise ValueError(f'{origin} has no section for this node; allowed: /**, satdyn or /satdyn')
    parameters: dict[str, Any] = {}
    for section in found:
        parameters.update(parameters_of_section(section, origin))
    return {k: v for k, v in parameters.items() if k.split('.')[0] not in RCLPY_PARAMETERS}


def parameters_of_section(section: Any, origin: str) -> dict[str, Any]:
    """Return the parameters, dotted, of one section; ValueError: it is not one."""
    if not isinstance(section, Mapping) or not set(section) <= {'ros__parameters'}:
        raise ValueError(f'{origin} has a section with more than ros__parameters in it')
    nested = section.get('ros__parameters')
    if not isinstance(nested, Mapping | None):
        raise ValueError(f'ros__parameters of {origin} must be keys and values')
    return dict(flattened(nested or {}))


def flattened(nested: Mapping[str, Any], prefix: str = '') -> Iterator[tuple[str, Any]]:
    """Yield the dotted names and values of nested dictionaries."""
    for name, value in nested.items():
        if isinstance(value, Mapping):
            yield from flattened(value, f'{prefix}{name}.')
        else:
            yield f'{prefix}{name}', value


def yaml_of_parameters(values: Mapping[str, Any]) -> str:
    """Return the text of a parameter file with these values, by their dotted names."""
    nested: dict[str, Any] = {}
    for name, value in values.items():
        branch = nested
        *groups, leaf = name.split('.')
        for group in groups:
            branch = branch.setdefault(group, {})
        branch[leaf] = listed(value)
    return yaml.safe_dump({'/**': {'ros__parameters': nested}}, sort_keys=False, width=99)
