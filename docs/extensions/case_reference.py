"""The reference of the case file, made of the classes that check it.

    python docs/extensions/case_reference.py     # writes it into docs/howto/case-file.md

A test compares the page with the classes.
"""

import dataclasses
import inspect
import re
import typing
from pathlib import Path

from myostrain import activation
from myostrain.case import sections as case
from myostrain.electrics import given_potential as drive
from myostrain.electrics import initial_values, place, potential, stimulus, stretch_current, variation
from myostrain.mechanics import bestel_2001_pressure, imposed_stretch, support_factors
from myostrain.mechanics import equilibrium as mechanics
from myostrain.output import tips
from myostrain.run import simulation
from myostrain.type_words import in_words

PAGE = Path(__file__).parents[1] / "howto" / "case-file.md"
PLACE = "<!-- made by docs/extensions/case_reference.py, from here on -->\n"

#: Where the meaning of a section's keys is written, if not at the section itself.
MEANINGS = {
    case.PotentialSection: [potential.Potential],
    case.MechanicsSection: [mechanics.Mechanics, mechanics.Supports, mechanics.Loads],
    case.TimeSection: [simulation.Simulation],
}

PROBES = """
`NAME = [x, ...]`: a material point, with a name that you choose; its activation time goes into
`results.json`, its values into `probes.csv`. The celerity is taken between the first two.
""".strip()

ELECTRODES = """
`NAME = [x, y, z]`: a point in space outside the body, with a name that you choose. `ecg.csv` has the
[potential](../results.md#electrodes) there over time.
""".strip()

#: Where more is to be said than whether the section must be there.
NEEDED = {
    "initial": "This section or `[[stimulus]]` is required, unless there is `[drive]`. For several, write "
    "`[[initial]]`; later ones win.",
    "stimulus": "This section may be left out. For several, write `[[stimulus]]`; they add up.",
    "drive": "This section may take the place of `[cell]`, `[potential]` and `[initial]`.",
}

VARIATION = """
Parameters of the membrane are keys of the table, such as `g_Ks = 0.1`; `parameters` is for those of a file
that are named like other keys. The place has the same keys as that of `[initial]`, except `sampling`.
""".strip()

SOLVER = """
`[solver.potential]` and `[solver.mechanics]` hold options of PETSc's linear solvers without a prefix, such as
`ksp_type`, `pc_type` or `ksp_rtol`. They override the defaults. An option that does not choose or tune a
solver is refused, as it may run code or write files; `ksp_monitor`, `ksp_view` and
`ksp_converged_reason = true` print.
""".strip()


def reference() -> str:
    """The reference as Markdown, one heading per section."""
    sections = {
        "units": [keys(case.UnitsSection, intro=True)],
        "geometry": [choice("kind", case.GEOMETRIES), *variants("kind", case.GEOMETRIES)],
        "fibres": [choice("kind", case.FIBRES, "uniform"), *variants("kind", case.FIBRES)],
        "cell": [
            choice("model", case.CELLS, "FitzHughNagumo"),
            keys(case.CellSection),
            "### `stretch_current = { ... }`",
            keys(stretch_current.StretchCurrent, intro=True, without=("where",)),
            "It may have the keys of a place, those of `[initial]`. For several: `[[cell.stretch_current]]`.",
            *variants("model", case.CELLS),
            "### `[[cell.variation]]`",
            keys(variation.Variation, intro=True, without=("where",)),
            VARIATION,
        ],
        "potential": [keys(case.PotentialSection)],
        "initial": [
            keys(initial_values.InitialValues, intro=True, without=("where",)),
            "### Where",
            keys(place.Place, intro=True),
        ],
        "stimulus": [
            keys(stimulus.Stimulus, intro=True, without=("where",)),
            "The place has the same keys as that of `[initial]`.",
        ],
        "drive": [keys(drive.Drive, intro=True)],
        "activation": [
            choice("law", case.LAWS, "proportional"),
            choice("deformation", case.DEFORMATIONS, "fibre"),
            *variants("law", case.LAWS),
            "### With a law that yields a tension",
            keys(activation.FibreTension, intro=True),
            *variants("deformation", case.DEFORMATIONS),
            "### For all laws",
            keys(case.TransmuralSection),
        ],
        "material": [
            choice("model", case.MATERIALS, "Spring on a line, else NeoHookean"),
            *variants("model", case.MATERIALS),
        ],
        "mechanics": [
            choice("kinematics", case.KINEMATICS),
            *variants("kinematics", case.KINEMATICS),
            "### Keys for all kinematics",
            keys(case.MechanicsSection),
            "### `imposed_stretch = { ... }`",
            keys(imposed_stretch.ImposedStretch, intro=True),
            "### `support_factor = { PART = { ... } }`",
            keys(support_factors.SupportProfile, intro=True),
            "### `pressure = { PART = { ... } }`",
            keys(bestel_2001_pressure.Bestel2001Pressure, intro=True),
        ],
        "circulation": [
            choice("kind", case.CIRCULATIONS),
            keys(case.CirculationSection, intro=True),
            *variants("kind", case.CIRCULATIONS, without=("cavities",)),
        ],
        "time": [
            keys(case.TimeSection),
            choice("scheme", case.SCHEMES, "second-order"),
            *variants("scheme", case.SCHEMES, moved={"every": "mechanics.every"}),
        ],
        "probes": [PROBES],
        "electrodes": [ELECTRODES],
        "output": [
            keys(case.OutputSection),
            "### `tip = { ... }`",
            keys(tips.Tip, intro=True),
        ],
        "solver": [SOLVER],
    }
    assert sections.keys() == case.SECTIONS.keys()
    texts = ", ".join(f"`{key}`" for key in case.TEXTS)
    parts = [f"Before the sections, a case may have the texts {texts}."]
    for name, content in sections.items():
        needed = "is required" if case.SECTIONS[name] else "may be left out"
        parts += [f"## `[{name}]`", NEEDED.get(name, f"This section {needed}."), *content]
    return "\n\n".join(parts)


