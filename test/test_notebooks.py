"""The notebooks run from the first cell to the last, and are kept without their output."""

from pathlib import Path

import pytest

NOTEBOOKS = sorted((Path(__file__).parents[1] / 'examples' / 'notebooks').glob('*.ipynb'))


@pytest.mark.long
@pytest.mark.parametrize('path', NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_runs(path):
    """Each cell ends without an error; what a cell asserts holds."""
    nbformat = pytest.importorskip('nbformat')
    client = pytest.importorskip('nbclient')
    notebook = nbformat.read(path, as_version=4)
    client.NotebookClient(notebook, timeout=300, resources={'metadata': {'path': '.'}}).execute()


@pytest.mark.parametrize('path', NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_is_kept_without_output(path):
    """What is run again anyway does not fill the history."""
    nbformat = pytest.importorskip('nbformat')
    for cell in nbformat.read(path, as_version=4).cells:
        assert not cell.get('outputs')
        assert cell.get('execution_count') is None
