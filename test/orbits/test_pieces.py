"""Pieces hold their function, whatever is asked for and in which order."""

import subprocess
import sys
import threading
import warnings
import weakref

import numpy as np
import pytest

from satdyn_ros.kernel.time_table import interpolate
from satdyn_ros.orbits import KeplerOrbit
from satdyn_ros.orbits.pieces import (
    PIECE_TURN,
    Piece,
    Pieces,
    Stretch,
    ending_at,
    fitted,
    no_longer,
    whole_seconds,
)

COLUMNS = np.arange(3)


def waves(t_s):
    return np.stack([np.sin(1e-3 * t_s), np.cos(2e-3 * t_s), 1e-3 * t_s], axis=-1)


def pieces():
    return Pieces(fitted(waves), [Stretch(12.3, 70.1)])


def test_pieces_are_their_function_before_and_after_tick_0():
    """To 1e-10 of its largest value, at times drawn at random."""
    t_s = np.random.default_rng(1).uniform(-5000.0, 5000.0, 300)
    np.testing.assert_allclose(pieces().values(t_s, COLUMNS), waves(t_s), rtol=0.0, atol=1e-13)


@pytest.mark.parametrize('e', [0.0, 0.1, 0.73, 0.9, 0.99])
def test_the_turn_of_a_piece_is_short_enough_for_any_ellipse(e):
    """A position is within 1e-10 of the largest, around the pericentre too."""
    orbit = KeplerOrbit(semi_major_axis=7e6 / (1.0 - e), eccentricity=e, inclination=0.9)
    length_s = PIECE_TURN / float(orbit.rate(0.0))
    table = Pieces(fitted(lambda t_s: orbit.position_velocity(t_s)[0]), [Stretch(0.0, length_s)])
    t_s = np.random.default_rng(1).uniform(-5000.0, 5000.0, 300)
    true, _ = orbit.position_velocity(t_s)
    worst = np.max(np.abs(table.values(t_s, COLUMNS) - true))
    assert worst < min(1e-3, 1e-10 * np.max(np.abs(true)))


def test_the_bits_are_the_same_in_any_order_and_company():
    """Of one time alone, of many, in any order, of a table that was asked before or not."""
    t_s = np.random.default_rng(3).uniform(-2000.0, 20000.0, 400)
    right = pieces().values(t_s, COLUMNS)
    asked = pieces()
    for i in np.random.default_rng(4).permutation(len(t_s)):
        np.testing.assert_array_equal(asked.values(t_s[i : i + 1], COLUMNS)[0], right[i])
    order = np.argsort(t_s)
    np.testing.assert_array_equal(asked.values(t_s[order], COLUMNS), right[order])


def test_the_equations_see_the_same_bits():
    """What the look-up says of the one piece."""
    table, t_s = pieces(), np.random.default_rng(5).uniform(0.0, 3000.0, 30)
    right = table.values(t_s, COLUMNS)
    alone = [[interpolate(table.table_in(table.piece_at(t)), i, t) for i in range(3)] for t in t_s]
    np.testing.assert_array_equal(alone, right)


def test_a_time_belongs_to_the_piece_that_begins_there():
    """However the edges are rounded."""
    stretch = Stretch(0.1, 1.0 / 3.0)
    for k in range(-50, 50):
        edge_s = stretch.edge_s(k)
        assert stretch.number(edge_s) == k
        assert stretch.number(np.nextafter(edge_s, -np.inf)) == k - 1


def test_a_thread_makes_the_next_piece_ahead():
    """It is there without having been asked for, and one that cannot be made disturbs nobody."""
    made, ahead = [], threading.Event()

    def make(piece):
        made.append((piece.number, threading.current_thread() is threading.main_thread()))
        if piece.number == 1:
            ahead.set()
            raise ValueError('not this one')
        return np.zeros((1, 2))

    table = Pieces(make, [Stretch(0.0, 1.0)])
    table.table_in(table.piece_at(0.5))
    assert ahead.wait(60.0)
    assert made == [(0, True), (1, False)]
    with pytest.raises(ValueError, match='not this one'):
        table.table_in(table.piece_at(1.5))


END = """
import threading
import numpy as np
from satdyn_ros.orbits.pieces import Piece, Pieces, Stretch

table = Pieces(lambda piece: np.zeros((1, 2)), [Stretch(0.0, 1.0)])

def go_on():
    threading.main_thread().join()
    for k in range(5):
        table.table_in(table.piece_at(k + 0.5))
    print('done')

threading.Thread(target=go_on).start()
"""


def test_a_thread_goes_on_where_the_program_ends():
    """Then Python starts no work any more, and there is no piece ahead."""
    ended = subprocess.run([sys.executable, '-c', END], capture_output=True, text=True)
    assert (ended.stdout, ended.stderr) == ('done\n', '')


def test_memory_does_not_grow_with_time():
    """Of a thousand pieces that were used, some dozens are kept."""
    kept: weakref.WeakSet[np.ndarray] = weakref.WeakSet()

    class Coefficients(np.ndarray):
        pass

    def make(piece):
        coefficients = np.zeros((1, 2)).view(Coefficients)
        kept.add(coefficients)
        return coefficients

    # A view of an array keeps it alive; np.ndarray cannot be hashed, this one is by its identity.
    Coefficients.__hash__ = lambda self: id(self)  # type: ignore[assignment]
    table = Pieces(make, [Stretch(0.0, 1.0)])
    table.values(np.arange(1000.0), COLUMNS[:1])
    assert len(kept) < 300


