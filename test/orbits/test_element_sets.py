"""Files of many element sets: each notation holds the same sets, and what is wrong is said."""

import csv
import json
import re
from io import StringIO
from pathlib import Path

import pytest

from satdyn_ros.orbits.element_sets import Catalogue
from satdyn_ros.orbits.tle import checked

exporter = pytest.importorskip('sgp4.exporter')
api = pytest.importorskip('sgp4.api')

# Of the verification of SGP4 (Vallado and others 2006), those with a designator.
SETS = re.findall(
    r'^(1 .{7}\d\d.{58})[^\n]*\n(2 .{67})',
    (Path(api.__file__).parent / 'SGP4-VER.TLE').read_text().replace('\r', ''),
    re.MULTILINE,
)[:8]
# As the package sgp4 writes an OMM, with numbers that five digits do not hold.
FIELDS = [
    exporter.export_omm(api.Satrec.twoline2rv(*pair), f'SAT {i}')
    | {'NORAD_CAT_ID': 100_000_000 + i}
    for i, pair in enumerate(SETS)
]


def of_csv(sets):
    file = StringIO()
    writer = csv.DictWriter(file, list(sets[0]))
    writer.writeheader()
    writer.writerows(sets)
    return file.getvalue()


def of_keywords(sets):
    return ''.join(
        'CCSDS_OMM_VERS = 2.0\n' + ''.join(f'{k} = {v}\n' for k, v in each.items()) + '\n'
        for each in sets
    )


def of_xml(sets):
    messages = (
        '<omm id="CCSDS_OMM_VERS" version="3.0"><body><segment>\n<data>'
        + ''.join(f'<{k}>{v}</{k}>' for k, v in each.items())
        + '</data></segment></body></omm>\n'
        for each in sets
    )
    return f'<ndm xmlns="urn:ccsds:schema:ndmxml">\n{"".join(messages)}</ndm>\n'


NOTATIONS = {
    'json': lambda sets: json.dumps(sets, indent=1),
    'csv': of_csv,
    'keywords': of_keywords,
    'xml': of_xml,
}


@pytest.mark.parametrize('notation', NOTATIONS)
def test_each_notation_holds_the_same_sets(notation):
    """By number, by name in either case, each the elements that sgp4 wrote."""
    catalogue = Catalogue(NOTATIONS[notation](FIELDS))
    assert len(catalogue.sets) == len(FIELDS)
    for i, fields in enumerate(FIELDS):
        found = catalogue.chosen(str(fields['NORAD_CAT_ID']))
        assert found == catalogue.chosen(f'sat {i}')
        said = dict(line.split(' = ') for line in checked(found).text.splitlines())
        for keyword in ('EPOCH', 'MEAN_MOTION', 'ECCENTRICITY', 'INCLINATION', 'BSTAR'):
            assert said[keyword] == str(fields[keyword])


@pytest.mark.parametrize(
    'declared', ['', ' xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"']
)
def test_a_prefix_of_xml_may_be_declared_or_not(declared):
    """As it is after an ndm of Space-Track was cut in parts by other programs."""
    text = of_xml(FIELDS).replace(
        ' xmlns="urn:ccsds:schema:ndmxml"', f'{declared} xsi:noNamespaceSchemaLocation="x"'
    )
    assert Catalogue(text).sets == Catalogue(of_xml(FIELDS)).sets


def test_lines_with_names_and_without():
    """Of two lines or three, a 0 before the name or not; the text is the lines themselves."""
    lines = ''.join(
        f'{("0 " if i % 2 else "") + f"NAME {i}" if i else ""}\n{first}  \n{second}\n'
        for i, (first, second) in enumerate(SETS)
    )
    catalogue = Catalogue(f'# a comment\n{lines}')
    for i, (first, second) in enumerate(SETS):
        found = catalogue.chosen(str(int(first[2:7])))
        assert found.text.split('\n') == [first, second, '']
        assert found.name == (f'NAME {i}' if i else '')
        assert lines.splitlines()[found.line - 2].startswith(first)


def test_a_number_may_begin_with_a_letter():
    """Alpha-5, without I and O: the numbers that Space-Track gives for these."""
    for written, number in (('A0000', '100000'), ('J2931', '182931'), ('Z9999', '339999')):
        lines = (f'{line[:2]}{written}{line[7:]}' for line in SETS[0])
        assert Catalogue('\n'.join(lines)).chosen(number).number == number
    assert Catalogue('\n'.join(SETS[0])).chosen('00005') == Catalogue('\n'.join(SETS[0])).sets[0]


@pytest.mark.parametrize(
    ('text', 'reason'),
    [
        ('', 'it holds no element set'),
        ('[]', 'it holds no element set'),
        ('[\n', 'line 2: its JSON is damaged'),
        ('[\n{"EPOCH": 1}\n\n{}]', 'line 4: its JSON is damaged, a comma or ] must follow'),
        ('[{},\n{"EPOCH": [1]}]', 'line 2: EPOCH is a list or an object'),
        ('[{}]\n\nx', 'line 3: its JSON is damaged, text follows'),
        ('[\n1]', 'line 2: its JSON must be an object'),
        ('[' * 200_000, 'line 1: its JSON is nested too deep'),
        ('\nEPOCH,MEAN_MOTION\n1,2\n3\n', 'line 4: it has 1 values for 2 columns'),
        ('EPOCH,MEAN_MOTION\n"1', 'line 2: its CSV is damaged'),
        ('\n<omm>\n<body>', 'line 3: its XML ends early or is damaged'),
        (f'{SETS[0][0]}\n\nNAME\n', 'line 3 must be the second of an element set'),
        (f'{SETS[0][0]}\n{SETS[0][1]}\n{SETS[0][1]}', 'line 3 must be the first'),
        ('A NAME\nANOTHER\n', 'line 2 must be the first'),
        (f'NAME\n{SETS[0][0]}\n', 'line 2: it ends within an element set'),
        ('NAME', 'line 1: it ends within an element set'),
    ],
)
def test_what_is_damaged_is_said_with_its_line(text, reason):
    """In one sentence, whatever the notation."""
    with pytest.raises(ValueError, match=f'^{re.escape(reason)}'):
        Catalogue(text)


@pytest.mark.parametrize(
    ('change', 'word', 'reason'),
    [
        ({}, '1', "it holds no set of '1', but of 100000000 SAT 0, .*SAT 4 and 3 more"),
        ({'OBJECT_NAME': 'SAT 0'}, 'sat 0', "2 sets of 'sat 0', .*; use a number"),
        ({'NORAD_CAT_ID': 100_000_000}, '100000000', "it holds 2 sets of '100000000'"),
    ],
)
def test_one_must_be_meant(change, word, reason):
    """A number or a name that none has, or two."""
    catalogue = Catalogue(json.dumps([FIELDS[0], FIELDS[1] | change, *FIELDS[2:]]))
    with pytest.raises(ValueError, match=reason):
        catalogue.chosen(word)


def test_a_set_that_does_not_fly_is_named_by_its_line():
    """That of which it begins, as of any notation."""
    fields = [FIELDS[0], FIELDS[1] | {'INCLINATION': 400}]
    text = json.dumps(fields).replace('}, {', '},\n{')
    assert checked(Catalogue(text).chosen('SAT 0'))
    with pytest.raises(ValueError, match=r'^the set of line 2: orbit\.tle .* INCLINATION is 400'):
        checked(Catalogue(text).chosen('SAT 1'))
