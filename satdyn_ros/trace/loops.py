"""
Code of functions with loops, by their syntax trees: what graphs, which have none, cannot say.

The functions are plain Python of floats, integers, truths, arrays by their addresses, and tuples
of these, with if, while, for over range, and calls of one another, which are inlined.  A variable
has the kind that it is given first; an integer that is given to a float becomes one.
"""

import ast
import builtins
import inspect
import math
import textwrap
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from llvmlite import ir

from .memory import call, floats, integers, octets

_FLOAT, _INTEGER, _TRUTH = ir.DoubleType(), ir.IntType(64), ir.IntType(1)
_OF = {float: _FLOAT, int: _INTEGER, bool: _TRUTH}
_COMPARISONS = {
    ast.Lt: '<',
    ast.LtE: '<=',
    ast.Gt: '>',
    ast.GtE: '>=',
    ast.Eq: '==',
    ast.NotEq: '!=',
}
# Of floats and of integers.
_OPERATIONS = {
    ast.Add: ('fadd', 'add'),
    ast.Sub: ('fsub', 'sub'),
    ast.Mult: ('fmul', 'mul'),
    ast.Div: ('fdiv', ''),
    # Of numbers that are not negative.
    ast.FloorDiv: ('', 'sdiv'),
    ast.Mod: ('', 'srem'),
}


class Value(NamedTuple):
    """A value that is known when the code runs: float, int or bool; or one of _ARRAYS."""

    kind: Any
    ir: Any


# What is in the arrays at an address.
_ARRAYS: dict[Any, tuple[Any, Any]] = {
    floats: (float, _FLOAT),
    integers: (int, _INTEGER),
    octets: (int, ir.IntType(8)),
}


def text_of(name: str, function: Callable[..., Any]) -> str:
    """Return the IR of a function of integers that returns one, or a truth."""
    count = len(inspect.signature(function).parameters)
    module = ir.Module()
    outer = ir.Function(module, ir.FunctionType(_INTEGER, [_INTEGER] * count), name)
    builder = ir.IRBuilder(outer.append_basic_block())
    given = [Value(int, argument) for argument in outer.args]
    found = _Body(builder, function).of(given)
    builder.ret(found.ir if found.kind is int else builder.zext(found.ir, _INTEGER))
    return str(module)


@cache
def _tree(function: Callable[..., Any]) -> ast.FunctionDef:
    (tree,) = ast.parse(textwrap.dedent(inspect.getsource(function))).body
    assert isinstance(tree, ast.FunctionDef)
    return tree


@dataclass
class _Loop:
    """Where break and continue go."""

    end: Any
    following: Any


