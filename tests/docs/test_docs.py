"""The documentation says what is so: its scripts run, its equations, keys and names exist, and it builds."""

import contextlib
import dataclasses
import importlib.util
import io
import json
import re
import subprocess
import sys
from dataclasses import dataclass
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

import myostrain as ms
from myostrain import cases
from myostrain.reproduce import chapters

import pytest

DOCS = Path(__file__).parents[2] / "docs"
PAGES = {str(path.relative_to(DOCS)): path for path in sorted(DOCS.rglob("*.md"))}

#: The paper's numbered equations: the last number of each section.
EQUATIONS = {1: 12, 2: 9, 3: 8, 4: 14, 5: 4, 7: 8}


def text(page):
    return PAGES[page].read_text(encoding="utf-8")


@dataclass
class Script:
    """A Python block of a page, and what the page says that it prints."""

    code: str
    output: str | None


def scripts(page):
    """The Python blocks of a page, each with the text block that follows it before the next."""
    blocks = re.findall(r"^```(\w+)\n(.*?)^```$", text(page), re.S | re.M)
    found = []
    for kind, content in blocks:
        if kind == "python":
            found.append(Script(content, None))
        elif kind == "text":
            found[-1].output = content
    return found


WITH_SCRIPTS = [page for page in PAGES if scripts(page)]


@pytest.mark.parametrize("page", WITH_SCRIPTS)
def test_scripts_print_what_the_page_says(page, tmp_path, monkeypatch):
    """Every Python block runs, after those above it on its page, and prints what stands below it."""
    monkeypatch.chdir(tmp_path)
    names = {"__name__": "__main__"}
    for script in scripts(page):
        out = io.StringIO()
        with contextlib.redirect_stdout(out):
            exec(compile(script.code, page, "exec"), names)
        if script.output is not None:
            assert out.getvalue() == script.output
        else:
            assert not out.getvalue(), "what is printed stands below the script"


def test_table_of_equations_is_that_of_the_paper():
    """The page of equations has each numbered equation of the paper once, and no other."""
    rows = re.findall(r"^\| (\([^|]*?\)) \|", text("model/equations.md"), re.M)
    listed = [number for row in rows for number in expanded(row)]
    assert sorted(listed) == sorted((s, n) for s, last in EQUATIONS.items() for n in range(1, last + 1))


def expanded(numbers):
    """The equations in a text such as "(1.7)–(1.10)" or "(2.1), (2.2)"."""
    for first, last in re.findall(r"\((\d\.\d+)\)(?:–\((\d\.\d+)\))?", numbers):
        section, low = map(int, first.split("."))
        end, high = map(int, (last or first).split("."))
        assert section == end
        yield from ((section, n) for n in range(low, high + 1))


def test_pages_that_the_table_of_equations_names_cite_them():
    """Where a row of the table points to a page, that page cites one of the row's equations at least."""
    for row, where in re.findall(r"^\| (\([^|]*?\)) \|[^|]*\| ([^|]*) \|$", text("model/equations.md"), re.M):
        for page in re.findall(r"\]\((.*?)\)", where):
            assert set(expanded(row)) & set(expanded(text(f"model/{page}"))), f"{row} on {page}"


@pytest.mark.parametrize("page", PAGES)
def test_cited_equations_exist(page):
    """Every equation that a page cites is one of the paper's."""
    for section, number in expanded(text(page)):
        assert 1 <= number <= EQUATIONS.get(section, 0), f"({section}.{number})"


def test_nothing_is_left_to_fill_in():
    """A page has its numbers, not the marks of a draft."""
    marks = {page: re.findall(r"@[A-Z]+\b|\b(?:TODO|TBD|FIXME|XXX)\b", text(page)) for page in PAGES}
    assert {page: found for page, found in marks.items() if found} == {}


