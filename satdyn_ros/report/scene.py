"""
The scene as data: what moves, once, and how it moves, row by row.

The report holds one description and one table; the live page gets a description when it begins and
after each change, then a table with every frame.  scene.js draws both.

A description is plain data:

    body        what flies, its widest side 1: edges (3,) and centre (3,) of body.box, q_bp (4,)
                from its axes to body axes, and plates, a list of normal (3,), position (3,) and
                edge of the square; without either the homogeneous box with these moments;
                has_box: false where there are plates alone, around all of which the box is
    nozzles     of each thruster name, position (3,), direction (3,) of the force and thrust [N]
    cones       a list of name, axis (3,) in body axes and half_angle [rad] of sensors
    axis        the unit vector, body axes, whose path is drawn: of symmetry, or the third axis
    least_axis  that of least inertia, whose angle to nadir is drawn; null: none, or no LVLH
    rotors      a list of name, axis (3,) in body axes, mode and momentum [N m s]
    planet      its radius [m], or null where it is unknown; then radius_m is not used
    has_lvlh    whether there is an orbit, with q_il and radius_m in the table
    integrals   the names of the columns of drift
    earth       if the position is published what draws the Earth, see earth_map.py, or null
    panels      the name, title and unit of each column that has a panel of its own, such as a
                torque's, and lines, the names of its numbers: x, y, z in body axes, or one ''

A table has N rows: {'rows': N, 'columns': {name: {'width': k, 'float32': base64}}}, the numbers
row by row, little endian, t_s as float64.  Its columns, of which some may be missing:

    t_s                    seconds from tick 0
    q_ib, q_il             attitude of the body and of LVLH to inertial axes, x, y, z, w
    radius_m               distance from the centre of the planet [m]
    omega_bi_b             body rate, body axes [rad/s]
    momentum_b             angular momentum, body axes [N m s]
    gravity_gradient       and the other panels, by their names
    applied_b              applied torque, body axes [N m]
    dipole_b               magnetic dipole of body and magnetorquers, body axes [A m^2]
    geodetic               latitude, longitude [deg] and height [m]
    rotor_speed            relative to the body, one number per rotor [rad/s]
    rotor_angle            within a turn [rad]
    propellant             used by each thruster since tick 0 [kg], nan where unknown
    drift                  largest relative drift since the last event, one number per integral
"""

from base64 import b64encode
from collections.abc import Mapping
from typing import Any

import numpy as np

from ..dynamics.inertia import principal_axes
from ..dynamics.motion import States
from ..kernel import rotation
from ..messages.markers import box
from ..orbits.kepler import EARTH_RADIUS_M
from ..run.scenario import Scenario
from ..torques.thrust import thrust_of
from . import earth_map
from .curves import least_axis, line_names, rotor_columns, topics_with_panels
from .history import History

_TURN = 2.0 * np.pi


def description(scenario: Scenario, integrals: list[str]) -> dict[str, Any]:
    """Return what the scene of a scenario shows, see above."""
    orbit, least = scenario.system.orbit, least_axis(scenario.system.inertia)
    body, width_m = _body(scenario)
    return {
        'body': body,
        'nozzles': _nozzles(scenario, width_m),
        'cones': _cones(scenario),
        'axis': _followed_axis(scenario.system.inertia).tolist(),
        'least_axis': least.tolist() if least is not None and orbit.has_lvlh else None,
        'rotors': _rotors(scenario),
        'planet': EARTH_RADIUS_M if earth_map.is_about_earth(orbit) else None,
        'has_lvlh': orbit.has_lvlh,
        'integrals': integrals,
        'earth': earth_map.description(scenario),
        'panels': [
            {
                'name': topic.name,
                'title': topic.panel.title,
                'unit': topic.panel.unit or '1',
                'lines': line_names(topic.panel, len(topic.shows[0].columns)),
            }
            for topic in topics_with_panels(scenario)
            if topic.panel
        ],
    }


def rows(
    states: States,
    momentum_b: np.ndarray,
    shown: Mapping[str, np.ndarray],
    applied_b: np.ndarray | None = None,
    dipole_b: np.ndarray | None = None,
) -> dict[str, np.ndarray]:
    """Return the columns of states, (N, k) each; those without information are missing."""
    columns = {
        't_s': states.orbit_s,
        'q_ib': states.q_ib,
        'omega_bi_b': states.omega_bi_b,
        'momentum_b': momentum_b,
        **shown,
    }
    if states.orbit.has_lvlh:
        columns['q_il'] = states.orbit.lvlh(states.orbit_s)
        columns['radius_m'] = states.orbit.radius(states.orbit_s)
    if applied_b is not None and np.any(applied_b):
        columns['applied_b'] = applied_b
    if dipole_b is not None:
        columns['dipole_b'] = dipole_b
    speed = rotor_columns(states.rotor_speed)
    if not np.all(np.isnan(speed)):
        columns['rotor_speed'] = speed
        columns['rotor_angle'] = rotor_columns(states.rotor_angle) % _TURN
    return columns


