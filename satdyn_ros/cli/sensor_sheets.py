"""What `satdyn describe --sensors` prints: each sensor as its datasheet would have it."""

from typing import Any

from ..base.key import listed
from ..base.units import in_trade
from ..run.scenario import Scenario

# Over which an Allan deviation is printed [s].
_TAUS_S = (1.0, 100.0, 10_000.0)


def sheets(scenario: Scenario) -> dict[str, Any]:
    """
    Return, by name, each sensor's type, interval_s, what is given of it and Allan deviations.

    What has a unit is {value, unit, trade}: in SI, and as a text in the unit of datasheets.
    ValueError: there is no sensor.
    """
    if not scenario.sensors:
        raise ValueError('sensors.names is empty; --sensors needs one that it can describe')
    return {name: _sheet(scenario, name, sensor) for name, sensor in scenario.sensors.items()}


def _sheet(scenario, name, sensor):
    values = [(key, scenario[f'sensors.{name}.{key.name}']) for key in sensor.keys]
    deviations = [(tau_s, sensor.allan_deviation(tau_s)) for tau_s in _TAUS_S]
    return {
        'type': sensor.kind,
        'interval_s': sensor.divisor / float(scenario.rate),
        'given': {
            key.name: _in_both(listed(value), key.unit, key.in_trade(value))
            for key, value in values
            if value != key.default
        },
        'allan': [
            {
                'tau_s': tau_s,
                **_in_both(deviation, sensor.unit, in_trade(deviation, sensor.unit)),
            }
            for tau_s, deviation in deviations
            if deviation is not None
        ],
    }


def _in_both(value, unit, trade):
    return {'value': value, 'unit': unit, 'trade': trade}


def print_sensors(scenario: Scenario) -> None:
    """Print the sheets of the sensors; ValueError: there is no sensor."""
    for name, sheet in sheets(scenario).items():
        print(f'{name} ({sheet["type"]}), a sample every {sheet["interval_s"]:g} s')
        for leaf, given in sheet['given'].items():
            _print_line(leaf, given)
        for one in sheet['allan']:
            _print_line(f'Allan over {one["tau_s"]:g} s', one)


def _print_line(what: str, sized: dict[str, Any]) -> None:
    value, unit, trade = (sized[name] for name in ('value', 'unit', 'trade'))
    if isinstance(value, bool):
        in_si = 'true' if value else 'false'
    elif isinstance(value, list):
        in_si = f'[{", ".join(f"{x:.6g}" for x in value)}]'
    else:
        in_si = f'{value:.6g}'
    print(f'  {what:18}  {f"{in_si} {unit}".rstrip():34}  {trade}'.rstrip())
