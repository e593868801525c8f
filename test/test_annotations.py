"""Every public function has annotated arguments and results."""

import ast
import re
from pathlib import Path

PACKAGE = Path(__file__).parent.parent / 'satdyn_ros'


def public_functions(node, hidden=False):
    """Yield the functions and methods that are part of what others call."""
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef):
            special = child.name.startswith('__')
            if not hidden and (special or not child.name.startswith('_')):
                yield child
        elif isinstance(child, ast.ClassDef):
            yield from public_functions(child, hidden or child.name.startswith('_'))
        else:
            yield from public_functions(child, hidden)


def missing(function):
    """Return the parameters without a type, and 'return' where that has none."""
    given = function.args
    parameters = [*given.posonlyargs, *given.args, *given.kwonlyargs, given.vararg, given.kwarg]
    names = [p.arg for p in parameters if p and p.annotation is None]
    # __len__, __init__ and the like are known by their names
    annotated = function.returns is not None or function.name.startswith('__')
    return [n for n in names if n not in ('self', 'cls')] + ([] if annotated else ['return'])


def test_public_functions_are_annotated():
    """mypy, which checks what is annotated, checks all that others call."""
    found = {
        f'{path.relative_to(PACKAGE)}:{function.lineno} {function.name}': gaps
        for path in sorted(PACKAGE.rglob('*.py'))
        for function in public_functions(ast.parse(path.read_text(encoding='utf-8')))
        if (gaps := missing(function))
    }
    assert not found


def parameters_of(node):
    """Return the names that a docstring lists under Parameters, and those of the signature."""
    section = (ast.get_docstring(node) or '').partition('Parameters\n----------\n')[2]
    section = re.split(r'\n\n\w+\n-{3,}\n', section)[0]
    heads = [line.partition(' : ')[0] for line in section.splitlines() if line[:1].strip()]
    listed = [name.strip() for head in heads for name in head.split(',')]
    given = node
    if isinstance(node, ast.ClassDef):
        made = [x for x in node.body if isinstance(x, ast.FunctionDef) and x.name == '__init__']
        if not made:
            fields = [x for x in node.body if isinstance(x, ast.AnnAssign)]
            return listed, [ast.unparse(x.target) for x in fields]
        given = made[0]
    arguments = [*given.args.posonlyargs, *given.args.args, *given.args.kwonlyargs]
    if given.args.kwarg:
        arguments.append(given.args.kwarg)
    return listed, [x.arg for x in arguments if x.arg not in ('self', 'cls')]


def test_docstrings_list_the_parameters_that_there_are():
    """All of them in their order; a function of keywords alone may list these."""
    count = 0
    for path in PACKAGE.rglob('*.py'):
        for node in ast.walk(ast.parse(path.read_text(encoding='utf-8'))):
            if isinstance(node, ast.ClassDef | ast.FunctionDef):
                listed, given = parameters_of(node)
                count += bool(listed)
                assert not listed or listed == given or given == ['commands'], (
                    f'{path}: {node.name} has {given}, its docstring {listed}'
                )
    assert count > 100
