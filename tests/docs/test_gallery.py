"""The gallery's commands are the program's, its examples are many, and its pictures are small."""

import importlib.util
import re
import shlex
from pathlib import Path

from myostrain import cases
from myostrain.cli import app

import typer

DOCS = Path(__file__).parents[2] / "docs"
PAGE = (DOCS / "gallery.md").read_text(encoding="utf-8")
EXAMPLES = dict(re.findall(r"^### (.*?)\n(.*?)(?=^##|\Z)", PAGE, re.S | re.M))


def test_examples_are_many_and_each_is_short():
    """Twenty at least; each is one block of a few lines, or one command."""
    assert len(EXAMPLES) >= 20
    for name, content in EXAMPLES.items():
        blocks = re.findall(r"^```(?:python|py|sh)\n(.*?)^```$", content, re.S | re.M)
        assert len(blocks) == 1, name
        assert len(blocks[0].splitlines()) <= 24, name


def test_commands_are_those_of_the_program():
    """Every command, option and case of the page exists."""
    commands = typer.main.get_command(app).commands
    asked = re.findall(r"^(?:mpiexec -n \d+ )?myostrain (.*)$", PAGE, re.M)
    assert len(asked) >= 6
    for line in asked:
        name, *words = shlex.split(line)
        options = {option for given in commands[name].params for option in given.opts}
        assert {word for word in words if word.startswith("--")} <= options, line
        if name in ("run", "sweep") and not words[0].startswith("-"):
            assert words[0] in cases.names(), line


def test_pictures_are_many_and_small():
    """Of twenty examples at least; 60 kB each at most, so that the page loads at once."""
    shown = re.findall(r"!\[.+?\]\((.+?)\)", PAGE)
    assert len(set(shown)) >= 20
    assert all((DOCS / path).stat().st_size <= 60_000 for path in shown)


def test_pictures_are_those_of_the_examples():
    """What the script draws stands with the example whose name it bears, and no picture is left over."""
    spec = importlib.util.spec_from_file_location("gallery", DOCS / "extensions" / "gallery_pictures.py")
    pictures = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(pictures)
    for title in pictures.DRAWN:
        assert f"](images/{pictures.name_of(title)})" in EXAMPLES[title], title
    made = {path.name for path in (DOCS / "images").glob("gallery-*.png")}
    assert made == set(map(pictures.name_of, pictures.DRAWN))
