"""Functions of tuples give what a loop in Python gives."""

from numba import njit

from satdyn_ros.kernel.unroll import by_type, unrolled_fold, unrolled_map


@unrolled_map
def products(i, a, b, factor):
    return a[i] * b[i] * factor


@unrolled_fold
def weighted(total, i, a, b):
    return total + a[i] * b[i]


nested_sum = by_type(lambda row: row[0] + row[1], lambda number: number)


@njit
def run(a, b, factor):
    return products(a, b, factor), weighted(factor, a, b)


@njit
def sums(rows, number):
    return nested_sum(rows), nested_sum(number)


def test_for_each_place_and_in_turn():
    """Every place once, in order, of any number of places."""
    for count in range(4):
        a, b = tuple(float(i + 1) for i in range(count)), tuple(0.5 for _ in range(count))
        each, total = run(a, b, 3.0)
        assert each == tuple(1.5 * (i + 1) for i in range(count))
        assert total == 3.0 + sum(0.5 * (i + 1) for i in range(count))


def test_by_the_type_of_the_first():
    """A tuple and a number are told apart when the code is made."""
    assert sums((1.0, 2.0), 5.0) == (3.0, 5.0)
