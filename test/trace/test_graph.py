"""What cannot be known when code is made says so."""

import math

import numpy as np
import pytest

from satdyn_ros.trace.graph import Graph, flatten, kind_of, symbols_like


@pytest.fixture
def x():
    return Graph().input('x')


@pytest.mark.parametrize(
    ('use', 'why'),
    [
        (lambda x: 1 if x > 0.0 else 2, 'must choose by select'),
        (lambda x: x and 1.0, 'must choose by select'),
        (lambda x: math.sin(x), 'asks for a number'),
        (lambda x: [1.0, 2.0][x], 'asks for a number'),
        (lambda x: x**0.5, 'an exponent must be a whole number above 0'),
        (lambda x: x**x, 'an exponent must be a whole number above 0'),
        (lambda x: 2.0**x, 'unsupported operand'),
        (lambda x: x * np.zeros(3), 'a value of type ndarray, not with numbers'),
        (lambda x: x - (1.0, 2.0), 'a value of type tuple'),
        (lambda x: not x > 1.0, 'must choose by select'),
        (lambda x: 0.0 < x < 1.0, 'must choose by select'),
    ],
)
def test_what_needs_a_number_is_refused(x, use, why):
    """A branch, a function of math, an index, a power."""
    with pytest.raises(TypeError, match=why):
        use(x)


def test_what_is_computed_twice_is_computed_once(x):
    """Equal operations are one; a zero below is not one above."""
    assert (x + 1.0) is (x + 1.0)
    assert (x + 0.0) is not (x + -0.0)
    graph = x.graph
    graph.call(_twice, x)
    assert graph.call(_twice, x)[0] is graph.call(_twice, x)[0]
    assert len(graph.subroutines) == 1


def _twice(a):
    return (a + a,)


def test_an_array_is_read_by_whole_numbers(x):
    """As NumPy's: from the end too, by rows, and in a loop."""
    array = x.graph.array('arrays', 0, (2, 3))
    assert array[1, -1] is array[1][2]
    assert [len(row) for row in array] == [3, 3]
    with pytest.raises(TypeError, match='must be a whole number'):
        array[0.5]
    with pytest.raises(IndexError):
        array[2]


def test_constants_are_numbers_and_arrays():
    """A change of numbers is no other kind; of a bool, a shape or a number of them it is."""
    array = np.zeros((2, 3))
    given = (1.0, (True, (2.0, array)), 3.0)
    assert flatten(given) == ([1.0, 2.0, 3.0], [array])
    other = (0.0, (True, (0.0, array + 1.0)), 0.0)
    assert kind_of(given) == kind_of(other)
    for each in ((1.0, (False, (2.0, array)), 3.0), (1.0, (True, (2.0, array[:1])), 3.0)):
        assert kind_of(given) != kind_of(each)
    a, (truth, (b, found)), c = symbols_like(given, Graph(), 'numbers', 'arrays')
    assert [each.operands for each in (a, b, c)] == [
        ('numbers', 0),
        ('numbers', 1),
        ('numbers', 2),
    ]
    assert (truth, found.shape, found.address.operands) == (True, (2, 3), ('arrays', 0))
