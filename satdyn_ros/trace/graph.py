"""Symbols in place of floats: what a function does to them is a graph of operations."""

import itertools
from collections.abc import Callable, Iterable, Iterator
from numbers import Real
from typing import Any

from . import ieee

COMPARISONS = ('olt', 'ole', 'ogt', 'oge', 'oeq', 'une')


class Graph:
    """
    The operations of one function, each once.

    subroutines: by their names, the graphs and results of functions that it calls.
    """

    def __init__(self) -> None:
        self.symbols: list[Symbol] = []
        self.subroutines: dict[str, tuple[Graph, tuple[Symbol, ...]]] = {}
        self._known: dict[tuple, Symbol] = {}

    def input(self, array: str, offset: int = 0) -> 'Symbol':
        """Return the number at an offset of an array that the code is given."""
        return self.node('input', array, offset)

    def array(self, addresses: str, offset: int, shape: tuple[int, ...]) -> 'SymbolArray':
        """Return an array whose address is at an offset of an array of addresses."""
        return SymbolArray(self.node('input', addresses, offset), shape)

    def node(self, operation: str, *operands: Any) -> 'Symbol':
        """Return the result of an operation on symbols and on what is known."""
        # -0.0 and 0.0 are equal and not the same.
        values = (x.number if isinstance(x, Symbol) else repr(x) for x in operands)
        key = operation, *values
        if key not in self._known:
            self._known[key] = Symbol(self, operation, operands, len(self.symbols))
            self.symbols.append(self._known[key])
        return self._known[key]

    def call(self, function: Callable[..., Any], *arguments: Any) -> tuple['Symbol', ...]:
        """
        Return function(*arguments), a tuple of symbols, as the call of a subroutine.

        It is traced once for all arguments of the same kinds: numbers, arrays of one shape, or the
        same whole numbers.
        """
        kinds = [*map(_kind, arguments)]
        name = '_'.join([function.__name__.strip('_'), *kinds])
        if name not in self.subroutines:
            inner = Graph()
            parameters = [_parameter(inner, i, each) for i, each in enumerate(arguments)]
            self.subroutines[name] = inner, function(*parameters)
        passed = (
            each.address if isinstance(each, SymbolArray) else _as_number(each)
            for each in arguments
            if not isinstance(each, int)
        )
        results = self.node('call', name, *passed)
        return tuple(
            self.node('extract', results, i) for i in range(len(self.subroutines[name][1]))
        )

    def needed_for(self, results: Iterable[Any]) -> Iterator['Symbol']:
        """Yield the symbols that some results are computed from, in an order that computes."""
        waiting = [each for each in results if isinstance(each, Symbol)]
        needed = set()
        while waiting:
            symbol = waiting.pop()
            if symbol.number not in needed:
                needed.add(symbol.number)
                waiting += (each for each in symbol.operands if isinstance(each, Symbol))
        yield from (self.symbols[number] for number in sorted(needed))


def _kind(argument):
    if isinstance(argument, SymbolArray):
        return 'x'.join(map(str, argument.shape))
    return str(argument) if isinstance(argument, int) else 'n'


def _parameter(graph, i, argument):
    if isinstance(argument, int):
        return argument
    symbol = graph.node('parameter', i)
    return SymbolArray(symbol, argument.shape) if isinstance(argument, SymbolArray) else symbol


