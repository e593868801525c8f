"""A copy of the package with files beside those that it has."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]


class PackageWith:
    """
    A folder with the package and some files in it, which processes import that run there.

    files: each goes into the room that has the name of its folder.
    """

    def __init__(self, folder, *files):
        self.folder = folder
        skipped = shutil.ignore_patterns('__pycache__')
        shutil.copytree(ROOT / 'satdyn_ros', folder / 'satdyn_ros', ignore=skipped)
        for file in files:
            shutil.copy(file, folder / 'satdyn_ros' / file.parent.name)
        paths = filter(None, (str(folder), os.environ.get('PYTHONPATH')))
        self._environment = os.environ | {'PYTHONPATH': os.pathsep.join(paths)}

    def write(self, name, values):
        """Write the values of a scenario as NAME.yaml."""
        lines = ''.join(f'    {key}: {value}\n' for key, value in values.items())
        text = f'/**:\n  ros__parameters:\n{lines.replace(chr(39), "")}'
        (self.folder / f'{name}.yaml').write_text(text)

    def run(self, *arguments, code=0):
        """Return what a program of Python prints."""
        done = subprocess.run(
            [sys.executable, *arguments],
            cwd=self.folder,
            env=self._environment,
            capture_output=True,
            text=True,
        )
        assert done.returncode == code, done.stdout + done.stderr
        return done.stdout + done.stderr

    def satdyn(self, *arguments, code=0):
        """Return what the command satdyn prints."""
        return self.run('-m', 'satdyn_ros.cli.main', *arguments, code=code)