def table(columns: Mapping[str, np.ndarray]) -> dict[str, Any]:
    """Return columns of N numbers or (N, k) as a table, plain data for JSON."""
    return {
        'rows': len(next(iter(columns.values()))),
        'columns': {name: _column(name, values) for name, values in columns.items()},
    }


def of_history(run: History) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return the description and the table of a history."""
    columns = rows(run.states, run.momentum_b, run.shown, run.applied_b, run.dipole_b)
    if run.propellant is not None:
        columns['propellant'] = run.propellant
    if run.drift:
        columns['drift'] = np.stack(list(run.drift.values()), axis=-1)
    return description(run.scenario, list(run.drift)), table(columns)


def _column(name, values):
    kind, code = ('float64', '<f8') if name == 't_s' else ('float32', '<f4')
    data = np.ascontiguousarray(values, code)
    width = 1 if data.ndim == 1 else data.shape[1]
    return {'width': width, kind: b64encode(data.tobytes()).decode('ascii')}


def rotor_names(scenario: Scenario) -> list[str]:
    """Return the names of the rotors."""
    return [rotor.label for rotor in scenario.system.rotors]


def _rotors(scenario):
    if all(rotor.mode == 'none' for rotor in scenario.system.rotors):
        return []
    return [
        {
            'name': rotor.label,
            'axis': rotor.axis.tolist(),
            'mode': rotor.mode,
            'momentum': rotor.momentum,
        }
        for rotor in scenario.system.rotors
    ]


def _body(scenario):
    """Return the shape of the body, all lengths in that of its widest side, and this [m] or 0."""
    edges, q_bp = box(scenario.system.inertia)
    centre, plates = np.zeros(3), _plates(scenario)
    has_box = any(scenario['body.box']) or not plates
    if any(scenario['body.box']):
        edges, centre = np.array(scenario['body.box']), np.array(scenario['body.box_centre'])
    if any(scenario['body.box']) or plates:
        q_bp = rotation.IDENTITY
    ends = [centre - edges / 2.0, centre + edges / 2.0] if has_box else []
    for normal, position, edge in plates:
        # As wide as the circle around it: how it is turned about its normal is not said.
        half = edge * np.sqrt(np.maximum(1.0 - normal**2, 0.0) / 2.0)
        ends += [position - half, position + half]
    low, high = np.min(ends, axis=0), np.max(ends, axis=0)
    widest = float(np.max(high - low))
    if not has_box:
        edges, centre = high - low, (low + high) / 2.0
    is_known = any(scenario['body.box']) or plates
    body = {
        'edges': (edges / widest).tolist(),
        'centre': (centre / widest).tolist(),
        'q_bp': q_bp.tolist(),
        'has_box': has_box,
        'plates': [
            {
                'normal': normal.tolist(),
                'position': (position / widest).tolist(),
                'edge': edge / widest,
            }
            for normal, position, edge in plates
        ],
    }
    return body, widest if is_known else 0.0


def _nozzles(scenario, width_m):
    """Return where thrusters act, in widths of the body; where that is unknown, on its sides."""
    if not (names := scenario['thruster.names']):
        return []
    thrust = thrust_of(scenario.system)
    positions = np.array([each.position for each in thrust.thrusters.values()])
    width_m = width_m or 2.0 * np.abs(positions).max() or 1.0
    return [
        {
            'name': name,
            'position': (np.array(each.position) / width_m).tolist(),
            'direction': list(each.direction),
            'thrust': each.thrust,
        }
        for name, each in zip(names, thrust.thrusters.values(), strict=True)
    ]


def _plates(scenario):
    """Return of each plate its unit normal (3,), its position (3,) [m] and its edge [m]."""
    found = []
    for name in scenario['surface.names']:
        normal, position, area = (
            scenario[f'surface.{name}.{key}'] for key in ('normal', 'position', 'area')
        )
        unit = np.array(normal) / np.linalg.norm(normal)
        found.append((unit, np.array(position), float(np.sqrt(area))))
    return found


def _cones(scenario):
    return [
        {
            'name': name,
            'axis': rotation.rotate(sensor.mounting, [0.0, 0.0, 1.0]).tolist(),
            'half_angle': sensor.cone,
        }
        for name, sensor in scenario.sensors.items()
        if sensor.cone
    ]


def _followed_axis(tensor):
    """Return the axis of symmetry (3,), or the third principal axis, in body axes."""
    moments, R_bp = principal_axes(tensor)
    alike = np.abs([moments[k - 1] - moments[k - 2] for k in range(3)]) <= 1e-9 * moments.max()
    return R_bp[:, int(np.argmax(alike)) if alike.sum() == 1 else 2]