def choice(key, choices, default=None):
    words = " or ".join(f'`"{word}"`' for word in choices)
    usual = "required" if default is None else f"default {default if ' ' in default else quoted(default)}"
    return f"`{key}`\n: {words}; {usual}."


def variants(key, choices, moved=None, without=()):
    for word, cls in choices.items():
        yield f'### `{key} = "{word}"`'
        yield keys(cls, intro=True, moved=moved, without=without)


def keys(cls, *, intro=False, moved=None, without=()):
    """The keys of a class: type, default, meaning; but for some."""
    parts = [summary(cls)] if intro else []
    hints = typing.get_type_hints(cls, include_extras=True)
    meanings = {}
    for described in (*MEANINGS.get(cls, []), cls):
        meanings |= arguments(described)
    fields = [field for field in dataclasses.fields(cls) if field.name not in without]
    for field in fields:
        meaning = meanings[field.name]
        name = (moved or {}).get(field.name, field.name)
        required = field.default is dataclasses.MISSING and field.default_factory is dataclasses.MISSING
        default = field.default
        if field.default_factory is not dataclasses.MISSING:
            default = field.default_factory()
        usual = "required" if required else f"default {value(default)}"
        if not required and field.default is None:
            usual = "may be left out"
        parts.append(f"`{name}`\n: {marked(in_words(hints[field.name]))}; {usual}.\\\n  {meaning}")
    return "\n\n".join(parts) if fields else "\n\n".join([*parts, "It has no keys of its own."])


def marked(words):
    """Words with what is quoted as code."""
    return re.sub(r'("[^"]*")', r"`\1`", words)


def value(default):
    if isinstance(default, bool):
        return f"`{str(default).lower()}`"
    if isinstance(default, str):
        return quoted(default)
    if isinstance(default, tuple):
        return f"`{list(default)}`".replace("'", '"')
    return f"`{default}`"


def quoted(word):
    return f'`"{word}"`'


def summary(cls):
    """A docstring up to its list of arguments, as Markdown."""
    text = re.split(r"\n\s*(?:Args|Attributes|Raises|Returns):", inspect.getdoc(cls))[0]
    text = re.sub(r"^\[\w+\](?: but for [^:.]*)?[:.]\s*(\w)", lambda found: found[1].upper(), text)
    return tables(markdown(text))


def tables(text):
    """The simple tables of docstrings as those of Markdown: columns where the rules of = are."""
    rule = r"=+(?: +=+)+"
    return re.sub(rf"^({rule})\n(.+\n){rule}\n((?:.+\n)+?){rule}$", table, text, flags=re.M)


def table(found):
    starts = [part.start() for part in re.finditer("=+", found[1])]
    ends = [*starts[1:], None]
    rows = [
        [" ".join(line[start:end].split()) for start, end in zip(starts, ends, strict=True)]
        for line in (found[2] + found[3]).splitlines()
    ]
    rows.insert(1, ["---"] * len(starts))
    return "\n".join(f"| {' | '.join(row)} |" for row in rows)


def arguments(cls):
    """The arguments that a docstring in Google style explains, by name."""
    text = inspect.getdoc(cls) if cls else ""
    block = re.search(r"^Args:\n(.*?)(?=^\S|\Z)", text, re.MULTILINE | re.DOTALL)
    if block is None:
        return {}
    found = re.findall(r"^ {4}(\w+): (.*?)(?=^ {4}\w|\Z)", block[1], re.MULTILINE | re.DOTALL)
    return {name: markdown(" ".join(meaning.split())) for name, meaning in found}


def markdown(text):
    """The little mark-up of docstrings as Markdown."""
    text = re.sub(r":\w+:`~?\.?(.*?)`", r"`\1`", text)
    text = text.replace("``", "`")
    return re.sub(r"(?<![`*])(<|\*(?!\*))(?!`)", r"\\\1", text)  # but for **bold**


def page():
    """The whole page, with the reference as it should be."""
    return PAGE.read_text(encoding="utf-8").partition(PLACE)[0] + PLACE + "\n" + reference() + "\n"


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
