"""Scenario, events and sweep files, mutated: each is read, or refused in one sentence."""

import random
import time
from pathlib import Path

import pytest

from satdyn_ros.run.events import from_yaml_text
from satdyn_ros.run.scenario import Scenario

ROOT = Path(__file__).parents[2]
SCENARIOS = [path.read_text() for path in sorted((ROOT / 'config').glob('*.yaml'))]
EVENTS = """\
- {at_s: 0.5, torque: [0.0, 0.01, 0.0], until_s: 2.0}
- {at_s: 1, request: {initial.angular_velocity: [0.0, 0.0, 0.1], initial.frame: lvlh}}
- {at_s: 1.5, reset: true}
- {at_s: 4, topics: [attitude, imu]}
"""
# What is put in the place of a word or a number.
WORDS = (  # noqa: SIM905
    'nan .nan inf -.inf 1e400 -1e308 5e-324 0 -0.0 1e-300 99999999999999999999 0x1f 1_000 yes '
    'null ~ [] {} [[]] "" "\\0" !!bool&maybe !!int&x !!binary&aGk= &a&1 *a << ? - : # | > % @ ` '
    'true 2020-01-01 1:30 é 日本 \ud800 [1,2,3] [1.0,a] {a:1} [0.0,0.0,0.0,0.0]'
).split(' ')


def mutated(text, chance):
    """Return a text with some lines, words or characters changed."""
    for _ in range(chance.randrange(1, 4)):
        lines = text.split('\n')
        i = chance.randrange(len(lines))
        match chance.randrange(6):
            case 0:
                del lines[i]
            case 1:
                lines.insert(i, chance.choice(lines))
            case 2:
                lines[i] = chance.choice(['', ' ', '   ', '\t']) + lines[i].lstrip()
            case 3:
                words = lines[i].split(' ')
                words[chance.randrange(len(words))] = chance.choice(WORDS).replace('&', ' ')
                lines[i] = ' '.join(words)
            case 4:
                at = chance.randrange(len(lines[i]) + 1)
                lines[i] = lines[i][:at] + chr(chance.randrange(1, 300)) + lines[i][at:]
            case _:
                at = chance.randrange(len(lines[i]) + 1)
                lines[i] = lines[i][:at] + lines[i][at + 1 + chance.randrange(4) :]
        text = '\n'.join(lines)
    return text


@pytest.mark.parametrize(
    ('seed', 'count'), [(1, 400), pytest.param(2, 20_000, marks=pytest.mark.torture)]
)
def test_mutated_files_are_read_or_refused(capsys, seed, count):
    """Nothing but ValueError, of one line and not endless, whatever was mutated."""
    chance, read, longest_s = random.Random(seed), 0, 0.0
    scenario = Scenario()
    for _ in range(count):
        is_scenario = chance.random() < 0.6
        text = mutated(chance.choice(SCENARIOS) if is_scenario else EVENTS, chance)
        begin_s = time.perf_counter()
        try:
            if is_scenario:
                Scenario.from_yaml_text(text)
            else:
                from_yaml_text(text, scenario, 'events')
            read += 1
        except ValueError as error:
            sentence = str(error)
            assert '\n' not in sentence, text
            assert 0 < len(sentence) < 1000, text
        except Exception as error:
            raise AssertionError(text) from error
        longest_s = max(longest_s, time.perf_counter() - begin_s)
    with capsys.disabled():
        print(f'\n{count} mutated files: {read} read, {count - read} refused, {longest_s:.3f} s')
    assert 0 < read < count
