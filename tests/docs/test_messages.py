"""The page on messages quotes messages that the program has."""

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "troubleshooting.md").read_text(encoding="utf-8")
QUOTED = re.findall(r"^`([^`]+)`\n: ", PAGE, re.M)

#: What stands for a value that a message takes in.
HOLE = "\0"


def template(node):
    """A string of the source, with a hole for each value; None of another node."""
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        return re.sub(r"%[-+.\d]*[a-z]", HOLE, node.value)
    if isinstance(node, ast.JoinedStr):
        parts = (part.value if isinstance(part, ast.Constant) else HOLE for part in node.values)
        return "".join(map(str, parts))
    return None


@pytest.fixture(scope="module")
def templates():
    """Every string of the source."""
    found = set()
    for path in (ROOT / "src" / "myostrain").rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if (text := template(node)) is not None:
                found.add(text)
    return found


def test_page_quotes_the_most_likely_messages():
    """Twenty at least, none twice."""
    assert len(QUOTED) >= 20
    assert len(set(QUOTED)) == len(QUOTED)


@pytest.mark.parametrize("message", QUOTED)
def test_quoted_message_is_in_the_source(message, templates):
    """Its fixed parts stand in one string of the source, with values where it has an ellipsis."""
    assert len(message.replace("…", "").strip()) > 8, "too little to find it by"
    pattern = re.compile(re.escape(message).replace("…", f".*{HOLE}.*"), re.S)
    assert any(map(pattern.search, templates)), message
