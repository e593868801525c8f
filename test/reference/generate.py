"""
Compute the truths of the reference cases to fifty digits and compare the stored digits with them.

    python test/reference/generate.py [--first N] [NAME ...]     all cases, or those named
    python test/reference/generate.py --write NAME               store the states of a new case

A new case needs all but its states, of which it needs the times. newtonian.json stores 32 digits,
rigid.json 28; rotors.json stores 36, of which 27 hold where they came from quadruple precision.
The states of nasa_jeod.json are another program's output and are not computed here.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import gmpy2
import mpmath
from constants import NOTHING, constants_of
from described import problem_of
from equations import dot, numbers
from gmpy2 import mpfr

HERE = Path(__file__).parent
FILES = ('newtonian.json', 'rigid.json', 'rotors.json')
ENOUGH = 1e-25


def of_states(case: dict[str, Any]) -> float:
    """Return how far the stored states are from those computed, each by its largest length."""
    computed = list(problem_of(case).states(numbers(state['t'] for state in case['states'])))
    worst = mpfr(0)
    for key in case['states'][0].keys() - {'t'}:
        stored = [numbers(state[key]) for state in case['states']]
        off = [_minus(given, state[key]) for given, state in zip(stored, computed, strict=True)]
        if any(map(any, off)):
            worst = max(worst, max(map(_length, off)) / max(map(_length, stored)))
    return float(worst)


def of_constants(case: dict[str, Any]) -> float:
    """Return how far the stored constants are from those computed, relative."""
    if 'rotors' in case:
        return 0.0  # lists none
    computed, stored = constants_of(case), dict(case['first_integrals'])
    stored.update(case.get('derived', case.get('closed_form_params', {})))
    worst = 0.0
    for key in stored.keys() & computed.keys():
        for x, y in _pairs(stored[key], computed[key]):
            if x != y:  # infinite ones too
                worst = max(worst, float(abs(x - y) / (abs(y) if abs(y) > NOTHING else 1)))
    return worst


def _pairs(stored: Any, computed: Any) -> Iterator[tuple[mpmath.mpc, mpmath.mpc]]:
    """Yield the numbers of a stored constant beside those computed; a root beside the nearest."""
    if isinstance(stored, dict):
        stored = stored['value']
    if not isinstance(stored, list):
        yield mpmath.mpf(stored), computed
    elif stored and not isinstance(stored[0], list) and len(computed) == 3:  # a vector
        yield from zip(map(mpmath.mpf, stored), computed, strict=True)
    else:
        for entry in stored:
            root = mpmath.mpc(*entry) if isinstance(entry, list) else mpmath.mpf(entry)
            off = [abs(other - root) for other in computed]
            yield root, computed[off.index(min(off))]


def _minus(a: list[mpfr], b: list[mpfr]) -> list[mpfr]:
    return [x - y for x, y in zip(a, b, strict=True)]


def _length(v: list[mpfr]) -> mpfr:
    return gmpy2.sqrt(dot(v, v))


def write(content: dict[str, Any], case: dict[str, Any]) -> None:
    """Replace the states of a case of a file's content by those computed, with 36 digits."""
    keys = case['states'][0].keys() | content['cases'][0]['states'][0].keys()
    times = [state['t'] for state in case['states']]
    case['states'] = [
        {'t': t} | {key: [f'{x:.36g}' for x in v] for key, v in state.items() if key in keys}
        for t, state in zip(times, problem_of(case).states(numbers(times)), strict=True)
    ]


def main() -> int:
    """Compare, or write; the exit code is 1 where stored digits differ from those computed."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument('names', nargs='*', metavar='NAME', help='cases; default: all')
    parser.add_argument('--first', type=int, metavar='N', help='compare the first N states only')
    parser.add_argument('--write', action='store_true', help='store the states of the named cases')
    arguments = parser.parse_args()
    if arguments.write and not arguments.names:
        parser.error('--write needs the names of cases')
    failed = False
    for file in FILES:
        content = json.loads((HERE / file).read_text())
        cases = [c for c in content['cases'] if c['name'] in (arguments.names or [c['name']])]
        for case in cases:
            if arguments.write:
                write(content, case)
                (HERE / file).write_text(json.dumps(content, indent=1))
            case['states'] = case['states'][: arguments.first]
            states, constants = of_states(case), of_constants(case)
            failed |= max(states, constants) > ENOUGH
            print(f'{case["name"]:42} states {states:.0e}  constants {constants:.0e}', flush=True)
    return int(failed)


if __name__ == '__main__':
    sys.exit(main())
