"""The XML notation of the messages of CCSDS, 505.0-B, as a list of its elements."""

from collections.abc import Iterator, Sequence
from typing import NamedTuple
from xml.parsers import expat

from .kvn import KvnMetadata, KvnRow

# Those of the standards; a message in others is not read.
_UNITS = ('', '1/s', 'deg', 'deg/s', 'km', 'km/s', 'km/s**2', 's')


class XmlElement(NamedTuple):
    """
    An element of a message.

    Attributes
    ----------
    tag : str
        its name without a prefix, declared or not
    attributes : dict
        by name
    text : str
        without the elements within it, and without blanks at its ends
    depth : int
        of how many elements it is a part
    line : int
        where it begins
    """

    tag: str
    attributes: dict[str, str]
    text: str
    depth: int
    line: int


def xml_elements(text: str) -> list[XmlElement]:
    """
    Return the elements of a text in XML, in the order in which they begin.

    ValueError: it is none; with what is wrong and where.
    """
    given = text.removeprefix('\ufeff').lstrip()
    above = text.count('\n', 0, len(text) - len(given))
    parser = expat.ParserCreate('utf-8')
    parser.buffer_text = True
    found: list[XmlElement] = []
    texts: list[list[str]] = []
    open_elements: list[int] = []

    def start(name, attributes):
        tag, depth = name.rpartition(':')[2], len(open_elements)
        open_elements.append(len(found))
        found.append(XmlElement(tag, attributes, '', depth, parser.CurrentLineNumber + above))
        texts.append([])

    def characters(data):
        texts[open_elements[-1]].append(data)

    parser.StartElementHandler = start
    parser.EndElementHandler = lambda _: open_elements.pop()
    parser.CharacterDataHandler = characters
    try:
        parser.Parse(given.rstrip().encode(), True)
    except expat.ExpatError as error:
        raise ValueError(
            f'line {error.lineno + above}: its XML ends early or is damaged, '
            f'{expat.ErrorString(error.code)}'
        ) from None
    return [
        element._replace(text=''.join(parts).strip())
        for element, parts in zip(found, texts, strict=True)
    ]


def is_xml(text: str) -> bool:
    """Whether a text is in XML, by how it begins."""
    return text.removeprefix('\ufeff').lstrip().startswith('<')


def xml_rows(
    text: str, message: str, versions: Sequence[str], state: str, order: Sequence[str]
) -> Iterator[KvnRow]:
    """
    Yield the rows of data of a message in XML, as they would stand in the other notation.

    Parameters
    ----------
    text : str
        the message
    message : str
        its element, such as aem
    versions : sequence of str
        those that are read
    state : str
        the element of a row
    order : sequence of str
        names of its numbers in the order of a row; what has none of them stands behind, as the
        file has it

    Raises
    ------
    ValueError
        it is another message, or has other units; with the line
    """
    elements = xml_elements(text)
    version = _version(elements, message, versions)
    metadata, within = KvnMetadata(), elements[0]
    values: list[XmlElement] = []
    depths = [*(each.depth for each in elements[1:]), 0]

    def row():
        return KvnRow(version, metadata, _words(values, ('EPOCH', *order)), within.line)

    for each, next_depth in zip(elements, depths, strict=True):
        if each.depth <= within.depth and within.tag == state:
            yield row()
            within = elements[0]
        if each.tag == 'metadata':
            metadata, within = KvnMetadata(each.line), each
        elif each.tag == state:
            values, within = [], each
        elif next_depth > each.depth or each.tag == 'COMMENT' or each.depth <= within.depth:
            continue
        elif within.tag == 'metadata':
            if each.tag in metadata:
                raise ValueError(f'line {each.line}: {each.tag} is given twice')
            metadata[each.tag], metadata.lines[each.tag] = each.text, each.line
        elif within.tag == state:
            unit = each.attributes.get('units', '')
            if unit.lower() not in _UNITS:
                raise ValueError(f'line {each.line}: {each.tag} is in {unit}, which is not read')
            values.append(each)
    if within.tag == state:
        yield row()


def _version(elements, message, versions):
    """Return the version of a message, which must be one of those that are read."""
    roots = [each for each in elements if each.tag == message]
    version = roots[0].attributes.get('version', '') if roots else ''
    if version not in versions:
        raise ValueError(
            f'its XML has no element {message} of version {" or ".join(versions)}, but begins '
            f'with {elements[0].tag}'
        )
    return version


def _words(values, order):
    """Return the texts of values, first of those with the names in an order."""
    in_order = [each for name in order for each in values if each.tag == name]
    in_order += [each for each in values if each.tag not in order]
    return [' '.join(each.text.split()) for each in in_order]
