"""A scenario as a ROS 2 parameter file: its satellites, and its keys from and to dotted names."""

import re
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from io import StringIO
from pathlib import Path
from types import MappingProxyType
from typing import Any

import yaml

from ..base import rcl_yaml, ros_yaml
from ..base.key import listed
from ..base.ndm_xml import is_xml
from ..orbits.element_sets import Catalogue
from . import shipped
from .keys import GROUPS, KEYS
from .orbits import TEXTS

# rclpy's own parameters, which it adds to every node's.
RCLPY_PARAMETERS = ('use_sim_time', 'start_type_description_service', 'qos_overrides')
_NONE: Mapping[str, Path] = MappingProxyType({})
_FULL_NAME = re.compile(r'(/[A-Za-z_][A-Za-z0-9_]*)+')
# A scenario has the text in its own, which is indented and may have 2 MB.
_LARGEST_FILE = 1_500_000
# An ephemeris in XML, of which less becomes the value.
_LARGEST_XML = 10_000_000
# That of which one element set is chosen: all that is tracked, in XML.
LARGEST_CATALOGUE = 100_000_000
# How two lines of an element set begin, and no name of a file.
_LINES = ('1 ', '2 ')
# The longest list of names that a sentence repeats.
_MOST_NAMES = 10


def scenario_text(path: str | Path) -> str:
    """Return the text of a scenario by its path, or by its name if it is shipped; ValueError."""
    return ros_yaml.read_text(shipped.scenario_path(path), 'the scenario')


@dataclass(frozen=True)
class ParameterFile:
    """
    What parameter files say together, as rcl merges them.

    A satellite is a section without wildcards; not that of another node, which has none of our
    groups of keys and a name of its own.

    Attributes
    ----------
    origin : str
        the files' names in errors
    sections : dict
        the parameters, dotted, of each section by its name
    """

    origin: str
    sections: Mapping[str, Mapping[str, Any]]

    @classmethod
    def read(cls, paths: Iterable[str | Path]) -> 'ParameterFile':
        """Return what files say, each given by its path or by its name if it is shipped."""
        paths = list(paths)
        directories = {str(path): shipped.scenario_path(path).parent for path in paths}
        return cls.of_texts([(scenario_text(path), str(path)) for path in paths], directories)

    @classmethod
    def of_texts(
        cls, texts: Iterable[tuple[str, str]], directories: Mapping[str, Path] = _NONE
    ) -> 'ParameterFile':
        """
        Return what texts, each with its name, say; ValueError: rcl would not read one.

        directories: by the name of a text the one from which it names files, if not the working
        directory.
        """
        texts = list(texts)
        origin = ' and '.join(name for _, name in texts)

        files = {name: _NamedFiles(directories.get(name, Path())) for _, name in texts}

        def value_of(key, value, name):
            return files[name].value_of(key, value)

        return cls(origin, rcl_yaml.sections(texts, value_of))

    @property
    def satellites(self) -> list[str]:
        """The full names of the satellites, /satdyn and satdyn being one."""
        sections = self.sections.items()
        return list(
            dict.fromkeys(_full(name) for name, own in sections if _is_satellite(name, own))
        )

    def full_name(self, satellite: str | None = None) -> str:
        """
        Return the full name of a satellite.

        satellite: its full name, or its namespace where the node is satdyn; None: the one
        satellite of the file, or /satdyn where it has none.  ValueError, which lists them: it has
        several, or not this one.
        """
        found = self.satellites
        if satellite is None:
            if len(found) > 1:
                raise ValueError(
                    f'{self.origin} has {len(found)} satellites; --satellite must choose one of '
                    f'them (in Python satellite=, in launch namespace:=): {_names(found)}'
                )
            return found[0] if found else '/satdyn'
        given = _full(satellite)
        for name in (given, f'{given}/satdyn'):
            if name in found:
                return name
        if found:
            raise ValueError(f'{self.origin} has no satellite {satellite}; it has {_names(found)}')
        if not _FULL_NAME.fullmatch(given):
            raise ValueError(
                f'the satellite {satellite!r} must be a full name or a namespace, such as '
                '/sat1/satdyn or /sat1'
            )
        return given if given.endswith('/satdyn') else f'{given}/satdyn'

    def full_names(self, satellites: Sequence[str] = ()) -> list[str]:
        """
        Return the full names of satellites, each once.

        satellites: as of full_name; none: all of the file, or /satdyn where it has none.
        """
        return list(
            dict.fromkeys(map(self.full_name, satellites or self.satellites or ['/satdyn']))
        )

    def parameters(self, full_name: str) -> dict[str, Any]:
        """
        Return the parameters of a node: those of all sections that match its full name, in order.

        Parameters of rclpy are among them.  ValueError: no section does.
        """
        matching = [name for name in self.sections if rcl_yaml.matches(name, full_name)]
        if not matching:
            raise ValueError(
                f'{self.origin} has no section for this node, {full_name}; it has '
                f'{_names(self.sections) or "none"}; /** is one for every node'
            )
        parameters: dict[str, Any] = {}
        for name in matching:
            parameters.update(self.sections[name])
        return parameters

    def own(self, full_name: str) -> set[str]:
        """Return the names of the parameters that the sections of a node alone give."""
        own = [keys for name, keys in self.sections.items() if _full(name) == full_name]
        return set().union(*own)

    def common(self, full_name: str) -> dict[str, Any]:
        """Return the parameters that a node has of sections for several; none match: none."""
        own, common = self.own(full_name), {}
        for name, section in self.sections.items():
            if rcl_yaml.matches(name, full_name):
                common.update({key: x for key, x in section.items() if key not in own})
        return common

    def flown(self, full_name: str, section: str | None = None) -> dict[str, Any]:
        """
        Return the parameters of a node, with frames of its own; ValueError: as parameters.

        section: the satellite of the file that it flies, None: the one of its name.
        """
        name = section or full_name
        return with_own_frames(self.parameters(name), full_name, self.own(name))

    def unused(self, *full_names: str) -> list[str]:
        """Return, in a sentence, the sections that match the full name of none of some nodes."""
        unused = [
            section
            for section in self.sections
            if not any(rcl_yaml.matches(section, name) for name in full_names)
        ]
        if not unused:
            return []
        sections = f'the sections {_names(unused)}' if unused[1:] else f'the section {unused[0]}'
        use = 'do not use' if full_names[1:] else 'does not use'
        return [f'{self.origin}: {_names(full_names)} {use} {sections}']


