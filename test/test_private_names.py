"""What the package uses of other libraries' private names is listed, with the reason."""

import ast
import importlib
import inspect
import re
from pathlib import Path

PACKAGE = Path(__file__).parent.parent / 'satdyn_ros'
TREES = {path: ast.parse(path.read_text()) for path in sorted(PACKAGE.rglob('*.py'))}
# Public for all their underscore: those of NamedTuple, and os._exit.
PUBLIC = {'_fields', '_replace', '_asdict', '_make', '_exit'}


def is_private(name):
    return name.startswith('_') and not name.startswith('__')


def own_names():
    """Return the private names that the package itself defines."""
    for tree in TREES.values():
        for node in ast.walk(tree):
            if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
                yield node.name
            elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
                yield node.id
            elif isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store):
                yield node.attr


def used_names():
    """Return the private names of others that are read, and what is imported from numba.core."""
    own = {*own_names(), *PUBLIC}
    for tree in TREES.values():
        for node in ast.walk(tree):
            if isinstance(node, ast.Attribute) and is_private(node.attr) and node.attr not in own:
                yield node.attr
            elif isinstance(node, ast.keyword) and is_private(node.arg or '') and node.arg:
                yield node.arg
            elif isinstance(node, ast.ImportFrom) and (node.module or '').startswith('numba.core'):
                yield from (alias.name for alias in node.names)
            elif isinstance(node, ast.BinOp) and isinstance(node.right, ast.Constant):
                # A folder of a path that leads into another package.
                folder = node.right.value
                if isinstance(folder, str) and is_private(folder) and folder.isidentifier():
                    yield folder


def overridden_names():
    """Return the private methods of rclpy's classes that a class of the package overrides."""
    for path in sorted((PACKAGE / 'ros').glob('*.py')):
        try:
            module = importlib.import_module(f'satdyn_ros.ros.{path.stem}')
        except ModuleNotFoundError as error:
            if error.name != 'simulation_interfaces':
                raise
            continue
        for _, kind in inspect.getmembers(module, inspect.isclass):
            if kind.__module__ == module.__name__:
                others = [base for base in kind.__mro__ if base.__module__.startswith('rclpy')]
                for name, value in vars(kind).items():
                    if (
                        is_private(name)
                        and inspect.isfunction(value)
                        and any(name in vars(base) for base in others)
                    ):
                        yield name


def test_private_names_are_listed_with_their_reason():
    """A new version of numba or rclpy may drop them: the list says what to look at."""
    page = (PACKAGE.parent / 'docs' / 'design.md').read_text()
    table = page.split('## Private names')[1].split('\n## ')[0]
    listed = re.findall(r'`(\w+)`', ''.join(re.findall(r'^\| ([^|]*) \|', table, re.MULTILINE)))
    assert {*used_names(), *overridden_names()} == set(listed)
