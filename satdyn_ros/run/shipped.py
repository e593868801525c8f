"""
The scenarios, sweeps and parts that come with the package, by name.

The scenario default is config/default.yaml, the sweep capture is config/sweeps/capture.yaml, the
part tactical_gyro is config/parts/tactical_gyro.yaml.
"""

from pathlib import Path

_PACKAGE = Path(__file__).parents[1]
# A checkout, and what pip and colcon install beside lib/pythonX.Y/site-packages.
_FOLDERS = (_PACKAGE.parent / 'config', *(p / 'share/satdyn_ros/config' for p in _PACKAGE.parents))
_PATTERNS = {'scenario': '{}.yaml', 'sweep': 'sweeps/{}.yaml', 'part': 'parts/{}.yaml'}
# Several satellites, and the scenarios that sweeps start from.
_LEFT_OUT = ('constellation', 'smelt_body', 'beletsky_satellite')


def names(what: str = 'scenario') -> list[str]:
    """Return the names of the scenarios, sweeps or parts that are shipped."""
    return [path.stem for path in paths(what) if path.stem not in _LEFT_OUT]


def paths(what: str) -> list[Path]:
    """Return the files of all scenarios, sweeps or parts that are shipped, by their names."""
    folder = next((folder for folder in _FOLDERS if folder.is_dir()), None)
    return sorted(folder.glob(_PATTERNS[what].format('*'))) if folder else []


def scenario_path(given: str | Path) -> Path:
    """
    Return the file of a scenario that is given as a path, or by name if it is shipped.

    ValueError: a bare name that is neither, or a file that is missing and shipped by its name.
    """
    return _path(given, 'scenario')


def sweep_path(given: str | Path) -> Path:
    """Return the file of a sweep in the same way."""
    return _path(given, 'sweep')


def _path(given, what):
    path = Path(given)
    # A folder of this name, such as that of the results, is not a file.
    if path.exists() and not path.is_dir():
        return path
    if path.suffix or len(path.parts) > 1:
        if not path.exists() and path.stem in names(what):
            raise ValueError(
                f'the {what} {given} cannot be read: there is no such file; one of this name is '
                f'shipped: {path.stem}'
            )
        return path
    for folder in _FOLDERS:
        shipped = folder / _PATTERNS[what].format(given)
        if shipped.is_file():
            return shipped
    raise ValueError(
        f'the {what} {given} is neither a file nor a shipped {what}; shipped: '
        f'{", ".join(names(what))}'
    )