def folder_of(full_name: str) -> str:
    """Return where the bags of one of several satellites go: sat4 for /sat4/satdyn."""
    return full_name.removesuffix('/satdyn').lstrip('/')


def with_own_frames(
    parameters: Mapping[str, Any], full_name: str, own: Collection[str]
) -> dict[str, Any]:
    """
    Return the parameters of a node with its namespace, if any, before the frames of its own.

    These are of LVLH, the body and the sensors, as in sat4/base_link, but for those of the keys
    own, which are given to this node alone.
    """
    namespace = full_name.rpartition('/')[0].removeprefix('/')
    flown = dict(parameters)
    for key, default in _frames_of_one(parameters) if namespace else ():
        frame = parameters.get(key, default)
        # What is no text, or an empty one, is refused as it was given.
        if key not in own and isinstance(frame, str) and frame:
            flown[key] = f'{namespace}/{frame}'
    return flown


def without_rclpys(parameters: Mapping[str, Any]) -> dict[str, Any]:
    """Return the parameters that are a scenario's, and not rclpy's own."""
    return {k: v for k, v in parameters.items() if k.split('.')[0] not in RCLPY_PARAMETERS}


def with_texts(parameters: Mapping[str, Any]) -> dict[str, Any]:
    """Return parameters with the texts of the files that they name, from the working directory."""
    files = _NamedFiles(Path())
    return {key: files.value_of(key, value) for key, value in parameters.items()}


