"""The rooms of the package import each other only as its architecture says."""

import ast
import graphlib
import re
import subprocess
import sys
from collections import Counter, defaultdict
from functools import cache
from pathlib import Path

import pytest

from satdyn_ros.actuators import ACTUATORS
from satdyn_ros.dynamics.mode_kinds import MODE_KINDS
from satdyn_ros.torques import ENVIRONMENT_TORQUES

PACKAGE = Path(__file__).parent.parent / 'satdyn_ros'

# From the ground up; __init__ is the front door.
ROOMS = [
    'base',
    'trace',
    'kernel',
    'environment',
    'orbits',
    'torques',
    'dynamics',
    'integrate',
    'theory',
    'exact',
    'sensors',
    'actuators',
    'exchange',
    'guidance',
    'run',
    'rosbag2',
    'messages',
    'bag',
    'ros',
    'report',
    'watch',
    'sweep',
    'gym',
    'cli',
]


def test_the_design_lists_the_rooms_and_what_they_import():
    """The table draws the imports, and what a room imports is above it in the table."""
    design = (PACKAGE.parent / 'docs' / 'design.md').read_text()
    table = design.split('## Rooms')[1].split('\n## ')[0]
    rows = re.findall(r'^\| `(\w+)` \| [^|]+ \|([^|]*)\|$', table, re.MULTILINE)
    drawn = {room: re.findall(r'`(\w+)`', imported) for room, imported in rows}
    imports: dict[str, set[str]] = {room: set() for room in ROOMS}
    for path in PACKAGE.rglob('*/*.py'):
        room = path.relative_to(PACKAGE).parts[0]
        imports[room] |= {room_of(name) for name in own_imports(path) if '.' in name} - {room}
    assert list(drawn) == ROOMS
    assert drawn == {
        room: sorted(names & {*ROOMS}, key=ROOMS.index) for room, names in imports.items()
    }


def test_no_other_room_names_an_actuator():
    """What is commanded goes over the list of the kinds; docstrings apart, and applied torques."""
    names = {*ACTUATORS, *(word for kind in ACTUATORS.values() for word in kind.words)}
    names -= {'torque', 'rotor_torque', 'rotor_speed'}
    assert len(names) >= 3
    found = []
    for path in PACKAGE.rglob('*.py'):
        documented = (ast.Module, ast.ClassDef, ast.FunctionDef)
        texts = {
            id(node.body[0].value)
            for node in nodes_of(path)
            if isinstance(node, documented) and node.body and isinstance(node.body[0], ast.Expr)
        }
        for node in nodes_of(path):
            text = getattr(node, 'value', None) if id(node) not in texts else None
            if isinstance(text, str) and any(name in text for name in names):
                found.append(path.relative_to(PACKAGE))
        # The table of what it consists of has its modules.
        imports = {name for name in own_imports(path) if name.startswith('satdyn_ros.actuators.')}
        if imports - {'satdyn_ros.actuators'} and path.parent.name != 'actuators':
            found.append(path.relative_to(PACKAGE))
    # Its tasks are scenarios, which are data.
    allowed = {Path('gym/tasks.py')}
    assert [path for path in found if path.parts[0] != 'actuators' and path not in allowed] == []


def test_no_other_room_names_a_torque_of_the_environment():
    """What flies, is checked and is shown goes over the list of the kinds."""
    names = {kind.__name__ for kind in ENVIRONMENT_TORQUES}
    assert len(names) >= 4
    keys = {key.name for kind in ENVIRONMENT_TORQUES for key in kind.keys}
    keys |= {f'{key.partition(".")[0]}.' for key in keys if key.endswith('.names')}
    found = set()
    for path in PACKAGE.rglob('*.py'):
        imported = [node for node in nodes_of(path) if isinstance(node, ast.ImportFrom)]
        if names & {alias.name for node in imported for alias in node.names}:
            found.add(path.relative_to(PACKAGE))
        texts = [node.value for node in nodes_of(path) if isinstance(node, ast.Constant)]
        if any(str(text).startswith(tuple(keys)) for text in texts):
            found.add(path.relative_to(PACKAGE))
    # What commands its dipole, what draws its rods, and scenarios, which are data.
    of_kinds = 'actuators/magnetorquers.py', 'report/hysteresis_loops.py', 'gym/tasks.py'
    allowed = {Path(name) for name in of_kinds}
    assert {path for path in found if path.parts[0] != 'torques'} == allowed


