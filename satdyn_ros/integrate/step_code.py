"""
The code of a step: of one motion, or of many side by side in the lanes of SIMD vectors.

It is made once for each kind of Constants, by calling the equations with symbols.  What it reads
and writes are the arrays of layout.py.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

from ..dynamics.constants import Constants
from ..dynamics.equations import rates
from ..dynamics.variables import Variables
from ..kernel.code_folder import code_folder, other_processor
from ..trace.emit import Program
from ..trace.graph import Graph, Symbol, kind_of, symbols_like
from ..trace.load import Code
from .dop853 import combination, error_of, part_before_corner, stage_time
from .layout import (
    ARRAYS,
    ERROR,
    EVALUATED,
    FROM_S,
    PACK,
    PART,
    STAGE_S,
    STAGES,
    UNTIL_S,
    H,
    Layout,
    T,
    row_length,
)
from .tableau import DENSE, ERROR_3, ERROR_5


class StepCode(NamedTuple):
    """
    Functions of a table of the addresses of ARRAYS.

    code: keeps them in memory.  attempt: takes the step h from the first row of dense at t
    to y, with its error and the part before a corner.  dense: makes the terms of its dense output.
    layout: of the kind.
    """

    code: Code
    attempt: int
    dense: int
    layout: Layout


_known: dict[tuple, StepCode] = {}


def step_code(constants: Constants, lanes: int) -> StepCode:
    """
    Return the code for a kind of Constants, made at the first call.

    ValueError, in one sentence: a torque of one's own cannot be computed.
    """
    kind = lanes, kind_of(constants)
    if kind not in _known:
        code = Code(text_of(constants, lanes), code_folder(), other_processor())
        addresses = code.address('attempt'), code.address('dense')
        _known[kind] = StepCode(code, *addresses, Layout.of(constants))
    return _known[kind]


def text_of(constants: Constants, lanes: int) -> str:
    """Return the IR for a kind of Constants."""
    return _Step(constants, lanes).text()


class _Step:
    """The functions of a step, while they are written."""

    def __init__(self, constants: Constants, lanes: int):
        self._like, self._lanes, self._size = constants, lanes, Variables.of(constants).size
        self._width = row_length(self._size, lanes)
        self._program = Program()

    def text(self) -> str:
        """Return the IR."""
        self._add_evaluation()
        self._add('stage_times', self._stage_times)
        self._add('judge', self._judge)
        self._add_in_packs('sum_errors', self._errors)
        self._add_in_packs('first_terms', self._first_terms)
        for row in range(1, STAGES):
            self._add_in_packs(f'combine_{row}', self._combined(row))
        self._add_in_packs('last_terms', self._last_terms)
        self._program.add_sequence('attempt', ARRAYS, self._attempt())
        self._program.add_sequence('dense', ARRAYS, self._dense())
        return self._program.text

    # -- sequences ----------------------------------------------------------------------------

    def _attempt(self):
        yield 'stage_times', {}
        for i in range(EVALUATED):
            yield 'evaluate', self._at_stage(i, ('y', 0) if i else ('dense', 0))
            yield f'combine_{i + 1}', {'z': ('y', 0)}
        yield 'sum_errors', {}
        yield 'judge', {}

    def _dense(self):
        yield 'stage_times', {}
        yield 'evaluate', self._at_stage(12, ('y', 0))
        yield 'first_terms', {}
        scratch = 'dense', 7 * self._row
        for i in range(13, STAGES):
            yield f'combine_{i}', {'z': scratch}
            yield 'evaluate', self._at_stage(i, scratch)
        yield 'last_terms', {}

    @property
    def _row(self):
        return self._width * self._lanes

    def _at_stage(self, i, y):
        now = 'frame', (STAGE_S + i) * self._lanes
        return {'y': y, 'now': now, 'stage': ('k', i * self._row)}

    # -- functions of whole motions -----------------------------------------------------------

    def _add_evaluation(self):
        graph = Graph()
        h, t_s = graph.input('frame', H), graph.input('now')
        f = rates(t_s, self._variables(graph, 'y', 0), self._constants(graph))
        stages = {('stage', i): h * each for i, each in enumerate(f)}
        stages |= {('stage', i): 0.0 for i in range(len(f), self._width)}
        # Once, not in each of its sixteen calls.
        pack = PACK if self._lanes == 1 else 1
        self._program.add('evaluate', graph, stages, self._lanes, is_inlined=False, pack=pack)

    def _add(self, name, results_of: Callable[..., dict]):
        graph = Graph()
        t, h = graph.input('frame', T), graph.input('frame', H)
        span = graph.input('frame', FROM_S), graph.input('frame', UNTIL_S)
        results = results_of(graph, t, h, span, self._constants(graph))
        self._program.add(name, graph, results, self._lanes)

    def _stage_times(self, graph, t, h, span, constants):
        return {
            ('frame', STAGE_S + i): stage_time(i, t, h, span, constants) for i in range(STAGES)
        }

    def _judge(self, graph, t, h, span, constants):
        y_0, y = self._variables(graph, 'dense', 0), self._variables(graph, 'y', 0)
        k_0, k_11 = self._variables(graph, 'k', 0), self._variables(graph, 'k', 11)
        e_3, e_5 = self._variables(graph, 'errors', 0), self._variables(graph, 'errors', 1)
        return {
            ('frame', ERROR): error_of(y_0, y, k_0, e_3, e_5, h, constants),
            ('frame', PART): part_before_corner(y_0, y, k_0, k_11, t, h, span, constants),
        }

    def _variables(self, graph, array, row):
        begin = row * self._width
        return tuple(graph.input(array, begin + i) for i in range(self._size))

    def _constants(self, graph):
        return symbols_like(self._like, graph, 'constants', 'arrays')

    # -- functions of variables, all alike ----------------------------------------------------

    def _add_in_packs(self, name, results_of: Callable[[Callable[..., Symbol]], dict[Any, Any]]):
        """Add a function of each variable; of one motion, several at once."""
        graph, results = Graph(), {}
        at_once = 1 if self._lanes > 1 else PACK
        length = self._width // at_once
        for i in range(length):

            def number(array, row, i=i):
                return graph.input(array, row * length + i)

            for (array, row), result in results_of(number).items():
                results[array, row * length + i] = result
        self._program.add(name, graph, results, self._lanes if self._lanes > 1 else PACK)

    def _combined(self, row):
        def results(number):
            total = combination(row, lambda j: number('k', j))
            return {('z', 0): number('dense', 0) + total}

        return results

    def _errors(self, number):
        return {
            ('errors', i): combination(row, lambda j: number('k', j))
            for i, row in enumerate((ERROR_3, ERROR_5))
        }

    def _first_terms(self, number):
        rise, k_0, k_12 = number('y', 0) - number('dense', 0), number('k', 0), number('k', 12)
        return {
            ('dense', 1): rise,
            ('dense', 2): k_0 - rise,
            ('dense', 3): 2.0 * rise - (k_0 + k_12),
        }

    def _last_terms(self, number):
        return {
            ('dense', 4 + n): combination(DENSE + n, lambda j: number('k', j)) for n in range(4)
        }
