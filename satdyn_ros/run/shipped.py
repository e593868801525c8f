"""The scenarios that come with the package, by name: 'default' is config/default.yaml."""

from pathlib import Path

_PACKAGE = Path(__file__).parents[1]
# A checkout, and what pip and colcon install beside lib/pythonX.Y/site-packages.
_FOLDERS = (_PACKAGE.parent / 'config', *(p / 'share/satdyn_ros/config' for p in _PACKAGE.parents))


def names() -> list[str]:
    """Return the names of the scenarios that are shipped, constellations left out."""
    folder = next((folder for folder in _FOLDERS if folder.is_dir()), None)
    found = folder.glob('*.yaml') if folder else ()
    return sorted(path.stem for path in found if path.stem != 'constellation')


def scenario_path(given: str | Path) -> Path:
    """
    Return the file of a scenario that is given as a path, or by name if it is shipped.

    ValueError: a bare name that is neither.
    """
    path = Path(given)
    if path.exists() or path.suffix or len(path.parts) > 1:
        return path
    for folder in _FOLDERS:
        if (folder / f'{given}.yaml').is_file():
            return folder / f'{given}.yaml'
    raise ValueError(
        f'the scenario {given} is neither a file nor a shipped scenario; shipped: '
        f'{", ".join(names())}'
    )
