"""The keys of rotors."""

from ..base.key import Key
from .rotor import MODES

ROTOR_NAMES = Key(
    'rotor.names',
    'string_array',
    (),
    '',
    'names of several rotors, each described by rotor.NAME.mode and so on; without names '
    'the one rotor called rotor is described by rotor.mode and so on',
)

# Of the one rotor without a name, and by their last parts of each that has one.
ROTOR_KEYS = (
    Key(
        'rotor.mode',
        'string',
        'none',
        '',
        "the gyrostat's rotor: none, constant relative momentum, freely spinning, or motor",
        choices=MODES,
    ),
    Key(
        'rotor.axis',
        'double_array',
        (0.0, 1.0, 0.0),
        '',
        "unit vector along the rotor's axis, body axes",
        lengths=(3,),
        is_direction=True,
    ),
    Key(
        'rotor.momentum',
        'double',
        0.0,
        'N m s',
        'relative momentum along the axis; rotor.mode constant_momentum only',
        changes='service',
    ),
    Key(
        'rotor.inertia',
        'double',
        0.0,
        'kg m^2',
        "the rotor's axial inertia; rotor.mode free and motor only",
        low=0.0,
    ),
    Key(
        'rotor.speed',
        'double',
        0.0,
        'rad/s',
        'initial speed relative to the body; rotor.mode free and motor only',
        changes='service',
        trade='rpm',
    ),
    Key(
        'rotor.friction',
        'double',
        0.0,
        'N m s',
        'viscous friction between rotor and body; rotor.mode free and motor only',
        low=0.0,
        also=('N m s/rad',),
    ),
    Key(
        'rotor.max_torque',
        'double',
        0.0,
        'N m',
        'a commanded torque is limited to this; 0: no limit; rotor.mode motor only',
        low=0.0,
    ),
    Key(
        'rotor.max_speed',
        'double',
        0.0,
        'rad/s',
        'a rotor at this speed gets no torque that makes it faster; 0: no limit; rotor.mode '
        'motor only',
        low=0.0,
        trade='rpm',
    ),
    Key(
        'rotor.coulomb_friction',
        'double',
        0.0,
        'N m',
        'dry friction between rotor and body; rotor.mode free and motor only',
        low=0.0,
        is_optional=True,
    ),
    Key(
        'rotor.friction_speed',
        'double',
        0.1,
        'rad/s',
        'speed within which dry friction changes its sign, as tanh; rotor.mode free and motor '
        'only',
        above=0.0,
        is_optional=True,
    ),
    Key(
        'rotor.speed_gain',
        'double',
        0.0,
        '1/s',
        'gain of the loop that follows a commanded speed: 1 / its time constant; 0: no speed '
        'is commanded; rotor.mode motor only',
        low=0.0,
        is_optional=True,
    ),
    Key(
        'rotor.static_imbalance',
        'double',
        0.0,
        'kg m',
        'mass of the rotor times the distance of its mass centre from its axis; rotor.mode '
        'free and motor only',
        low=0.0,
        is_optional=True,
    ),
    Key(
        'rotor.dynamic_imbalance',
        'double',
        0.0,
        'kg m^2',
        'product of inertia of the rotor with its axis; rotor.mode free and motor only',
        low=0.0,
        is_optional=True,
    ),
    Key(
        'rotor.position',
        'double_array',
        (0.0, 0.0, 0.0),
        'm',
        'position of the rotor from the mass centre, body axes, the arm of its static imbalance; '
        'rotor.mode free and motor only',
        lengths=(3,),
        is_optional=True,
    ),
)
