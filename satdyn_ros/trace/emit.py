"""
Code of graphs: LLVM IR as text, of one motion or of several in the lanes of vectors.

Code reads and writes arrays of floats.  In lanes each number is as many floats, one of each
motion.  What is read is read before anything is written.
"""

import struct
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import llvmlite

from . import ieee
from .graph import COMPARISONS, Graph, Symbol

# Before LLVM 15 pointers have a type.
POINTER = 'ptr' if tuple(map(int, llvmlite.__version__.split('.')[:2])) >= (0, 44) else 'double*'
_IS_OPAQUE = POINTER == 'ptr'
_ARITHMETIC = ('fadd', 'fsub', 'fmul', 'fdiv')
# Not to be replaced by what the compiler knows of them, nor computed by it.
_AS_CALLED = 'nobuiltin nounwind readnone'


class Program:
    """
    Functions of one width that call each other.

    text: the IR of all.
    """

    def __init__(self) -> None:
        self._parts: list[str] = []
        self._declared: set[str] = set()
        self._arrays: dict[str, list[str]] = {}

    @property
    def text(self) -> str:
        """The IR."""
        return '\n'.join([*sorted(self._declared), *self._parts])

    def add(
        self,
        name: str,
        graph: Graph,
        results: Mapping[tuple[str, int], Any],
        lanes: int = 1,
        is_inlined: bool = True,
        pack: int = 1,
    ) -> None:
        """
        Add a function for sequences that writes results, by their array and offset in it.

        is_inlined: into the sequence, which may pay where it is called once.  pack: so many
        results in a row, in one array, are written at once: who reads them at once need not wait
        for each.
        """
        emitter = _Emitter(lanes)
        for symbol in graph.needed_for(results.values()):
            emitter.add(symbol)
        for n, ((array, offset), result) in enumerate(results.items()):
            if pack == 1:
                emitter.store(array, offset, result)
            elif n % pack == 0:
                emitter.store_pack(array, offset, [*results.values()][n : n + pack])
        self._add_subroutines(graph, lanes)
        self._arrays[name] = sorted(emitter.arrays)
        pointers = ', '.join(f'{POINTER} %{each}' for each in self._arrays[name])
        how = 'alwaysinline' if is_inlined else 'noinline'
        self._declared |= emitter.declared
        self._define(f'internal void @{name}({pointers}) {how}', [*emitter.lines, 'ret void'])

    def add_sequence(
        self,
        name: str,
        arrays: Sequence[str],
        calls: Iterable[tuple[str, Mapping[str, tuple[str, int]]]],
    ) -> None:
        """
        Add a function, known from outside, of a table of the arrays' addresses.

        calls: the functions that it calls and, by the names of their arrays, which arrays they
        get, from which float on; others have the same name.
        """
        lines = []
        for i, array in enumerate(arrays):
            lines += [
                f'%at_{array} = getelementptr double, {POINTER} %table, i64 {i}',
                f'%bits_{array} = load double, {POINTER} %at_{array}',
                f'%address_{array} = bitcast double %bits_{array} to i64',
                f'%{array} = inttoptr i64 %address_{array} to {POINTER}',
            ]
        pointers: dict[tuple[str, int], str] = {}
        for function, given in calls:
            passed = []
            for array in self._arrays[function]:
                where = given.get(array, (array, 0))
                if where not in pointers:
                    pointers[where] = f'%p{len(pointers)}'
                    of, offset = where
                    lines.append(
                        f'{pointers[where]} = getelementptr double, {POINTER} %{of}, i64 {offset}'
                    )
                passed.append(f'{POINTER} {pointers[where]}')
            lines.append(f'call void @{function}({", ".join(passed)})')
        self._define(f'void @{name}({POINTER} %table)', [*lines, 'ret void'])

    def _add_subroutines(self, graph, lanes):
        for name, (inner, results) in graph.subroutines.items():
            self._add_subroutines(inner, lanes)
            emitter = _Emitter(lanes)
            for symbol in inner.needed_for(results):
                emitter.add(symbol)
            returned = emitter.gathered(results)
            parameters = [s for s in inner.symbols if s.operation == 'parameter']
            typed = ', '.join(f'{emitter.kind} %v{s.number}' for s in parameters)
            # In lanes, code that is written out at each call takes seconds to compile.
            how = 'alwaysinline' if lanes == 1 else 'noinline'
            self._declared |= emitter.declared
            self._define(
                f'internal {emitter.several(results)} @{name}({typed}) {how}',
                [*emitter.lines, f'ret {returned}'],
            )

    def _define(self, head, lines):
        body = '\n'.join(f'  {line}' for line in lines)
        text = f'define {head} {{\n{body}\n}}'
        if text not in self._parts:
            self._parts.append(text)


def number(x: float) -> str:
    """Return a number as IR has it, bit by bit."""
    return f'0x{struct.unpack(">Q", struct.pack(">d", x))[0]:016X}'


