"""What `satdyn describe --sensors` prints: each sensor as its datasheet would have it."""

from typing import Any

from ..base.units import in_trade
from ..run.scenario import Scenario

# Over which an Allan deviation is printed [s].
_TAUS_S = (1.0, 100.0, 10_000.0)


def print_sensors(scenario: Scenario) -> None:
    """
    Print what is given of each sensor, in the units of datasheets and in SI.

    ValueError: there is no sensor.
    """
    if not scenario.sensors:
        raise ValueError('sensors.names is empty; --sensors needs one that it can describe')
    for name, sensor in scenario.sensors.items():
        interval_s = sensor.divisor / float(scenario.rate)
        print(f'{name} ({sensor.kind}), a sample every {interval_s:g} s')
        for key in sensor.keys:
            value = scenario[f'sensors.{name}.{key.name}']
            if value != key.default:
                _print_line(key.name, value, key.unit)
        _print_allan(sensor)


def _print_line(leaf: str, value: Any, unit: str) -> None:
    numbers = list(value) if isinstance(value, tuple) else value
    if isinstance(value, bool):
        in_si = 'true' if value else 'false'
    elif isinstance(numbers, list):
        in_si = f'[{", ".join(f"{x:.6g}" for x in numbers)}]'
    else:
        in_si = f'{value:.6g}'
    has_trade = unit or leaf == 'scale_factor'
    trade = in_trade(numbers, unit) if has_trade else ''
    print(f'  {leaf:18}  {f"{in_si} {unit}".rstrip():34}  {trade}'.rstrip())


def _print_allan(sensor: Any) -> None:
    """Print the Allan deviations of a sensor that has them: what its errors add up to."""
    for tau_s in _TAUS_S:
        deviation = sensor.allan_deviation(tau_s)
        if deviation is not None:
            in_si = f'{deviation:.6g} {sensor.unit}'
            of_tau = f'over {tau_s:g} s'
            print(f'  Allan {of_tau:12}  {in_si:34}  {in_trade(deviation, sensor.unit)}'.rstrip())
