"""What `satdyn describe` prints: what theory says about a scenario, for people."""

import math
from itertools import groupby
from typing import Any

from ..base.units import in_trade
from ..run.describe import describe
from ..run.scenario import Scenario

# Components of unit vectors below this are rounding, and no other value is this small.
_NOISE = 1e-15


def print_description(scenario: Scenario) -> None:
    """Print what theory says about a scenario."""
    described = describe(scenario)
    if described['orbit'] is not None:
        _print_orbit(described['orbit'])
    motion = described['motion']
    if motion is None:
        print(f'no closed form: {described["why_not"]}')
    else:
        print(f'{motion["name"]} ({motion["source"]})')
        for fact in motion['facts']:
            value = f'{fact["name"]} = {_in_both(fact["value"], fact["unit"])}'
            print(f'  {value:48}  {fact["meaning"]}')
    print(f'principal moments {_text(described["principal_moments"])} kg m^2, along body axes')
    for axis in described['principal_axes_b']:
        print(f'  {_text(axis)}')
    print('first integrals')
    for name, integral in described['first_integrals'].items():
        print(f'  {name} = {_in_both(integral["value"], integral["unit"])}')
    _print_steady(described['steady_motions'], scenario.is_fixed)
    rotation_class = described['rotation_class']
    if rotation_class is not None:
        print(f'rotation about a body-fixed axis: {_class(rotation_class)}')
    precession = described['regular_precession']
    if precession is not None:
        _print_precession(precession)
    if described['elliptic_orbit'] is not None:
        _print_elliptic_orbit(described['elliptic_orbit'])
    if described['torques']:
        _print_torques(described['torques'])
    if described['thruster']:
        _print_of_each_thruster(described['thruster'])
    if described['flexible'] is not None:
        _print_flexible(described['flexible'], float(scenario.rate))


def _print_orbit(orbit: dict[str, Any]) -> None:
    """Print the orbit of an element set or an ephemeris: its epochs, heights and period."""
    begin, tick_0 = orbit.get('begin'), orbit['tick_0'][:19]
    if begin is None:
        age = orbit['age_days']
        is_what = 'old at' if age >= 0.0 else 'after'
        print(
            f'elements of {orbit["elements_epoch"][:19]} by SGP4, {abs(age):.4g} days {is_what} '
            f'tick 0, {tick_0}'
        )
        names = ('perigee', 'apogee')
    else:
        print(f'ephemeris from {begin[:19]} to {orbit["end"][:19]}, tick 0 at {tick_0}')
        names = ('lowest', 'highest')
    heights = ', '.join(f'{name} {orbit[f"{name}_height_m"] / 1e3:.1f} km' for name in names)
    period_s, inclination = orbit['period_s'], math.degrees(orbit['inclination_rad'])
    print(
        f'  {heights}, period {period_s:.6g} s ({period_s / 60.0:.4g} min), inclination '
        f'{inclination:.6g} deg'
    )


def _print_torques(torques: list[dict[str, Any]]) -> None:
    """Print the size of each torque over a turn of the orbit, the table of an attitude budget."""
    print('torques over one orbit, as it flies')
    print(f'  {"":20}  {"largest":>11}  {"mean":>11}  momentum gathered in inertial axes')
    for torque in torques:
        largest, mean = (f'{torque[name]:.3g} N m' for name in ('largest_n_m', 'mean_n_m'))
        gathered = ', '.join(f'{x:.2g}' for x in torque['momentum_n_m_s'])
        print(f'  {torque["topic"]:20}  {largest:>11}  {mean:>11}  [{gathered}] N m s')


def _print_of_each_thruster(found: list[dict[str, Any]]) -> None:
    """Print the torque of each thruster, and what its shortest pulse does."""
    print('torque of each thruster, body axes; of its shortest pulse impulse and change of rate')
    for each in found:
        torque, rate = (
            ', '.join(f'{x if abs(x) > _NOISE else 0.0:.3g}' for x in numbers)
            for numbers in (each['torque_n_m'], map(math.degrees, each['least_rate_rad_s']))
        )
        impulse = f'{each["least_impulse_n_m_s"]:.3g} N m s'
        print(f'  {each["name"]:12}  [{torque}] N m; {impulse}, [{rate}] deg/s')