class _NamedFiles:
    """
    The texts of the files that parameters name, as seen from a directory.

    Of a file of many element sets the one that is chosen; such a file is read once.
    """

    def __init__(self, directory: Path):
        self._directory = directory
        self._catalogues: dict[str, Catalogue] = {}

    def value_of(self, key: str, value: Any) -> Any:
        """
        Return a value, the text of a file in place of its name.

        The name is a text without a line break, a list of one such, or of one and what is chosen
        of the file.

        ValueError: it cannot be read, or has not what is chosen of it.
        """
        if key not in TEXTS:
            return value
        match value:
            case [str(name)]:
                return [self._text(key, name)]
            case [str(name), str(word)] if not name.startswith(_LINES) and '\n' not in name:
                return [self._chosen(key, name, word)]
            case str(name):
                return self._text(key, name)
        return value

    def _text(self, key, name):
        if not name or '\n' in name:
            return name
        text = self._of_kernel(key, name) or self._of_text(key, name)
        if len(text) > _LARGEST_FILE:
            raise ValueError(f'{key} {name} is larger than the {_LARGEST_FILE} bytes allowed')
        # A line break at its end distinguishes a text of one line from a name.
        return ''.join(f'{line.rstrip()}\n' for line in StringIO(text, newline=None))

    def _of_text(self, key, name):
        """Return the text of a file, an ephemeris in XML in the notation of fewer characters."""
        text = ros_yaml.read_text(self._directory / name, key, _LARGEST_XML)
        if key != 'orbit.file' or not is_xml(text):
            return text
        from ..orbits.ephemeris import oem_of_xml

        with _in(f'{key} {name}'):
            return oem_of_xml(text)

    def _of_kernel(self, key, name):
        """Return the ephemeris that a kernel of SPICE holds as text; None: it is none."""
        from ..orbits.spk import is_spk, oem_of_spk

        path = self._directory / name
        if key != 'orbit.file' or not is_spk(path):
            return None
        with _in(f'{key} {name}'):
            return oem_of_spk(path)

    def _chosen(self, key, name, word):
        """Return the text of one of the element sets in a file."""
        from ..orbits.tle import checked

        if name not in self._catalogues:
            text = ros_yaml.read_text(self._directory / name, key, LARGEST_CATALOGUE)
            with _in(f'{key} {name}'):
                self._catalogues[name] = Catalogue(text)
        with _in(f'{key} {name}'):
            return checked(self._catalogues[name].chosen(word)).text


@contextmanager
def _in(file):
    """Name the file in what is said of it."""
    try:
        yield
    except ValueError as error:
        raise ValueError(f'{file}: {error}') from error.__cause__


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
    section = {'/**': {rcl_yaml.PARAMETERS: nested}}
    return yaml.dump(section, Dumper=_Dumper, sort_keys=False, allow_unicode=True, width=99)


def parameters_of_record(text: str, origin: str) -> dict[str, Any]:
    """
    Return the parameters, dotted, of what yaml_of_parameters wrote.

    Bags of earlier versions have it with a rotor's name y unquoted, which rcl takes for true.
    """
    match ros_yaml.load(text, origin, len(text)):
        case {'/**': {rcl_yaml.PARAMETERS: Mapping() as nested}}:
            return dict(flattened(nested))
    raise ValueError(f'{origin} has no section /** with {rcl_yaml.PARAMETERS}')


class _Dumper(yaml.SafeDumper):
    """Quotes a text that rcl would take for something else, such as y, which is true to it."""


def _represent_text(dumper, text):
    is_plain = rcl_yaml.word(text) == text and len(text) <= ros_yaml.LONGEST_PLAIN
    style = '|' if '\n' in text else None if is_plain else "'"
    if ros_yaml.TO_ESCAPE.search(text):
        style = '"'
    return dumper.represent_scalar('tag:yaml.org,2002:str', text, style=style)


_Dumper.add_representer(str, _represent_text)


def _frames_of_one(parameters):
    """Yield the keys, with their defaults, of the frames that no two satellites share."""
    for key in ('frames.orbital', 'frames.body'):
        yield key, KEYS[key].default
    sensors = parameters.get('sensors.names')
    for name in sensors if isinstance(sensors, list | tuple) else []:
        yield f'sensors.{name}.frame_id', name


def _is_satellite(name: str, own: Iterable[str]) -> bool:
    groups = {key.split('.')[0] for key in own}
    is_ours = _full(name).endswith('/satdyn') or not groups or not groups.isdisjoint(GROUPS)
    return is_ours and '*' not in name


def _full(name: str) -> str:
    return f'/{name.removeprefix("/")}'


def _names(names: Iterable[str]) -> str:
    given = list(names)
    shown = ', '.join(given[:_MOST_NAMES])
    return shown if len(given) <= _MOST_NAMES else f'{shown} and {len(given) - _MOST_NAMES} more'