def test_no_module_names_a_kind_of_modes():
    """Equations, integrals, keys and topics go over what the modes are made of."""
    files = {kind.__module__ for kind in MODE_KINDS}
    assert 'satdyn_ros.dynamics.flexible' in files
    importing = [path for path in PACKAGE.rglob('*.py') if files & {*own_imports(path)}]
    assert importing == []


def test_an_orbit_is_asked_and_not_known_by_its_type():
    """What an orbit is it answers itself, and so does each value of orbit.type."""
    classes = {
        node.name
        for file, node in tops(ast.ClassDef)
        if Path(file).parts[0] == 'orbits' and node.name[0] != '_'
    }
    assert {'KeplerOrbit', 'TabledOrbit', 'TwoLineOrbit', 'Circular'} <= classes
    found = []
    for path in sorted(PACKAGE.rglob('*.py')):
        for node in nodes_of(path):
            match node:
                case ast.Call(func=ast.Name(id='isinstance' | 'issubclass'), args=[_, kinds]):
                    asked = {each.id for each in ast.walk(kinds) if isinstance(each, ast.Name)}
                case ast.MatchClass(cls=ast.Name(id=name)):
                    asked = {name}
                case ast.Compare():
                    inside = [*ast.walk(node)]
                    asked = {each.id for each in inside if isinstance(each, ast.Name)}
                    if any(getattr(each, 'value', None) == 'orbit.type' for each in inside):
                        found.append((path.relative_to(PACKAGE), node.lineno))
                case _:
                    continue
            if asked & classes and path.parent.name != 'orbits':
                found.append((path.relative_to(PACKAGE), node.lineno))
    assert found == []


def room_of(module):
    """Return the room of the dotted name 'satdyn_ros.room.file'."""
    return module.split('.')[1]


@cache
def nodes_of(path):
    """Return a file's syntax, the module first and then what is in it."""
    return [*ast.walk(ast.parse(path.read_text()))]


@cache
def own_imports(path):
    """Return the dotted names of the package's own modules that a file imports."""
    return [*_own_imports(path)]


def _own_imports(path):
    here = ['satdyn_ros', *path.relative_to(PACKAGE).with_suffix('').parts]
    for node in nodes_of(path):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names if alias.name.startswith('satdyn_ros.'))
        elif isinstance(node, ast.ImportFrom):
            base = here[: -node.level] if node.level else []
            module = '.'.join([*base, *([node.module] if node.module else [])])
            if not f'{module}.'.startswith('satdyn_ros.'):
                continue
            for alias in node.names:
                name = f'{module}.{alias.name}'
                found = PACKAGE.parent / name.replace('.', '/')
                if found.is_dir() or found.with_suffix('.py').is_file():
                    yield name
                elif module != 'satdyn_ros':
                    yield module


def test_a_room_imports_only_from_rooms_below():
    """What is lower can be read, tested and used without what is above it."""
    for path in sorted(PACKAGE.rglob('*.py')):
        room = path.relative_to(PACKAGE).with_suffix('').parts[0]
        if room == '__init__':
            continue
        allowed = ROOMS[: ROOMS.index(room) + 1]
        upward = [name for name in own_imports(path) if room_of(name) not in allowed]
        assert upward == [], path.relative_to(PACKAGE)


def test_no_module_imports_itself_by_way_of_others():
    """Not even within a function: what two modules need is in a third one below both."""
    graph = {}
    for path in sorted(PACKAGE.rglob('*/[a-z]*.py')):
        name = '.'.join(['satdyn_ros', *path.relative_to(PACKAGE).with_suffix('').parts])
        graph[name] = {*own_imports(path)}
    graphlib.TopologicalSorter(graph).prepare()