class Symbol:
    """A number, or what a comparison gives, that is known when the code runs."""

    __slots__ = ('graph', 'number', 'operands', 'operation')
    # NumPy's scalars leave the operators to it.
    __array_ufunc__ = None

    def __init__(self, graph: Graph, operation: str, operands: tuple, number: int):
        self.graph, self.operation, self.operands, self.number = graph, operation, operands, number

    def __repr__(self) -> str:
        return f'<{self.operation} {self.number}>'

    def __bool__(self) -> bool:
        raise TypeError(
            'it branches on a number that is not known before the run; it must choose by select'
        )

    def _is_unknown(self, *_: Any) -> Any:
        raise TypeError('it asks for a number that is not known before the run')

    __float__ = __int__ = __index__ = __round__ = __trunc__ = _is_unknown
    __hash__ = object.__hash__

    def __add__(self, other: Any) -> Any:
        return apply('fadd', self, other)

    def __radd__(self, other: Any) -> Any:
        return apply('fadd', other, self)

    def __sub__(self, other: Any) -> Any:
        return apply('fsub', self, other)

    def __rsub__(self, other: Any) -> Any:
        return apply('fsub', other, self)

    def __mul__(self, other: Any) -> Any:
        return apply('fmul', self, other)

    def __rmul__(self, other: Any) -> Any:
        return apply('fmul', other, self)

    def __truediv__(self, other: Any) -> Any:
        return apply('fdiv', self, other)

    def __rtruediv__(self, other: Any) -> Any:
        return apply('fdiv', other, self)

    def __mod__(self, other: Any) -> Any:
        return _modulo(self, other)

    def __rmod__(self, other: Any) -> Any:
        return _modulo(other, self)

    def __floordiv__(self, other: Any) -> Any:
        return _whole_quotient(self, other)

    def __rfloordiv__(self, other: Any) -> Any:
        return _whole_quotient(other, self)

    def __and__(self, other: Any) -> Any:
        return apply('ogt', _as_number(_as_truth(self)) * _as_number(_as_truth(other)), 0.5)

    __rand__ = __and__

    def __or__(self, other: Any) -> Any:
        return apply('ogt', _as_number(_as_truth(self)) + _as_number(_as_truth(other)), 0.5)

    __ror__ = __or__

    def __invert__(self) -> Any:
        return apply('olt', _as_number(_as_truth(self)), 0.5)

    def __neg__(self) -> Any:
        return apply('fneg', self)

    def __pos__(self) -> Any:
        return self

    def __abs__(self) -> Any:
        return apply('fabs', self)

    def __floor__(self) -> Any:
        return apply('floor', self)

    def __pow__(self, exponent: Any) -> Any:
        """Return a whole power above 0 as the product from the left."""
        if isinstance(exponent, Symbol) or not exponent > 0 or exponent != int(exponent):
            raise TypeError(
                f'it takes a power of {exponent!r}; an exponent must be a whole number above 0'
            )
        power = self
        for _ in range(int(exponent) - 1):
            power = power * self
        return power

    def __lt__(self, other: Any) -> Any:
        return apply('olt', self, other)

    def __le__(self, other: Any) -> Any:
        return apply('ole', self, other)

    def __gt__(self, other: Any) -> Any:
        return apply('ogt', self, other)

    def __ge__(self, other: Any) -> Any:
        return apply('oge', self, other)

    def __eq__(self, other: Any) -> Any:
        return apply('oeq', self, other)

    def __ne__(self, other: Any) -> Any:
        return apply('une', self, other)


def _as_number(x):
    """Return 1 where a comparison holds, else 0; a number as it is."""
    if isinstance(x, Symbol):
        return apply('select', x, 1.0, 0.0) if x.operation in COMPARISONS else x
    if not isinstance(x, Real):
        raise TypeError(f'it computes with a value of type {type(x).__name__}, not with numbers')
    return float(x)


def _as_truth(x):
    """Return whether a number is not 0; a comparison as it is."""
    is_truth = isinstance(x, Symbol) and x.operation in COMPARISONS
    return x if is_truth else apply('une', x, 0.0)


def _modulo(a, b):
    """Return a % b as Python has it: with the sign of b."""
    rest = apply('fmod', a, b)
    is_other = ((rest < 0.0) & (b > 0.0)) | ((rest > 0.0) & (b < 0.0))
    return apply('select', is_other, rest + b, rest)


def _whole_quotient(a, b):
    """Return a // b as Python has it, where the quotient is exact."""
    return apply('floor', (a - _modulo(a, b)) / b + 0.5)


