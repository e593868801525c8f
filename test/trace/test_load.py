"""Machine code is kept by what it is made of, and found again."""

import ctypes

import pytest

from satdyn_ros.trace.emit import Program
from satdyn_ros.trace.graph import Graph
from satdyn_ros.trace.load import Code


def program(constant=2.0):
    """Return the IR of a function that multiplies a number by a constant."""
    graph = Graph()
    made = Program()
    made.add('scale', graph, {('x', 0): constant * graph.input('x')})
    made.add_sequence('run', ('x',), [('scale', {})])
    return made.text


def run(code):
    x = ctypes.c_double(3.0)
    table = (ctypes.c_int64 * 1)(ctypes.addressof(x))
    ctypes.CFUNCTYPE(None, ctypes.c_void_p)(code.address('run'))(ctypes.addressof(table))
    return x.value


def test_code_is_kept(tmp_path, monkeypatch):
    """What is there is not compiled again, and other IR is not taken for it."""
    assert run(Code(program(), tmp_path)) == 6.0
    (kept,) = tmp_path.iterdir()
    with monkeypatch.context() as patch:
        patch.setattr('satdyn_ros.trace.load._compiled', lambda *_: pytest.fail('it compiles'))
        assert run(Code(program(), tmp_path)) == 6.0
    assert run(Code(program(5.0), tmp_path)) == 15.0
    assert len([*tmp_path.iterdir()]) == 2
    monkeypatch.setattr('llvmlite.__version__', '0.0.1')
    assert kept.exists()
    Code(program(), tmp_path)
    assert len([*tmp_path.iterdir()]) == 3


def test_a_folder_that_is_gone_is_no_error(tmp_path):
    """The code is made, and not kept."""
    assert run(Code(program(), tmp_path / 'gone')) == 6.0


@pytest.mark.parametrize(
    'damage', [lambda code: code[:-9], lambda code: b'', lambda code: 9 * code]
)
def test_damaged_code_is_made_anew(tmp_path, damage):
    """As where a disk was full: it is neither run nor taken for good."""
    Code(program(), tmp_path)
    (kept,) = tmp_path.iterdir()
    whole = kept.read_bytes()
    kept.write_bytes(damage(whole))
    assert run(Code(program(), tmp_path)) == 6.0
    assert kept.read_bytes() == whole