@pytest.mark.parametrize(
    ('library', 'rooms'), [('numba', {'kernel'}), ('llvmlite', {'trace', 'kernel'})]
)
def test_only_two_rooms_import_the_compiler(library, rooms):
    """What depends on LLVM is in two rooms, what depends on numba in one of them."""
    importing = {
        path.relative_to(PACKAGE).parts[0]
        for path in PACKAGE.rglob('*.py')
        if re.search(rf'^\s*(from|import) {library}\b', path.read_text(), re.MULTILINE)
    }
    assert importing == rooms


def test_no_two_modules_share_a_name():
    """A name in a traceback, a table or a talk is one file."""
    files = Counter(path.stem for path in PACKAGE.rglob('*/[a-z]*.py'))
    assert [name for name, count in files.items() if count > 1] == []


def test_every_module_has_a_room():
    """A new file or folder at the top of the package must stand in the order."""
    tops = {path.relative_to(PACKAGE).with_suffix('').parts[0] for path in PACKAGE.rglob('*.py')}
    assert tops - {'__init__'} <= set(ROOMS)


def test_physics_loads_no_ros():
    """The physics runs where ROS is not installed and knows no file format."""
    modules = [
        '.'.join(['satdyn_ros', *path.relative_to(PACKAGE).with_suffix('').parts])
        for room in ('dynamics', 'exact')
        for path in sorted((PACKAGE / room).glob('[a-z]*.py'))
    ]
    program = (
        f'import sys, satdyn_ros, {", ".join(modules)}\n'
        "print({'rclpy', 'mcap', 'geometry_msgs'} & set(sys.modules) or 'none')"
    )
    result = subprocess.run([sys.executable, '-c', program], capture_output=True, text=True)
    assert (result.returncode, result.stdout.strip()) == (0, 'none'), result.stderr


def tops(*kinds):
    """Yield the file and the node of each function, class or constant at the top of a file."""
    for path in sorted(PACKAGE.rglob('*.py')):
        for node in nodes_of(path)[0].body:
            if isinstance(node, kinds):
                yield str(path.relative_to(PACKAGE)), node


def test_classes_and_constants_have_names_of_their_own():
    """A reader who meets a name knows which thing it is."""
    files = defaultdict(list)
    for file, node in tops(ast.ClassDef, ast.Assign, ast.AnnAssign):
        targets = getattr(node, 'targets', [getattr(node, 'target', node)])
        for name in (getattr(target, 'id', getattr(target, 'name', '_')) for target in targets):
            if not name.startswith('_'):
                files[name].append(file)
    assert {name: where for name, where in files.items() if len(where) > 1} == {}


def test_nothing_is_written_twice():
    """A function that two files need is in one of them, or in a room below both."""
    files = defaultdict(list)
    for file, node in tops(ast.FunctionDef):
        body = [ast.dump(statement) for statement in node.body if not is_docstring(statement)]
        meaning = ast.dump(node.args), *body
        files[meaning].append(f'{file} {node.name}')
    assert [found for found in files.values() if len(found) > 1] == []


def is_docstring(statement):
    return isinstance(statement, ast.Expr) and isinstance(statement.value, ast.Constant)


def test_the_format_of_bags_knows_nothing_of_satellites():
    """What reads and writes bags could be a package of its own."""
    found = set()
    for path in (PACKAGE / 'rosbag2').glob('*.py'):
        found |= {room_of(name) for name in own_imports(path) if '.' in name}
    assert found - {'__version__'} == {'base', 'trace', 'kernel', 'rosbag2'}


def test_what_moves_knows_no_torque_by_its_name():
    """A system has torques; which there are is known to those that make one."""
    imported = own_imports(PACKAGE / 'dynamics' / 'system.py')
    torques = {name for name in imported if name.startswith('satdyn_ros.torques.')}
    of_all = 'body_torque', 'corner_search'
    assert torques == {f'satdyn_ros.torques.{name}' for name in of_all}


def test_a_function_has_at_most_sixty_lines():
    """With its docstring: a reader sees all of it at once."""
    found = {}
    for path in sorted(PACKAGE.rglob('*.py')):
        for node in nodes_of(path):
            if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
                lines = (node.end_lineno or 0) - node.lineno + 1
                if lines > 60:
                    found[f'{path.relative_to(PACKAGE)} {node.name}'] = lines
    assert found == {}
