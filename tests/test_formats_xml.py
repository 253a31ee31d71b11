"""XML that means harm, or is none, ends in one clear line, soon and in little memory."""

import inspect
import re
import tracemalloc
from pathlib import Path

import pytest

from symdyn.errors import SceneError
from symdyn.scene import read
from symdyn.scene.formats import xml
from symdyn.scene.formats.xml import XmlElement

BOMB = b"""<?xml version="1.0"?>
<!DOCTYPE robot [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;&a;&a;"><!ENTITY c "&b;&b;&b;&b;&b;&b;">]>
<robot name="&c;"/>"""


def refusal(content: bytes) -> str:
    with pytest.raises(SceneError, match=r"robot\.urdf: ") as caught:
        XmlElement.parse(content, "robot.urdf")
    assert len(caught.value.faults) == 1
    assert "\n" not in str(caught.value)
    return str(caught.value)


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (BOMB, "line 2: a document type or an entity is not read; delete <!DOCTYPE"),
        (b'<!DOCTYPE robot SYSTEM "file:///etc/passwd"><robot/>', "document type"),
        (b'<!DOCTYPE r [<!ENTITY x SYSTEM "http://localhost/x">]><r a="&x;"/>', "document type"),
        (b'<r a="&x;"/>', "undefined entity; write the character itself"),
        (b"<a>" * 1_000_000, "line 1: <a> nests deeper than 200 levels; check that tags close"),
        (b"<a b='" + b"x" * 3_000_000 + b"'/>", "a tag is longer than 1 MB; check that it is closed"),
        (b"<a " + b" ".join(b"a%d=''" % k for k in range(300_000)) + b"/>", "a tag is longer than 1 MB"),
        (b"<" + b"a" * 3_000_000 + b"/>", "a tag is longer than 1 MB"),
        (b" " * (xml.LARGEST_FILE + 1), "holds more than 32 MB"),
        (b"", "is empty; give a robot file"),
        (b" \n ", "is empty"),
        (b"hello", "line 1, column 1: is not well-formed XML: syntax error; does it begin with <"),
        (bytes(range(256)), "save|saved"),
        (b"\x00" * 1000, "is not well-formed XML"),
        (b"PK\x03\x04" + bytes(100), "is not well-formed XML"),
        (b"<a>\n<b>\n</c></a>", "line 3, column 3: is not well-formed XML: mismatched tag; close every tag"),
        (b"<a>", "the file breaks off; is it complete?"),
        (b'<a b="x', "the file breaks off inside a tag"),
        (b"<a/><b/>", "one root element holds everything else"),
        (b'<a b="1" b="2"/>', "duplicate attribute; give it once"),
        (b'<a><b xmlns:p="x"/><p:c/></a>', "unbound prefix; declare the prefix at the root"),
        (b"<a>" + b"".join(b"<p%d:b/>" % k for k in range(60)) + b"</a>", "unbound prefix; declare the prefix"),
        ('<?xml version="1.0" encoding="utf-8"?><r n="ä"/>'.encode("latin-1"), "saved as UTF-8 text"),
        (b'<?xml version="1.0" encoding="utf-16"?><r/>', "save the file as UTF-8"),
        (b'<?xml version="1.0" encoding="shift_jis"?><r/>', "encoding that cannot be read .*; save the file as UTF-8"),
        (b'<?xml version="1.0" encoding="nonsense"?><r/>', "encoding that cannot be read .*nonsense"),
        (b'<?xml version="1.0" encoding="rot13"?><r/>', "encoding that cannot be read"),
    ],
    ids=range(27),
)
def test_what_is_no_harmless_xml_is_one_line(content, words):
    assert re.search(words, refusal(content))


def test_a_file_of_many_elements_is_refused_before_it_fills_the_memory(monkeypatch):
    monkeypatch.setattr(xml, "MOST_ELEMENTS", 1000)

    assert "line 1: there are more than 1000 elements" in refusal(b"<a>" + b"<b/>" * 1000 + b"</a>")


def test_long_text_between_tags_is_cut_and_takes_no_memory():
    content = b"<a>" + b"x" * 8_000_000 + b"</a>"
    tracemalloc.start()
    root = XmlElement.parse(content, "robot.urdf")
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()

    assert root.children == []
    assert root.text == "x" * xml.LONGEST_TEXT + "..."
    assert peak < 4_000_000