class _Emitter:
    """The lines of one function."""

    def __init__(self, lanes: int):
        self.lines: list[str] = []
        self.declared: set[str] = set()
        self.arrays: set[str] = set()
        self._lanes = lanes
        self.kind = self._of_lanes('double')
        self._temporaries = 0

    def _of_lanes(self, kind):
        return kind if self._lanes == 1 else f'<{self._lanes} x {kind}>'

    def add(self, symbol: Symbol) -> None:
        """Write the operation of a symbol."""
        operation, operands = symbol.operation, symbol.operands
        if operation == 'parameter':
            return
        if operation == 'input':
            value = f'load {self._vectors(*operands)}'
        elif operation == 'load':
            value = self._load(*operands)
        elif operation in _ARITHMETIC:
            value = f'{operation} {self.typed(operands[0])}, {self._value(operands[1])}'
        elif operation == 'fneg':
            value = f'fneg {self.typed(operands[0])}'
        elif operation in COMPARISONS:
            value = f'fcmp {operation} {self.typed(operands[0])}, {self._value(operands[1])}'
        elif operation == 'select':
            condition, a, b = operands
            chosen = f'{self._of_lanes("i1")} {self._value(condition)}'
            value = f'select {chosen}, {self.typed(a)}, {self.typed(b)}'
        elif operation == 'call':
            name, *given = operands
            _, results = symbol.graph.subroutines[name]
            value = f'call {self.several(results)} @{name}({", ".join(map(self.typed, given))})'
        elif operation == 'extract':
            called, i = operands
            _, results = symbol.graph.subroutines[called.operands[0]]
            value = f'extractvalue {self.several(results)} {self._value(called)}, {i}'
        elif operation in ieee.EXACT:
            suffix = 'f64' if self._lanes == 1 else f'v{self._lanes}f64'
            intrinsic = f'{self.kind} @llvm.{operation}.{suffix}'
            self.declared.add(f'declare {intrinsic}({self.kind})')
            value = f'call {intrinsic}({self.typed(operands[0])})'
        else:
            value = self._of_c_library(operation, operands)
        self.lines.append(f'%v{symbol.number} = {value}')

    def store(self, array: str, offset: int, result: Any) -> None:
        """Write a result."""
        _, pointer = self._vectors(array, offset).split(', ', 1)
        self.lines.append(f'store {self.typed(result)}, {pointer}')

    def store_pack(self, array: str, offset: int, results: Sequence[Any]) -> None:
        """Write results of one motion, one after the other, at once."""
        kind, vector = f'<{len(results)} x double>', 'undef'
        for i, result in enumerate(results):
            put = f'insertelement {kind} {vector}, {self.typed(result)}, i32 {i}'
            vector = self._temporary(put)
        self.arrays.add(array)
        pointer, of = self._at(f'%{array}', offset), POINTER
        if not _IS_OPAQUE:
            of = f'{kind}*'
            pointer = self._temporary(f'bitcast {POINTER} {pointer} to {of}')
        self.lines.append(f'store {kind} {vector}, {of} {pointer}, align 8')

    def several(self, results: Sequence[Any]) -> str:
        """Return the type of several numbers."""
        return f'{{{", ".join([self.kind] * len(results))}}}'

    def gathered(self, results: Sequence[Any]) -> str:
        """Return several numbers as one value, with its type."""
        kind, value = self.several(results), 'undef'
        for i, result in enumerate(results):
            value = self._temporary(f'insertvalue {kind} {value}, {self.typed(result)}, {i}')
        return f'{kind} {value}'

    def typed(self, operand: Any) -> str:
        """Return an operand with its type."""
        return f'{self.kind} {self._value(operand)}'

    def _value(self, operand):
        if isinstance(operand, Symbol):
            return f'%v{operand.number}'
        text = number(operand)
        return text if self._lanes == 1 else f'<{", ".join([f"double {text}"] * self._lanes)}>'

    def _temporary(self, value):
        self._temporaries += 1
        self.lines.append(f'%t{self._temporaries} = {value}')
        return f'%t{self._temporaries}'

    def _at(self, pointer, offset):
        return self._temporary(f'getelementptr double, {POINTER} {pointer}, i64 {offset}')

    def _vectors(self, array, offset):
        """Return the operands of the load of a number of an array."""
        self.arrays.add(array)
        pointer, kind = self._at(f'%{array}', offset * self._lanes), POINTER
        if not _IS_OPAQUE and self._lanes > 1:
            kind = f'{self.kind}*'
            pointer = self._temporary(f'bitcast {POINTER} {pointer} to {kind}')
        return f'{self.kind}, {kind} {pointer}, align 8'

    def _load(self, address, index, offset):
        def load(address, index):
            bits = self._temporary(f'bitcast double {address} to i64')
            base = self._temporary(f'inttoptr i64 {bits} to {POINTER}')
            begin = self._at(base, self._temporary(f'fptosi double {index} to i64'))
            return f'load double, {POINTER} {self._at(begin, offset)}'

        return self._by_lane(load, (address, index))

    def _of_c_library(self, name, operands):
        kinds = ', '.join(['double'] * len(operands))
        self.declared.add(f'declare double @{name}({kinds}) {_AS_CALLED}')

        def call(*values):
            return f'call double @{name}({", ".join(f"double {x}" for x in values)})'

        return self._by_lane(call, operands)

    def _by_lane(self, function, operands):
        if self._lanes == 1:
            return function(*map(self._value, operands))
        gathered = 'undef'
        for lane in range(self._lanes):
            of_lane = [
                self._temporary(f'extractelement {self.typed(x)}, i32 {lane}')
                if isinstance(x, Symbol)
                else number(x)
                for x in operands
            ]
            found = self._temporary(function(*of_lane))
            put = f'insertelement {self.kind} {gathered}, double {found}, i32 {lane}'
            if lane == self._lanes - 1:
                return put
            gathered = self._temporary(put)
        raise AssertionError('there is no lane')
