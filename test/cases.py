"""The reference cases: systems, starts and states to 30 digits that this code did not compute."""

import json
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from satdyn_ros.dynamics.rotor import Rotor
from satdyn_ros.dynamics.system import State, System
from satdyn_ros.orbits import FixedDirection, KeplerOrbit

REFERENCE = Path(__file__).parent / 'reference'


@dataclass(frozen=True)
class Case:
    """One reference case; a bound that it does not have is nan. raw: the JSON entry."""

    name: str
    described: System | None
    start: State
    t_s: np.ndarray
    q_ib: np.ndarray
    omega_bi_b: np.ndarray
    bound_numeric: float
    bound_exact: float
    raw: dict[str, Any]

    @property
    def system(self) -> System:
        """The system; AssertionError where none can describe the case."""
        assert self.described is not None, f'no system describes {self.name}'
        return self.described


@cache
def newtonian() -> dict[str, Case]:
    """Return the cases of the Newtonian-field papers by name."""
    return {raw['name']: _newtonian(raw) for raw in _load('newtonian.json')['cases']}


@cache
def rigid() -> dict[str, Case]:
    """Return the cases of Paladini and the textbook by name."""
    return {raw['name']: _rigid(raw) for raw in _load('rigid.json')['cases']}


def bounded(cases: dict[str, Case], bound: str) -> list[str]:
    """Return the names of the cases that have bound, 'bound_numeric' or 'bound_exact'."""
    return [name for name, case in cases.items() if not np.isnan(getattr(case, bound))]


def _load(file):
    return json.loads((REFERENCE / file).read_text())


def _floats(values):
    return np.array([float(value) for value in values])


def _bound(value):
    return np.nan if value is None else value


def _rotor(h):
    momentum = np.linalg.norm(h)
    if momentum == 0.0:
        return Rotor()
    return Rotor('constant_momentum', axis=h / momentum, momentum=float(momentum))


def _case(raw, system, q_0, omega_0):
    states = raw['states']
    return Case(
        name=raw['name'],
        described=system,
        start=State(_floats(q_0) / np.linalg.norm(_floats(q_0)), _floats(omega_0)),
        t_s=_floats([state['t'] for state in states]),
        q_ib=np.array([_floats(state['q_xyzw']) for state in states]),
        omega_bi_b=np.array([_floats(state['omega']) for state in states]),
        bound_numeric=_bound(raw.get('bound_numeric')),
        bound_exact=_bound(raw.get('bound_exact')),
        raw=raw,
    )


def _newtonian(raw):
    field, weight_moment = raw['field'], np.zeros(3)
    orbit: FixedDirection | KeplerOrbit
    if field['type'] == 'fixed':
        orbit = FixedDirection(float(field['k']))
        weight_moment = _floats(field['Mgr0'])
    elif field['type'] == 'circular':
        mu, n = 3.986004418e14, float(field['n'])
        orbit = KeplerOrbit(
            mu=mu, semi_major_axis=(mu / n**2) ** (1.0 / 3.0), true_anomaly=float(field['u0'])
        )
    else:
        orbit = KeplerOrbit(
            mu=float(field['mu']),
            semi_major_axis=float(field['a']),
            eccentricity=float(field['e']),
            true_anomaly=float(field['f0']),
        )
    inertia = np.diag(_floats([raw['body'][key] for key in 'ABC']))
    system = System(inertia, (_rotor(_floats(raw['rotor_h'])),), orbit, weight_moment)
    return _case(raw, system, raw['initial']['q_xyzw'], raw['initial']['omega'])


def _rigid(raw):
    system = None
    if 'A' in raw['body']:
        A, B, C = _floats([raw['body'][key] for key in 'ABC'])
        H1, H2 = float(raw['field']['H1']), float(raw['field']['H2'])
        if C != A or H1 == 0.0:
            gradient = -2.0 * H1 / (C - A) if H1 else 0.0
            rotor = _rotor(_floats(raw['rotor_h_body']))
            weight_moment = np.array([0.0, 0.0, -H2])
            system = System(np.diag([A, B, C]), (rotor,), FixedDirection(gradient), weight_moment)
    return _case(raw, system, raw['q0_xyzw'], raw['omega0'])