def test_deep_nesting_takes_no_memory_and_no_recursion():
    content = b"<a>" * 3_000_000
    tracemalloc.start()
    refusal(content)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()

    assert peak < 4_000_000


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "latin-1", "ascii"])
def test_encodings_that_are_declared_are_read(encoding):
    declared = encoding.removesuffix("-sig")
    text = f'<?xml version="1.0" encoding="{declared}"?><r name="{"arm" if encoding == "ascii" else "Rückgrat"}"/>'

    assert XmlElement.parse(text.encode(encoding), "robot.urdf").attributes["name"] in ("Rückgrat", "arm")


def test_elements_know_their_lines_and_come_in_order():
    root = XmlElement.parse(
        (b'<robot>\n <link name="a"/>\n <joint/>\n <link name="b"><link name="c"/></link></robot>'), "x"
    )

    assert [(e.tag, e.line) for e in root.walk()] == [("robot", 1), ("link", 2), ("joint", 3), ("link", 4), ("link", 4)]
    assert [e.attributes["name"] for e in root.all("link")] == ["a", "b"]
    assert root.first("joint") is root.children[1]
    assert root.first("nothing") is None
    assert isinstance(root, XmlElement)


def test_files_that_cannot_be_opened_say_why(tmp_path: Path):
    with pytest.raises(SceneError, match=r"none\.urdf: there is no such file; check the path"):
        XmlElement.read(tmp_path / "none.urdf")
    with pytest.raises(SceneError, match="is a folder; give a file"):
        XmlElement.read(tmp_path)
    with pytest.raises(SceneError, match="cannot be read"):
        XmlElement.read(Path("nul\0name.urdf"))


@pytest.mark.mends("4.prefix")
def test_a_prefix_that_is_declared_nowhere_is_read_with_a_note():
    """Such files come with real robots, and other readers take the prefix for a part of the name."""
    text = b'<robot name="a:b c:d">\n <gazebo:plugin ns:x="1"/>\n <!-- k:l --><link name="m:n"/></robot>'
    told: list[str] = []
    root = _parse_telling(text, told)

    assert [child.tag for child in root.children] == ["{gazebo}plugin", "link"]
    assert [line.split(" is declared")[0] for line in told if "nowhere" in line] == [
        "line 2: the prefix gazebo", "line 2: the prefix ns",
    ]  # fmt: skip


@pytest.mark.mends("4.prefix")
def test_a_macro_behind_an_undeclared_prefix_is_still_a_macro(tmp_path):
    (tmp_path / "r.urdf").write_text('<robot name="r"><xacro:arm/></robot>')
    with pytest.raises(SceneError, match="run xacro first"):
        read(tmp_path / "r.urdf")


@pytest.mark.mends("4.declaration")
@pytest.mark.parametrize(
    ("start", "encoding"), [("\n", "latin-1"), ("<!-- by hand -->\n", "utf-8"), ("\ufeff\n", "utf-8")]
)
def test_a_declaration_that_is_not_first_is_read_with_a_note(start, encoding):
    text = f'{start}<?xml version="1.0"\n encoding="{encoding}"?>\n<robot name="Rückgrat"><link/></robot>'
    told: list[str] = []
    root = _parse_telling(text.encode(encoding), told)

    assert root.attributes["name"] == "Rückgrat"
    assert root.line == 4
    assert [line.split(" belongs at")[0] for line in told] == ["line 2: the declaration <?xml ...?>"]


@pytest.mark.parametrize("text", [b"<!---->" * 200_000 + b"<?xml version='1.0'?><a/>", b"<?xml" * 100_000, b"<?xml?>"])
def test_what_stands_in_front_of_the_root_is_not_searched_for_ever(text):
    assert "is not well-formed XML" in refusal(text)


def _parse_telling(text: bytes, told: list[str]) -> XmlElement:
    """Return the root; the notes go into `told`, where the reader has any."""
    parameters = inspect.signature(XmlElement.parse).parameters
    more = {"note": lambda where, what: told.append(f"{where}: {what}")} if "note" in parameters else {}
    return XmlElement.parse(text, "robot.urdf", **more)