def extension(name):
    spec = importlib.util.spec_from_file_location(name, DOCS / "extensions" / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def known_keys():
    """Keys of the case file by section, as its reference lists them."""
    found = {}
    for part in re.split(r"^## ", extension("case_reference").reference(), flags=re.M)[1:]:
        section = re.match(r"`\[(\w+)\]`", part)[1]
        names = re.findall(r"^`([\w.]+)`\n: ", part, re.M)
        found.setdefault(section, set()).update(name for name in names if "." not in name)
        for name in names:
            if "." in name:
                other, key = name.split(".")
                found.setdefault(other, set()).add(key)
    # The page explains a place once, under [initial].
    found["stimulus"] |= {field.name for field in dataclasses.fields(ms.Place)} & found["initial"]
    return found


def test_the_page_of_the_case_file_is_up_to_date():
    """It is in the repository, to be read without building anything."""
    made = extension("case_reference")
    assert made.PAGE.read_text(encoding="utf-8") == made.page(), "python docs/extensions/case_reference.py"


@pytest.mark.parametrize("name", cases.names())
def test_reference_has_every_key_of_the_shipped_cases(name):
    """The case files that ship, everything resolved, have no key that the reference does not explain."""
    known = known_keys()
    for section, content in ms.Case.from_file(cases.path(name)).parameters.items():
        if isinstance(content, dict) and section not in ("probes", "solver"):
            assert content.keys() <= known[section], section


@pytest.mark.parametrize("page", PAGES)
def test_keys_that_a_page_names_exist(page):
    """A key such as `mechanics.every`, in text or after --set, is one of the case file."""
    known = known_keys()
    for section, key in re.findall(r"(?:`|--set )(\w+)\.(\w+)(?=`| ?=)", text(page)):
        if section in known and section not in ("probes", "solver") and "(" not in key:
            members = vars(ms).get(section)
            assert key in known[section] or hasattr(members, key), f"{section}.{key}"


def test_chapters_are_those_of_the_program():
    """The page on reproducing the paper lists the chapters there are, in their order."""
    tables = "".join(part.split("\n\n")[0] for part in text("reproduce.md").split("| chapter |")[1:])
    assert re.findall(r"^\| `([\w-]+)` \|", tables, re.M) == chapters.names()
    asked = re.findall(r"myostrain reproduce ([a-z][\w-]*)", "".join(map(text, PAGES)))
    assert asked
    assert set(asked) <= {*chapters.names(), *chapters.groups()}


def test_names_that_ship_are_in_the_reference():
    """The reference has every public name: of myostrain, and the classes and functions of its folders."""
    listed = set(re.findall(r"^\.\. auto\w+:: ([\w.]+)", text("api.md"), re.M))
    listed |= {f"myostrain.{name}" for name in listed if "." not in name}
    for name in ms.__all__:
        if f"myostrain.{name}" in listed:  # of a module, autodoc lists what it exports
            continue
        members = {
            "kinematics": ["Line", "PlaneStress", "PlaneStrain", "Solid", "Kinematics", "Deformation"]
        }.get(name)
        members = members or set(getattr(ms, name).__all__) - {"readable"}  # a helper of case files
        for member in members:
            assert {f"myostrain.{name}.{member}", f"myostrain.{member}"} & listed, f"{name}.{member}"


class Resources(HTMLParser):
    """What a page loads, and what it links to."""

    def __init__(self):
        super().__init__()
        self.loaded, self.links, self.ids, self.formulas = [], [], set(), 0

    def handle_starttag(self, tag, attrs):
        given = dict(attrs)
        self.ids.add(given.get("id"))
        self.formulas += tag == "math"
        if tag in ("script", "img", "iframe", "source", "link", "embed", "object"):
            self.loaded += [given[key] for key in ("src", "href", "data") if given.get(key)]
        elif tag == "a" and given.get("href"):
            self.links.append(given["href"])


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """The site, built as `make docs` builds it, and what its pages hold."""
    pytest.importorskip("sphinx", reason="the group 'docs' of pyproject.toml is not installed")
    pytest.importorskip("myst_nb", reason="the group 'docs' of pyproject.toml is not installed")
    pytest.importorskip("furo", reason="the group 'docs' of pyproject.toml is not installed")
    folder = tmp_path_factory.mktemp("site")
    command = [sys.executable, "-m", "sphinx", "-W", "--keep-going", "-q", "-b", "html"]
    done = subprocess.run(
        [*command, "-d", folder / "trees", DOCS, folder / "html"], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    pages = {}
    for path in sorted((folder / "html").rglob("*.html")):
        pages[path] = Resources()
        pages[path].feed(path.read_text(encoding="utf-8"))
    return folder / "html", pages


def test_site_builds_and_loads_nothing_from_a_network(site):
    """`make docs` without a warning; pages, styles and scripts load from the site's own folder only."""
    folder, pages = site
    assert len(pages) > len(PAGES)
    for path, page in pages.items():
        outside = [address for address in page.loaded if urlsplit(address).netloc]
        assert not outside, path
    for style in folder.rglob("*.css"):
        content = re.sub(r"/\*.*?\*/", "", style.read_text(encoding="utf-8"), flags=re.S)
        assert not re.search(r"(url\(|@import)\s*[\"']?(https?:)?//", content), style


def test_formulas_are_mathml(site):
    """A page with formulas has as many MathML elements, and no LaTeX is left in it."""
    folder, pages = site
    for name, source in PAGES.items():
        content = re.sub(r"^```.*?^```$", "", source.read_text(encoding="utf-8"), flags=re.S | re.M)
        content = re.sub(r"`[^`]*`", "", content)
        page = folder / name.replace(".md", ".html")
        written = len(re.findall(r"\$\$.+?\$\$|\$[^$]+?\$", content, re.S))
        assert pages[page].formulas >= written, name  # those of headings are in the side bar once more
        assert not re.search(r"\\(frac|mathbf|partial|beta)", page.read_text(encoding="utf-8")), name


def test_links_within_the_site_lead_somewhere(site):
    """Links to other pages and to places on them exist; of pages of source, which lead back, the pages do."""
    folder, pages = site
    for path, page in pages.items():
        for link in page.links:
            parts = urlsplit(link)
            if parts.netloc or parts.scheme:
                continue
            target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            assert target.exists(), f"{link} on {path.relative_to(folder)}"
            if parts.fragment and target in pages and "_modules" not in path.parts:
                assert unquote(parts.fragment) in pages[target].ids, f"{link} on {path.relative_to(folder)}"


@pytest.mark.parametrize("page", PAGES)
def test_lines_of_code_fit(page):
    """No line is cut off at 1280 pixels, where a block holds 110 characters (``_static/formulas.css``)."""
    for block in re.findall(r"^```(?!text)\w+\n(.*?)^```$", text(page), re.S | re.M):
        assert [line for line in block.splitlines() if len(line) > 110] == []


def test_names_of_the_reference_lead_to_their_source(site):
    folder, _ = site
    assert 'href="_modules/myostrain/run/simulation.html#Simulation"' in (folder / "api.html").read_text()
    source = (folder / "_modules" / "myostrain" / "run" / "simulation.html").read_text(encoding="utf-8")
    assert 'id="Simulation"' in source


def test_the_search_has_excerpts_without_a_server(site):
    """Its page loads the text of every page, as a browser fetches none of a site that is opened as files."""
    folder, _ = site
    assert "search_texts.js" in (folder / "search.html").read_text(encoding="utf-8")
    script = (folder / "_static" / "search_texts.js").read_text(encoding="utf-8")
    texts = json.loads(script.split("const TEXTS = ", 1)[1].split(";\nconst fetched", 1)[0])
    assert set(texts) >= {name.replace(".md", ".html") for name in PAGES}
    assert "checkpoint" in texts["howto/resume.html"]
    assert "¶" not in texts["glossary.html"]
    assert not [name for name in texts if name.startswith("_modules")]
    assert all('role="main"' in texts[name.replace(".md", ".html")] for name in PAGES)
