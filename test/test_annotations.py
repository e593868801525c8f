"""Every public function has annotated arguments and results."""

import ast
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
    told = function.returns is not None or function.name.startswith('__')
    return [n for n in names if n not in ('self', 'cls')] + ([] if told else ['return'])


def test_public_functions_are_annotated():
    """mypy, which checks what is annotated, checks all that others call."""
    found = {
        f'{path.relative_to(PACKAGE)}:{function.lineno} {function.name}': gaps
        for path in sorted(PACKAGE.rglob('*.py'))
        for function in public_functions(ast.parse(path.read_text(encoding='utf-8')))
        if (gaps := missing(function))
    }
    assert not found