def test_where_stretches_meet_the_function_may_jump():
    """A time there belongs to the later one, a gap and what is beyond are refused."""

    def make(piece):
        return np.array([[piece.stretch.origin_s, 0.0]])

    table = Pieces(
        make,
        [Stretch(0.0, 5.0, 0.0, 10.0), Stretch(10.0, 2.0, 10.0, 14.0), Stretch(20, 2, 20, 22)],
        'not at {:g} s'.format,
    )
    t_s = np.array([0.0, 9.9, 10.0, 14.0, 20.0, 22.0])
    assert table.values(t_s, COLUMNS[:1])[:, 0].tolist() == [0, 0, 10, 10, 20, 20]
    assert table.piece_at(14.0) == Piece(table.stretches[1], 1)
    assert (table.covered_until(3.0), table.covered_until(20.0)) == (14.0, 22.0)
    for t in (-0.1, 15.0, 22.1):
        with pytest.raises(ValueError, match=f'not at {t:g} s'):
            table.table_in(table.piece_at(t))


@pytest.mark.parametrize('begin_s', [-np.inf, -30.0])
def test_pieces_end_at_given_times_too(begin_s):
    """Without a gap, none longer than before or shorter than half, and far away the same ones."""
    whole = Stretch(0.0, 10.0, begin_s, -1.0 * begin_s)
    times_s = [-29.0, 3.0, 20.0, 20.5] if np.isinf(begin_s) else [3.0, 20.0, 20.5]
    cut = ending_at([whole], times_s)
    assert [cut[0].begin_s, *(each.end_s for each in cut)] == [
        *(each.begin_s for each in cut),
        -1.0 * begin_s,
    ]
    table = Pieces(fitted(waves), cut)
    edges_s = [table.piece_at(t_s).begin_s for t_s in np.arange(-29.9, 29.9, 0.1)]
    assert {*times_s} <= {*edges_s}
    lengths = np.diff(np.unique(edges_s))
    assert np.all(lengths <= 10.0)
    # But between two times that are nearer to each other.
    assert np.sum(lengths < 5.0) == 1
    if np.isinf(begin_s):
        assert (table.piece_at(1234.0).begin_s, table.piece_at(1234.0).end_s) == (1230.0, 1240.0)


def test_long_pieces_are_cut_into_equal_ones():
    """Those that are short enough stay as they are, to the bit."""
    stretches = [Stretch(0.1, 0.7, 0.1, 2.2), Stretch(2.2, 0.2, 2.2, 4.2)]
    assert no_longer(stretches, 0.3) == [Stretch(0.1, 0.7 / 3, 0.1, 2.2), stretches[1]]


@pytest.mark.parametrize('end_s', [1234.5, 1249.999999, 12.3 + 70.1 * 17])
def test_what_is_known_for_a_while_has_pieces_up_to_its_end(end_s):
    """To a nanosecond, with the function's own sentence beyond, in whatever piece it ends."""

    def known(t_s):
        if np.any(t_s > end_s):
            raise ValueError('no waves any more')
        return waves(t_s)

    table = Pieces(fitted(known), [Stretch(12.3, 70.1)])
    t_s = np.linspace(0.0, end_s - 1e-9, 400)
    np.testing.assert_allclose(table.values(t_s, COLUMNS), waves(t_s), rtol=0.0, atol=1e-13)
    found_s = table.piece_at(t_s[-1]).end_s
    assert abs(found_s - end_s) < 1e-9
    assert table.known_rows(np.arange(0.0, 2000.0)) == (int(end_s) + 1, 'no waves any more')
    with pytest.raises(ValueError, match='no waves any more'):
        table.piece_at(end_s + 1e-6)
    with pytest.raises(ValueError, match='no waves any more'):
        table.piece_from(found_s)


def test_a_function_of_whole_seconds_is_not_asked_where_its_piece_ends():
    """There it may have jumped; a piece within a second takes the second that it is in."""
    asked = []

    def count(t_s):
        asked.extend(t_s.tolist())
        return np.floor(t_s / 100.0)[:, None]

    make = whole_seconds(count, epoch_ns=0)
    for begin_s, end_s, own in ((0.0, 100.0, 0.0), (100.0, 200.0, 1.0), (199.3, 199.6, 1.0)):
        stretch = Stretch(begin_s, end_s - begin_s, begin_s, end_s)
        series = make(Piece(stretch, 0))[0]
        np.testing.assert_allclose(series, [own, *np.zeros(15)], atol=1e-12)
    assert max(asked) == 199.0


@pytest.mark.parametrize('grown', [lambda t_s: np.exp(t_s), lambda t_s: t_s + 1e200**2])
def test_numbers_beyond_their_range_are_refused(grown):
    """Those of NumPy and of Python, in one sentence and without a warning."""
    table = Pieces(fitted(lambda t_s: grown(t_s)[:, None]), [Stretch(0.0, 1000.0)])
    with warnings.catch_warnings():
        warnings.simplefilter('error')
        with pytest.raises(ValueError, match='beyond the range of numbers from 0 to 1000 s'):
            table.piece_at(900.0)
