"""The reference cases are what their equations give: recomputed to fifty digits."""

import json
import shutil
import subprocess
import sys

import pytest
from cases import REFERENCE

pytest.importorskip('gmpy2')
# One case of each kind, the cheap ones: fixed field, circular and elliptic orbit, free, Paladini's
# top, body in a fluid, rotors.
KINDS = [
    'A10_exact_separatrix',
    'G3_BG_oblate_libration_spacecraft',
    'X3_ellipse_e0p1_triaxial_gyrostat',
    'free_tri_exact_separatrix',
    'pal1_steady_precession_double_root',
    'pal2_helicoidal_coupled',
    'R8_fixed_4_rotors',
]


def generate(folder, *arguments):
    """Run the generator of a folder of reference cases; return exit code and output."""
    # a process of its own: precision is a global of gmpy2 and mpmath
    done = subprocess.run(
        [sys.executable, folder / 'generate.py', *arguments],
        capture_output=True,
        text=True,
        timeout=3600,
    )
    return done.returncode, done.stdout + done.stderr


def test_one_case_of_each_kind():
    """Stored states and constants agree to 1e-25 with Taylor integration and quadrature."""
    code, output = generate(REFERENCE, '--first', '3', *KINDS)
    assert code == 0, output
    assert len(output.splitlines()) == len(KINDS)


@pytest.mark.parametrize('table', ['states', 'first_integrals'])
def test_a_wrong_digit_is_found(tmp_path, table):
    """A change of the twenty-fourth digit of a rate or a constant fails the comparison."""
    folder = shutil.copytree(REFERENCE, tmp_path / 'reference')
    content = json.loads((folder / 'rigid.json').read_text())
    (case,) = (case for case in content['cases'] if case['name'] == 'free_axi_oblate')
    row, key = (
        (case['states'][1]['omega'], 0)
        if table == 'states'
        else (case['first_integrals'], 'L_norm')
    )
    row[key] = row[key][:-5] + str((int(row[key][-5]) + 5) % 10) + row[key][-4:]
    (folder / 'rigid.json').write_text(json.dumps(content))
    code, output = generate(folder, '--first', '2', 'free_axi_oblate')
    assert code == 1, output


def test_a_new_case_is_written(tmp_path):
    """States that are given by their times alone are computed and stored."""
    folder = shutil.copytree(REFERENCE, tmp_path / 'reference')
    content = json.loads((folder / 'rotors.json').read_text())
    case = next(case for case in content['cases'] if case['name'] == 'R8_fixed_4_rotors')
    stored = case['states'][0]
    case['states'] = [{'t': stored['t']}]
    (folder / 'rotors.json').write_text(json.dumps(content))
    code, output = generate(folder, '--write', 'R8_fixed_4_rotors')
    assert code == 0, output
    content = json.loads((folder / 'rotors.json').read_text())
    case = next(case for case in content['cases'] if case['name'] == 'R8_fixed_4_rotors')
    assert case['states'][0].keys() == stored.keys()
    assert [x[:28] for x in case['states'][0]['omega']] == [x[:28] for x in stored['omega']]


@pytest.mark.torture
def test_all_cases():
    """Each digit of every file, as `make reference` compares them."""
    code, output = generate(REFERENCE)
    assert code == 0, output
