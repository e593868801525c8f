"""The XML notation of the messages of CCSDS, 505.0-B, as a list of its elements."""

from typing import NamedTuple
from xml.parsers import expat


class XmlElement(NamedTuple):
    """
    An element of a message.

    tag: its name without that of a namespace.  attributes: by name.  text: without the elements
    within it, and without blanks at its ends.  depth: of how many elements it is a part.  line:
    where it begins.
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
    parser = expat.ParserCreate('utf-8', '}')
    parser.buffer_text = True
    found: list[XmlElement] = []
    texts: list[list[str]] = []
    open_elements: list[int] = []

    def start(name, attributes):
        tag, depth = name.rpartition('}')[2], len(open_elements)
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