class SymbolArray:
    """An array whose address is known when the code runs."""

    def __init__(self, address: Symbol, shape: tuple[int, ...]):
        self.address, self.shape = address, shape

    def __len__(self) -> int:
        return self.shape[0]

    def __getitem__(self, index: Any) -> Any:
        """Return a number, or the rows below an index of fewer dimensions."""
        index = index if isinstance(index, tuple) else (index,)
        for i, length in zip(index, self.shape, strict=False):
            if not isinstance(i, int):
                raise TypeError(f'the index {i!r} of an array must be a whole number')
            if not -length <= i < length:
                raise IndexError(f'the index {i} is beyond the {length} of the array')
        if len(index) < len(self.shape):
            return [self.__getitem__((*index, i)) for i in range(self.shape[len(index)])]
        at = 0
        for i, length in zip(index, self.shape, strict=True):
            at = at * length + i % length
        return self.at(0.0, at)

    def at(self, index: Any, offset: int) -> Symbol:
        """Return what is `offset` after an index, a whole number: row by row."""
        return self.address.graph.node('load', self.address, index, offset)


def apply(operation: str, *operands: Any) -> Any:
    """
    Return the result of an operation: a number where all operands are, else a symbol.

    TypeError: an operand beside a symbol is neither, as an array is.
    """
    for operand in operands:
        if isinstance(operand, Symbol):
            if operation == 'select':
                condition, a, b = operands
                given = _as_truth(condition), _as_number(a), _as_number(b)
            else:
                given = tuple(map(_as_number, operands))
            return operand.graph.node(operation, *given)
    return ieee.OPERATIONS[operation](*operands)


def flatten(part: Any) -> tuple[list[float], list[Any]]:
    """
    Return the numbers of nested tuples, one after the other, and their arrays.

    What is neither, such as a bool, is known when the code is made.
    """
    numbers: list[float] = []
    arrays: list[Any] = []
    _flatten(part, numbers, arrays)
    return numbers, arrays


def _flatten(part, numbers, arrays):
    for each in part:
        if isinstance(each, tuple):
            _flatten(each, numbers, arrays)
        elif isinstance(each, float):
            numbers.append(each)
        elif _is_array(each):
            arrays.append(each)


def _is_array(part):
    return hasattr(part, 'shape')


def numbered(part: Any) -> Any:
    """
    Return nested tuples with the indices of their numbers in flatten's list in their stead.

    >>> numbered((1.5, (2.5, True, 3.5)))
    (0, (1, True, 2))
    """
    return _numbered(part, itertools.count())


def _numbered(part, indices):
    found = [
        _numbered(each, indices)
        if isinstance(each, tuple)
        else next(indices)
        if isinstance(each, float)
        else each
        for each in part
    ]
    return type(part)(*found) if hasattr(part, '_fields') else tuple(found)


def kind_of(part: tuple) -> tuple:
    """Return what code depends on of nested tuples: all but the numbers, in them and in arrays."""
    return (
        type(part),
        *(
            kind_of(each)
            if isinstance(each, tuple)
            else None
            if isinstance(each, float)
            else each.shape
            if _is_array(each)
            else each
            for each in part
        ),
    )


def symbols_like(part: Any, graph: Graph, numbers: str, addresses: str) -> Any:
    """
    Return nested tuples with symbols in place of their numbers and arrays.

    numbers, addresses: the names of the arrays in which the code finds what flatten returns.
    """
    return _symbols_like(part, graph, (numbers, addresses), [0, 0])


def _symbols_like(part, graph, names, counts):
    found = []
    for each in part:
        if isinstance(each, tuple):
            found.append(_symbols_like(each, graph, names, counts))
        elif isinstance(each, float):
            found.append(graph.input(names[0], counts[0]))
            counts[0] += 1
        elif _is_array(each):
            found.append(graph.array(names[1], counts[1], each.shape))
            counts[1] += 1
        else:
            found.append(each)
    return type(part)(*found) if hasattr(part, '_fields') else tuple(found)