@dataclass
class _Body:
    """The body of one call of a function, while it is written."""

    builder: ir.IRBuilder
    function: Any
    _variables: dict[str, Any] = field(default_factory=dict)
    _loops: list[_Loop] = field(default_factory=list)
    _result: Any = None

    def of(self, given: Sequence[Any]) -> Any:
        """Write it for arguments; return what it returns, None: nothing."""
        tree = _tree(self.function)
        for parameter, value in zip(tree.args.args, given, strict=True):
            self._variables[parameter.arg] = self._room(value)
            self._store(self._variables[parameter.arg], value)
        self._end = self.builder.append_basic_block()
        self._do(tree.body)
        self._go(self._end)
        self.builder.position_at_end(self._end)
        return None if self._result is None else self._load(self._result)

    # -- variables ----------------------------------------------------------------------------

    def _room(self, value):
        """Return room for values of the kind of this one."""
        if isinstance(value, tuple) and not isinstance(value, Value):
            return tuple(map(self._room, value))
        with self.builder.goto_entry_block():
            return Value(value.kind, self.builder.alloca(_OF.get(value.kind, _INTEGER)))

    def _store(self, room, value):
        if not isinstance(room, Value):
            for each, part in zip(room, value, strict=True):
                self._store(each, part)
            return
        self.builder.store(self._as(room.kind, value).ir, room.ir)

    def _load(self, room):
        if not isinstance(room, Value):
            return tuple(map(self._load, room))
        return Value(room.kind, self.builder.load(room.ir))

    def _as(self, kind, value):
        """Return a value as one of a kind."""
        if value.kind is kind:
            return value
        if kind is float and value.kind is int:
            return Value(float, self.builder.sitofp(value.ir, _FLOAT))
        if kind is float and value.kind is bool:
            return Value(float, self.builder.uitofp(value.ir, _FLOAT))
        if kind is int and value.kind is bool:
            return Value(int, self.builder.zext(value.ir, _INTEGER))
        raise TypeError(f'{self.function.__name__} has {value.kind} in place of {kind}')

    # -- statements ---------------------------------------------------------------------------

    def _do(self, statements):
        for statement in statements:
            if self.builder.block.is_terminated:
                return
            getattr(self, f'_{type(statement).__name__}')(statement)

    def _go(self, block):
        if not self.builder.block.is_terminated:
            self.builder.branch(block)

    def _Expr(self, node):
        if not isinstance(node.value, ast.Constant):
            self._value(node.value)

    def _Assign(self, node):
        value = self._value(node.value)
        for target in node.targets:
            self._assign(target, value)

    def _AugAssign(self, node):
        now, change = self._value(node.target), self._value(node.value)
        self._assign(node.target, self._operation(node.op, now, change))

    def _assign(self, target, value):
        match target:
            case ast.Name():
                if target.id not in self._variables:
                    self._variables[target.id] = self._room(value)
                self._store(self._variables[target.id], value)
            case ast.Tuple():
                for each, part in zip(target.elts, value, strict=True):
                    self._assign(each, part)
            case ast.Subscript():
                array = self._value(target.value)
                element = self._element(array, self._value(target.slice))
                self.builder.store(self._as(_ARRAYS[array.kind][0], value).ir, element)

    def _Return(self, node):
        if node.value is not None:
            value = self._value(node.value)
            if self._result is None:
                self._result = self._room(value)
            self._store(self._result, value)
        self._go(self._end)

    def _If(self, node):
        then, otherwise, end = (self.builder.append_basic_block() for _ in range(3))
        self.builder.cbranch(self._truth(self._value(node.test)), then, otherwise)
        for block, statements in ((then, node.body), (otherwise, node.orelse)):
            self.builder.position_at_end(block)
            self._do(statements)
            self._go(end)
        self.builder.position_at_end(end)

    def _While(self, node):
        with self._loop(lambda: self._truth(self._value(node.test))):
            self._do(node.body)

    def _For(self, node):
        bounds = [self._value(each) for each in node.iter.args]
        begin = bounds[0] if len(bounds) > 1 else self._constant(0)
        counter, last = self._room(begin), self._as(int, bounds[-1])
        self._store(counter, begin)

        def is_within():
            return self.builder.icmp_signed('<', self._load(counter).ir, last.ir)

        def go_on():
            following = self.builder.add(self._load(counter).ir, _INTEGER(1))
            self.builder.store(following, counter.ir)

        with self._loop(is_within, go_on):
            self._assign(node.target, self._load(counter))
            self._do(node.body)

    @contextmanager
    def _loop(self, is_within: Callable, go_on: Callable = lambda: None) -> Iterator[None]:
        test, body, following, end = (self.builder.append_basic_block() for _ in range(4))
        self._go(test)
        self.builder.position_at_end(test)
        self.builder.cbranch(is_within(), body, end)
        self.builder.position_at_end(body)
        self._loops.append(_Loop(end, following))
        yield
        self._loops.pop()
        self._go(following)
        self.builder.position_at_end(following)
        go_on()
        self._go(test)
        self.builder.position_at_end(end)

    def _Break(self, node):
        self._go(self._loops[-1].end)

    def _Continue(self, node):
        self._go(self._loops[-1].following)

    # -- expressions --------------------------------------------------------------------------

    def _value(self, node):
        return getattr(self, f'_{type(node).__name__}')(node)

    def _constant(self, number):
        return Value(type(number), _OF[type(number)](number))

    def _Constant(self, node):
        return self._constant(node.value)

    def _Name(self, node):
        if node.id in self._variables:
            return self._load(self._variables[node.id])
        return self._constant(self._object(node))

    def _Attribute(self, node):
        return self._constant(self._object(node))

    def _object(self, node):
        """Return what a name is that no variable has."""
        if isinstance(node, ast.Attribute):
            return getattr(self._object(node.value), node.attr)
        known = self.function.__globals__
        return known[node.id] if node.id in known else getattr(builtins, node.id)

    def _Tuple(self, node):
        return tuple(map(self._value, node.elts))

    def _Subscript(self, node):
        whole = self._value(node.value)
        if not isinstance(whole, Value):
            return whole[node.slice.value]
        found = self.builder.load(self._element(whole, self._value(node.slice)))
        if whole.kind is octets:
            found = self.builder.zext(found, _INTEGER)
        return Value(_ARRAYS[whole.kind][0], found)

    def _element(self, array, i):
        begin = self.builder.inttoptr(array.ir, _ARRAYS[array.kind][1].as_pointer())
        return self.builder.gep(begin, [self._as(int, i).ir])

    def _BinOp(self, node):
        return self._operation(node.op, self._value(node.left), self._value(node.right))

    def _operation(self, operator, left, right):
        kind = float if float in (left.kind, right.kind) or isinstance(operator, ast.Div) else int
        name = _OPERATIONS[type(operator)][kind is int]
        values = (self._as(kind, each).ir for each in (left, right))
        return Value(kind, getattr(self.builder, name)(*values))

    def _UnaryOp(self, node):
        value = self._value(node.operand)
        if isinstance(node.op, ast.Not):
            return Value(bool, self.builder.not_(self._truth(value)))
        if value.kind is float:
            return Value(float, self.builder.fneg(value.ir))
        return Value(int, self.builder.neg(value.ir))

    def _truth(self, value):
        if value.kind is bool:
            return value.ir
        return self.builder.icmp_signed('!=', value.ir, _INTEGER(0))

    def _BoolOp(self, node):
        result = self._room(self._constant(False))
        is_all = isinstance(node.op, ast.And)

        def write(values):
            value = Value(bool, self._truth(self._value(values[0])))
            self._store(result, value)
            if len(values) > 1:
                more, end = (self.builder.append_basic_block() for _ in range(2))
                self.builder.cbranch(value.ir, *((more, end) if is_all else (end, more)))
                self.builder.position_at_end(more)
                write(values[1:])
                self._go(end)
                self.builder.position_at_end(end)

        write(node.values)
        return self._load(result)

    def _Compare(self, node):
        left, found = self._value(node.left), []
        for operator, right_node in zip(node.ops, node.comparators, strict=True):
            if isinstance(operator, ast.In):
                equal = (self._compared('==', left, each) for each in self._value(right_node))
                found.append(self._any(equal))
                continue
            right = self._value(right_node)
            found.append(self._compared(_COMPARISONS[type(operator)], left, right))
            left = right
        truth = found[0]
        for each in found[1:]:
            truth = self.builder.and_(truth, each)
        return Value(bool, truth)

    def _any(self, truths):
        first, *others = truths
        for each in others:
            first = self.builder.or_(first, each)
        return first

    def _compared(self, sign, left, right):
        if float in (left.kind, right.kind):
            values = [self._as(float, each).ir for each in (left, right)]
            if sign == '!=':
                return self.builder.fcmp_unordered(sign, *values)
            return self.builder.fcmp_ordered(sign, *values)
        values = [self._as(int, each).ir for each in (left, right)]
        return self.builder.icmp_signed(sign, *values)

    def _IfExp(self, node):
        # The kind of both is known when both are written.
        found, blocks = [], []
        then_block, else_block, end = (self.builder.append_basic_block() for _ in range(3))
        self.builder.cbranch(self._truth(self._value(node.test)), then_block, else_block)
        for block, each in ((then_block, node.body), (else_block, node.orelse)):
            self.builder.position_at_end(block)
            found.append(self._value(each))
            blocks.append(self.builder.block)
        kind = float if any(value.kind is float for value in found) else found[0].kind
        result = self._room(Value(kind, None))
        for block, value in zip(blocks, found, strict=True):
            self.builder.position_at_end(block)
            self._store(result, value)
            self.builder.branch(end)
        self.builder.position_at_end(end)
        return self._load(result)

    def _Call(self, node):
        function = self._object(node.func)
        given = [self._value(each) for each in node.args]
        if function in _ARRAYS:
            return Value(function, given[0].ir)
        if function is call:
            kind = ir.FunctionType(ir.VoidType(), [_INTEGER]).as_pointer()
            self.builder.call(self.builder.inttoptr(given[0].ir, kind), [given[1].ir])
            return None
        if function is int:
            return Value(int, self.builder.fptosi(given[0].ir, _INTEGER))
        if function in (min, max):
            first, second = given
            kind = float if float in (first.kind, second.kind) else int
            first, second = self._as(kind, first), self._as(kind, second)
            # As Python: the first, unless the second is beyond it.
            is_second = self._compared('<' if function is min else '>', second, first)
            return Value(kind, self.builder.select(is_second, second.ir, first.ir))
        if function is np.sign:
            (x,) = given
            up, down = (self._compared(sign, x, self._constant(0.0)) for sign in '><')
            values = (self.builder.uitofp(each, _FLOAT) for each in (up, down))
            return Value(float, self.builder.fsub(*values))
        if function in _LIBRARY:
            numbers = [self._as(float, each).ir for each in given]
            kind = ir.FunctionType(_FLOAT, [_FLOAT] * len(numbers))
            known, name = self.builder.module.globals, _LIBRARY[function]
            declared = known.get(name) or ir.Function(self.builder.module, kind, name)
            return Value(float, self.builder.call(declared, numbers))
        return _Body(self.builder, function).of(given)


# By their names as the C library or LLVM knows them.
_LIBRARY = {
    **dict.fromkeys((np.sqrt, math.sqrt), 'llvm.sqrt.f64'),
    **dict.fromkeys((np.sin, math.sin), 'sin'),
    **dict.fromkeys((np.cos, math.cos), 'cos'),
    np.arctan2: 'atan2',
    np.rint: 'llvm.rint.f64',
    abs: 'llvm.fabs.f64',
}