def _print_flexible(flexible: dict[str, Any], rate_hz: float) -> None:
    """Print the frequencies of modes, each by itself and with the body."""
    print('flexible parts')
    for name, frequency in zip(flexible['names'], flexible['frequencies_rad_s'], strict=True):
        print(f'  {name}: {_frequency(frequency)}, with the body held')
    free = ', '.join(map(_frequency, flexible['free_rad_s']))
    print(f'  body and parts together, free: {free}')
    for frequency in flexible['unseen_rad_s']:
        print(
            f'  publish.rate {rate_hz:g} Hz is too slow for {_frequency(frequency)}: samples, and '
            'a loop that is closed by them, see a slower swing; it must be above '
            f'{frequency / math.pi:.4g} Hz'
        )


def _frequency(rad_s: float) -> str:
    return f'{_text(rad_s)} rad/s = {rad_s / math.tau:.4g} Hz'


def _print_precession(precession: dict[str, Any]) -> None:
    """Print a regular precession: its rates, its sense and its cones."""
    print(f'regular precession, {precession["sense"] or "neither progressive nor retrograde"}')
    rates = (precession[name] for name in ('spin_rad_s', 'precession_rad_s'))
    spin, rate = (_in_both(each, 'rad/s') for each in rates)
    print(f'  spin {spin} about {_text(precession["axis_b"])} in body axes')
    print(f'  precession {rate} about {_text(precession["axis_i"])} in inertial axes')
    print(f'  nutation {_in_both(precession["nutation_rad"], "rad")}')
    cones = [_text(precession[name]) for name in ('body_cone_rad', 'space_cone_rad')]
    print(f'  cones of {" and ".join(cones)} rad in body and space: {precession["cones"]}')


def _print_elliptic_orbit(ellipse: dict[str, Any]) -> None:
    """Print what an ellipse does to the equilibria and librations of a circle."""
    eccentricity, period = _text(ellipse['eccentricity']), _text(ellipse['period_s'])
    print(f'ellipse of eccentricity {eccentricity}, period {period} s: no attitude rests in LVLH')
    for one in ellipse['librations']:
        amplitude = one['forced_amplitude_rad']
        forced = 'not small' if amplitude is None else _in_both(amplitude, 'rad')
        print(
            f'  in the plane, about {_text(one["normal_b"])}: p = {_text(one["p"])}, libration '
            f'forced once per orbit: {forced}'
        )


def _print_steady(steady: list[dict[str, Any]], is_fixed: bool) -> None:
    """Print the steady motions, those that differ only by their signs in one line."""
    if not steady:
        return
    print('steady rotations' if is_fixed else 'relative equilibria')

    def outcome(one):
        periods = [f'{period:.6g}' for period in one['periods_s']]
        drift = one['attitude_drift_rad']
        return one['stability'], one['argument'], periods, '' if drift is None else _text(drift)

    order = {'stable': 0, 'undecided': 1, 'unstable': 2}
    ranked = sorted(steady, key=lambda one: (order[one['stability']], *outcome(one)[1:]))
    where = 'axis' if is_fixed else 'up'
    for (stability, argument, periods, drift), group in groupby(ranked, outcome):
        alike = list(group)
        print(f'  {stability}: {argument}')
        if periods:
            print(f'    periods of small motion: {", ".join(periods)} s')
        if drift:
            print(
                f'    stable rate; attitude drifts by {drift} rad per day for a change of 1e-6 of '
                'the rate'
            )
        for one in alike:
            line = f'{where} {_text(one["axis_b"])}'
            if not is_fixed:
                line += f', attitude to LVLH {_text(one["q_lb"])}'
            print(f'    {line}')


def _class(rotation_class: dict[str, Any]) -> str:
    if not rotation_class['is_rotation']:
        return f'no, {rotation_class["why"]}'
    kind = 'uniform' if rotation_class['is_uniform'] else 'not uniform'
    return f'yes, {kind}: {rotation_class["why"]}'


def _in_both(value: Any, unit: str) -> str:
    """Return a value in its unit and, where people have another, in that."""
    text = f'{_text(value)} {unit}'.rstrip()
    numbers = value if isinstance(value, list) else [value]
    if not unit or not all(isinstance(x, float) for x in numbers):
        return text
    clean = [x if abs(x) > _NOISE else 0.0 for x in numbers]
    trade = in_trade(clean if isinstance(value, list) else clean[0], unit)
    return f'{text} = {trade}' if trade else text


def _text(value: Any) -> str:
    """Return a value to six digits; none is infinite or absent."""
    if value is None:
        return 'none'
    if isinstance(value, list):
        return f'[{", ".join(_text(item) for item in value)}]'
    if isinstance(value, str):
        return value
    return f'{value if abs(value) > _NOISE else 0.0:.6g}'
