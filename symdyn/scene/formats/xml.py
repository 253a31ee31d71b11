"""XML that a stranger wrote, read without trusting it: time and memory stay bounded whatever the file holds.

Document types are refused whole, so that there are no entities to expand and nothing outside to fetch. The text is fed
to the parser in small pieces and refused as soon as it nests too deep, grows too many elements, or opens a tag that
does not end. What remains is a plain tree of elements with the lines they stand in; of a text
between tags the beginning is kept.

Two slips that other readers of robot files pass over are mended with a note, in the text and before the parser sees it:
a declaration <?xml ...?> that is not the first thing of the file, and prefixes that are declared nowhere.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Protocol
from xml.etree.ElementTree import ParseError
from xml.parsers.expat import errors

from defusedxml.common import DefusedXmlException
from defusedxml.ElementTree import DefusedXMLParser

from symdyn.bounds import BOUNDS
from symdyn.errors import SceneError
from symdyn.frozen import dataclass, field
from symdyn.scene.declaration.reading import LARGEST, Opened, read_bounded
from symdyn.scene.values.entry import Faults, shorten

LARGEST_FILE = LARGEST
LONGEST_TAG = BOUNDS["bytes of a tag"]
DEEPEST = BOUNDS["levels of an XML file"]
MOST_ELEMENTS = BOUNDS["elements of an XML file"]
PIECE = 2**16
LONGEST_GAP = 10_000
MOST_PREFIXES = 50
MOST_COMMENTS = 1000

LONGEST_TEXT = 1000
"""Characters of the text of an element that are kept; that of a longer one ends in dots, and is no number."""

_BOM = b"\xef\xbb\xbf"

_PROLOG = ((b"<!--", b"-->"), (b"<?", b"?>"), (b"<!", b">"))  # what may stand in front of the root element

_ROOT = re.compile(rb"<([A-Za-z_][\w.:-]*)")

_PREFIX = re.compile(rb"(?:<|\s(?=[\w.:-]{1,200}\s{0,9}=))([A-Za-z_][\w.-]{0,60}):[A-Za-z_]")

_DECLARED = re.compile(rb"xmlns:([A-Za-z_][\w.-]{0,60})\s{0,9}=")

Note = Callable[[str, str], None]
"""Takes where and what was found; see `Faults.note`."""

UNBOUND_PREFIX = errors.codes[errors.XML_ERROR_UNBOUND_PREFIX]

TOO_LARGE = "a robot file has no need of that, keep meshes and textures in files of their own"


@dataclass(frozen=True, eq=False)
class XmlElement:
    """An element of an XML file.

    Attributes:
        tag: its name; one of a namespace reads {namespace}name.
        attributes: by name, in the order of the file.
        line: where it begins, from 1.
        children: elements inside it, in the order of the file.
        pieces: of the text inside it.
    """

    tag: str
    attributes: dict[str, str]
    line: int
    children: list[XmlElement] = field(default_factory=list)
    pieces: list[str] = field(default_factory=list)

    @staticmethod
    def read(path: Path | Opened, note: Note | None = None) -> XmlElement:
        """Return the root element of an XML file; `note` is told what was mended.

        Raises:
            SceneError: in one line, why the file is not XML that can be read.
        """
        return XmlElement.parse(
            read_bounded(path, LARGEST_FILE, "a file such as robot.urdf", TOO_LARGE), str(path), note
        )

    @staticmethod
    def noted(path: Path | Opened) -> tuple[XmlElement, Faults]:
        """Return the root element of an XML file, with what notes and faults of it go to; errors as of `read`."""
        faults = Faults(str(path))
        return XmlElement.read(path, faults.note), faults

    def check_root(self, tag: str, file: str, faults: Faults) -> None:
        """Raise SceneError where it is not the root element of a kind of file."""
        if self.tag != tag:
            raise SceneError(f"{faults.source}: its root is <{self.tag}>; the root of {file} is <{tag}>")

    @staticmethod
    def parse(content: bytes, source: str, note: Note | None = None) -> XmlElement:
        """Return the root element of XML text.

        Args:
            content: the file as bytes; its declaration or its first bytes tell the encoding, UTF-8 without them.
            source: name of the file, for messages.
            note: is told what was mended in the text.

        Raises:
            SceneError: in one line, why the text is not XML that can be read.
        """
        if len(content) > LARGEST_FILE:
            raise SceneError(f"{source}: holds more than {LARGEST_FILE >> 20} MB; {TOO_LARGE}")
        content = _declaration_first(content, note)
        try:
            return _parse(content, source)
        except _UnboundPrefixError:
            declared = _with_prefixes(content, note)
            if declared == content:
                raise
        return _parse(declared, source)

    def all(self, tag: str) -> list[XmlElement]:
        return [child for child in self.children if child.tag == tag]

    def first(self, tag: str) -> XmlElement | None:
        """Return the first child called `tag`, as readers of URDF do when there are several."""
        return next((child for child in self.children if child.tag == tag), None)

    @property
    def text(self) -> str:
        """The text inside it, without blanks around it."""
        return "".join(self.pieces).strip()

    def flat(self) -> XmlElement:
        """Return the element with what children without children say, by their names, among its attributes."""
        said = {child.tag: child.text for child in reversed(self.children) if child.text and not child.children}
        return XmlElement(self.tag, {**said, **self.attributes}, self.line, self.children, self.pieces)

    def walk(self) -> Iterator[XmlElement]:
        """Return the element and everything inside it, in the order of the file."""
        stack = [self]
        while stack:
            element = stack.pop()
            yield element
            stack.extend(reversed(element.children))


def find_root(content: bytes) -> re.Match[bytes] | None:
    """Return where the first element of an XML file begins, and its name; None if there is none."""
    return _ROOT.match(content, _after_prolog(content))


def _after_prolog(content: bytes, stop: bytes = b"") -> int:
    """Return where what stands in front of the root element ends, or where `stop` begins in it.

    Where a comment does not end, or nothing but blanks is found, that is where no element begins.
    """
    at = len(_BOM) if content.startswith(_BOM) else 0
    for _ in range(MOST_COMMENTS):
        gap = content[at : at + LONGEST_GAP]
        at += len(gap) - len(gap.lstrip())
        mark = next(((start, end) for start, end in _PROLOG if content.startswith(start, at)), None)
        if mark is None or (stop and content.startswith(stop, at)):
            return at
        close = content.find(mark[1], at + len(mark[0]))
        if close < 0:
            return at
        at = close + len(mark[1])
    return at


def _declaration_first(content: bytes, note: Note | None) -> bytes:
    """Return the text with its declaration in front of blanks and comments, which keep their lines."""
    first = len(_BOM) if content.startswith(_BOM) else 0
    at = _after_prolog(content, b"<?xml")
    close = content.find(b"?>", at)
    if at == first or close < 0 or not re.match(rb"<\?xml\s", content[at : at + 6]):
        return content
    declaration = content[at : close + 2]
    if note:
        line = content.count(b"\n", 0, at) + 1
        note(
            f"line {line}", "the declaration <?xml ...?> belongs at the very beginning; it is read as if it stood there"
        )
    kept = b"\n" * declaration.count(b"\n")
    return content[:first] + b" ".join(declaration.split()) + content[first:at] + kept + content[close + 2 :]


def _with_prefixes(content: bytes, note: Note | None) -> bytes:
    """Return the text with the prefixes declared at the root that are declared nowhere; each names itself."""
    root = find_root(content)
    if root is None:
        return content
    found: dict[bytes, int] = {}
    for match in _PREFIX.finditer(content, root.start()):
        found.setdefault(match[1], match.start(1))
    known = {match[1] for match in _DECLARED.finditer(content)}
    missing = [name for name in found if name[:3].lower() != b"xml" and name not in known]
    if not missing or len(missing) > MOST_PREFIXES:
        return content
    if note:
        for name in missing:
            line = content.count(b"\n", 0, found[name]) + 1
            what = f"the prefix {name.decode('ascii')} is declared nowhere; what it stands in front of is left aside"
            note(f"line {line}", what)
    declarations = b"".join(b' xmlns:%b="%b"' % (name, name) for name in missing)
    return content[: root.end()] + declarations + content[root.end() :]


def _parse(content: bytes, source: str) -> XmlElement:
    if not content.strip():
        raise SceneError(f"{source}: is empty; give a robot file")
    builder = _Builder()
    parser = DefusedXMLParser(target=builder, forbid_dtd=True, forbid_entities=True, forbid_external=True)
    builder.expat = parser.parser
    try:
        for start in range(0, len(content), PIECE):
            parser.feed(content[start : start + PIECE])
            if start - builder.expat.CurrentByteIndex > LONGEST_TAG:
                line = builder.expat.CurrentLineNumber
                raise _BoundError(f"line {line}: a tag is longer than {LONGEST_TAG >> 20} MB; check that it is closed")
        root = parser.close()
    except _BoundError as refusal:
        raise SceneError(f"{source}: {refusal}") from None
    except DefusedXmlException:
        line = builder.expat.CurrentLineNumber
        advice = "delete <!DOCTYPE ...> and write out what its entities stand for"
        raise SceneError(f"{source}: line {line}: a document type or an entity is not read; {advice}") from None
    except ParseError as error:
        kind = _UnboundPrefixError if error.code == UNBOUND_PREFIX else SceneError
        raise kind(f"{source}: {_place(error)}: is not well-formed XML: {_reason(error)}") from None
    except (LookupError, ValueError) as error:
        advice = "save the file as UTF-8"
        raise SceneError(f"{source}: is in an encoding that cannot be read ({shorten(str(error))}); {advice}") from None
    assert isinstance(root, XmlElement), "the parser returns what the builder closed"
    return root


class _Expat(Protocol):
    CurrentLineNumber: int
    CurrentByteIndex: int


class _UnboundPrefixError(SceneError):
    """A prefix that is declared nowhere."""


class _BoundError(Exception):
    """A file that breaks a bound."""


class _Builder:
    """What the parser tells becomes elements; `open` are the elements that have not ended."""

    expat: _Expat

    def __init__(self) -> None:
        self.root: XmlElement | None = None
        self.open: list[XmlElement] = []
        self.count = 0

    def start(self, tag: str, attributes: dict[str, str]) -> None:
        line = self.expat.CurrentLineNumber
        self.count += 1
        if len(self.open) >= DEEPEST:
            raise _BoundError(
                f"line {line}: <{shorten(tag)}> nests deeper than {DEEPEST} levels; check that tags close"
            )
        if self.count > MOST_ELEMENTS:
            raise _BoundError(f"line {line}: there are more than {MOST_ELEMENTS} elements; no robot file needs as many")
        element = XmlElement(tag, attributes, line)
        if self.open:
            self.open[-1].children.append(element)
        else:
            self.root = element
        self.open.append(element)

    def data(self, text: str) -> None:
        pieces = self.open[-1].pieces
        room = LONGEST_TEXT - sum(map(len, pieces))
        if room >= 0:
            pieces.append(text if len(text) <= room else f"{text[:room]}...")

    def end(self, tag: str) -> None:
        self.open.pop()

    def close(self) -> XmlElement | None:
        return self.root


def _place(error: ParseError) -> str:
    line, column = error.position
    return f"line {line}, column {column + 1}"


def _reason(error: ParseError) -> str:
    """Return the parser's words without the place, and what would work."""
    reason = str(error).rsplit(": line", maxsplit=1)[0]
    remedies = {
        "mismatched tag": "close every tag in the order in which they were opened",
        "no element found": "the file breaks off; is it complete?",
        "not well-formed (invalid token)": "check quotes, & (write &amp;), and that the file is saved as UTF-8 text",
        "syntax error": "does it begin with < and the name of its root, such as <robot>?",
        "unbound prefix": "declare the prefix at the root, such as xmlns:xacro=..., or delete the element",
        "junk after document element": "one root element holds everything else",
        "undefined entity": "write the character itself",
        "unclosed token": "the file breaks off inside a tag; is it complete?",
        "duplicate attribute": "give it once",
        "encoding specified in XML declaration is incorrect": "save the file as UTF-8 and declare that",
    }
    remedy = remedies.get(reason)
    return f"{reason}; {remedy}" if remedy else reason
