"""All that moves and acts in one body, against the reference."""

import pytest
from actuated import cases, check, flown

from satdyn_ros.torques.hysteresis import Hysteresis
from satdyn_ros.torques.thrust import thrust_of

(CASE,) = cases('everything.json').values()


def test_reference():
    """
    Attitude, rates, wheels, modes, rods and propellant, within the bound of the case.

    Two modes, a wheel and a free rotor, three thrusters, two rods, a residual dipole,
    magnetorquers and an applied torque, in the field of the IGRF, under the gravity gradient.
    """
    _, samples = flown(CASE)
    check(CASE, samples)
    for row, one in zip(CASE['states'], samples, strict=True):
        states, torques = one.states, one.system.torques
        rods = Hysteresis.among(torques)
        assert rods is not None
        found = dict(zip(row['hysteresis'], rods.flux_densities(states.inner)[0], strict=True))
        assert found == approx(row['hysteresis'], 0.3)
        thrusters = thrust_of(one.system)
        for name, values, largest in (
            ('thrust', thrusters.thrusts(states.orbit_s)[0], 0.05),
            ('propellant', thrusters.propellant_used(states.orbit_s)[0], 1e-4),
        ):
            assert dict(zip(row[name], values, strict=True)) == approx(row[name], largest)


def approx(given, largest):
    """Return numbers by name that are those of the truth within its bound of the largest."""
    return pytest.approx(given, rel=0.0, abs=CASE['bound'] * largest)
