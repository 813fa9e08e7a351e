"""A case file (TOML) and the objects that it describes; every message names a key to act on."""

from __future__ import annotations

import dataclasses
import re
import tomllib
import typing
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from myostrain import activation, cells, geometry, kinematics, materials, sizes
from myostrain.coupling import Electromechanics, Implicit, SecondOrder, Staggered
from myostrain.engine import MPI
from myostrain.errors import InputError, nearest
from myostrain.initial import Bump
from myostrain.mechanics import ImposedStretch, Mechanics
from myostrain.output.fields import FieldName
from myostrain.overrides import override
from myostrain.potential import Balance, Mass, Potential
from myostrain.simulation import CHECKPOINT_SECONDS, Simulation
from myostrain.validation import Finite, Flag, NonNegative, Positive, description

import pydantic
import tomlkit

GEOMETRIES = {
    "line": geometry.Line,
    "rectangle": geometry.Rectangle,
    "ellipse": geometry.Ellipse,
    "file": geometry.MeshFile,
}
KINEMATICS = {
    "line": kinematics.Line,
    "plane-stress": kinematics.PlaneStress,
    "plane-strain": kinematics.PlaneStrain,
}


def _exported(module: Any, method: str) -> dict[str, Any]:
    """The descriptions that a folder exports and that have this method, by name."""
    classes = {name: getattr(module, name) for name in module.__all__}
    return {name: c for name, c in classes.items() if dataclasses.is_dataclass(c) and hasattr(c, method)}


LAWS = {name.lower(): law for name, law in _exported(activation, "gamma").items()}
DEFORMATIONS = {name.lower(): deformation for name, deformation in _exported(activation, "tensor").items()}
CELLS = _exported(cells, "current")
MATERIALS = _exported(materials, "energy")
SCHEMES = {"implicit": Implicit, "staggered": Staggered, "second-order": SecondOrder}


@description
class PotentialSection:
    """[potential]: diffusivity, one number or [along, across] the fibre; balance."""

    diffusivity: Positive | tuple[Positive, Positive] = 100.0
    balance: Balance = "conservative"
    mass: Mass = "lumped"


@description
class MechanicsSection:
    """[mechanics] but for the kinematics and its constraint, and ``every``, which is the scheme's."""

    robin: NonNegative = 0.0
    robin_boundary: tuple[str, ...] | None = None
    fixed: tuple[str, ...] = ()
    relaxation_time: NonNegative = 0.0
    imposed_stretch: ImposedStretch | None = None
    tolerance: Positive = 1e-7


@description
class TimeSection:
    """[time] but for the scheme: time step and end."""

    step: Positive
    end: Positive


@description
class OutputSection:
    """[output]: what is written and when.

    Args:
        every: Simulated time between written fields; a sixtieth of the run unless given.
        fields: Which fields.
        rigid_twin: Whether the same case is run on the rigid body too, for comparison.
        checkpoint_every: Simulated time between checkpoints; none by simulated time unless given.
        checkpoint_seconds: Seconds of wall clock between checkpoints.
    """

    every: Positive | None = None
    fields: tuple[FieldName, ...] = ("potential", "states", "displacement", "stress_trace")
    rigid_twin: Flag = False
    checkpoint_every: Positive | None = None
    checkpoint_seconds: Positive = CHECKPOINT_SECONDS


#: Sections of a case file, and whether they must be there.
SECTIONS = {
    "geometry": True,
    "fibres": False,
    "cell": False,
    "potential": False,
    "initial": True,
    "activation": False,
    "material": False,
    "mechanics": True,
    "time": True,
    "probes": False,
    "output": False,
    "solver": False,
}
TEXTS = ("name", "title", "cost")

#: Bytes of a case file at most: a larger one is something else.
MAX_FILE = 1_000_000


@dataclasses.dataclass(frozen=True)
class Case:
    """A case, checked: frozen descriptions, and from them the objects that run.

    Args:
        name: Short name, for the record.
        parameters: The case as a dictionary with everything resolved, as ``case.toml`` holds it.
    """

    name: str
    title: str
    cost: str
    geometry: Any
    fibres: geometry.UniformFibres | None
    cell: Any
    potential: PotentialSection
    initial: Bump
    law: Any
    deformation: Any
    material: Any
    kinematics: Any
    mechanics: MechanicsSection
    scheme: Any
    time: TimeSection
    probes: Mapping[str, tuple[float, ...]]
    output: OutputSection
    solver: Mapping[str, Mapping[str, Any]]
    parameters: Mapping[str, Any]

    @classmethod
    def from_file(cls, path: str | Path, overrides: Sequence[str] = ()) -> Case:
        """Read a case file.

        Args:
            path: The TOML file; paths in it are relative to its folder.
            overrides: ``KEY=VALUE`` with dotted keys and values in TOML syntax; paths in them are relative to
                the current folder.

        Raises:
            InputError: The file cannot be read, is no TOML, or says what cannot be.
        """
        path = Path(path)
        geometry.readable(path, "FILE")
        try:
            if path.stat().st_size > MAX_FILE:
                raise InputError(f"{path} is larger than {MAX_FILE} bytes: it is no case file")
            data = tomllib.loads(path.read_text(encoding="utf-8"))
        except InputError:
            raise
        except ValueError as error:  # of TOML, of UTF-8, and of integers that are too long
            raise InputError(f"{path} is no valid TOML file: {error}") from error
        except RecursionError:
            raise InputError(f"{path} is no case: its lists or tables are too deep") from None
        except OSError as error:
            raise InputError(f"{path} cannot be read: {error.strerror}") from error
        if not data:
            raise InputError(f"{path} holds no case: it has no section")
        form = data.get("geometry")
        if isinstance(form, dict) and isinstance(form.get("path"), str):
            form["path"] = str(path.parent.absolute() / form["path"])
        override(data, overrides)
        return cls.from_dict(data, name=path.stem)

    @classmethod
    def from_dict(cls, data: Mapping[str, Any], name: str = "case", folder: Path = Path()) -> Case:
        """Check a case given as nested dictionaries, with the keys of a case file.

        Raises:
            InputError: A key is unknown or missing, or a value is not allowed.
        """
        unknown = [key for key in data if key not in (*SECTIONS, *TEXTS)]
        if unknown:
            raise InputError(
                f"no such section or key; {nearest(unknown[0], (*SECTIONS, *TEXTS))}", _dotted(unknown[0])
            )
        for section, needed in SECTIONS.items():
            if needed and section not in data:
                raise InputError("this section is missing", section)
            if not isinstance(data.get(section, {}), Mapping):
                raise InputError(f"this is a section, not a value: [{section}]", section)
        for key in TEXTS:
            if not isinstance(data.get(key, ""), str):
                raise InputError("give a text", key)
        if not re.fullmatch(r"[^/\\\x00-\x1f]{1,100}", data.get("name", "-")) or data.get("name") in (
            ".",
            "..",
        ):
            raise InputError(
                f"a result folder is called by it: give a short word, not {_shown(data['name'])}", "name"
            )
        part = {section: dict(data.get(section, {})) for section in SECTIONS}

        form = _pick(part["geometry"], "geometry.kind", GEOMETRIES)
        kin = _pick(part["mechanics"], "mechanics.kinematics", KINEMATICS)
        line = kin is kinematics.Line
        model = _pick(part["cell"], "cell.model", CELLS, "FitzHughNagumo")
        law = _pick(part["activation"], "activation.law", LAWS, "proportional")
        active = _pick(part["activation"], "activation.deformation", DEFORMATIONS, "fibre")
        material = _pick(part["material"], "material.model", MATERIALS, "Spring" if line else "NeoHookean")
        scheme = _pick(part["time"], "time.scheme", SCHEMES, "second-order")

        if form is geometry.MeshFile and isinstance(part["geometry"].get("path"), str):
            part["geometry"]["path"] = _whole(folder, part["geometry"]["path"])
        constraint = {k: part["mechanics"].pop(k) for k in ("constraint",) if k in part["mechanics"]}
        if line and constraint:
            if constraint["constraint"] != "total":
                raise InputError("a line has no constraint; leave the key out", "mechanics.constraint")
            constraint = {}
        pace = {k: part["mechanics"].pop(k) for k in ("every",) if k in part["mechanics"]}
        if scheme is Implicit and pace:
            if pace["every"] != 1:
                raise InputError(
                    'the implicit scheme solves mechanics in every step: give 1, or scheme = "staggered"',
                    "mechanics.every",
                )
            pace = {}
        if "every" in part["time"]:
            raise InputError("this key is called mechanics.every", "time.every")
        timing = {k: part["time"].pop(k) for k in ("step", "end") if k in part["time"]}
        made = {
            "geometry": _make(form, part["geometry"], "geometry", also=("kind",)),
            "fibres": _make(geometry.UniformFibres, part["fibres"], "fibres") if part["fibres"] else None,
            "cell": _make(model, part["cell"], "cell", also=("model",)),
            "potential": _make(PotentialSection, part["potential"], "potential"),
            "initial": _make(Bump, part["initial"], "initial"),
            "law": _make(law, part["activation"], "activation", also=("law", "deformation")),
            "deformation": _make(active, {}, "activation"),
            "material": _make(material, part["material"], "material", also=("model",)),
            "mechanics": _make(
                MechanicsSection, part["mechanics"], "mechanics", also=("kinematics", "constraint", "every")
            ),
            "kinematics": _make(kin, constraint, "mechanics"),
            "scheme": _make(
                scheme,
                {**part["time"], **pace},
                "time",
                also=("scheme", "step", "end"),
                sections={"every": "mechanics"},
            ),
            "time": _make(TimeSection, timing, "time"),
            "probes": _make_probes(part["probes"]),
            "output": _make(OutputSection, part["output"], "output"),
            "solver": _make_solver(part["solver"]),
        }
        texts = {"name": data.get("name", name)}
        texts |= {"title": data.get("title", texts["name"]), "cost": data.get("cost", "")}
        return cls(**texts, **made, parameters=_resolved(texts, made))

    def rigid(self) -> Case:
        """The same case on a body that does not move."""
        held = ImposedStretch(value=1.0, until=float("inf"))
        mechanics = dataclasses.replace(self.mechanics, imposed_stretch=held)
        output = dataclasses.replace(self.output, rigid_twin=False)
        made = {f.name: getattr(self, f.name) for f in dataclasses.fields(self)}
        texts = {"name": f"{self.name}-rigid", "title": f"{self.title}, rigid", "cost": self.cost}
        made |= {"mechanics": mechanics, "output": output, **texts}
        return Case(**{**made, "parameters": _resolved(texts, made)})

    def to_toml(self) -> str:
        """The case as TOML with everything resolved; :meth:`from_file` reads it back."""
        return tomlkit.dumps(dict(self.parameters))

    def build(self, comm: Any = MPI.COMM_WORLD) -> Electromechanics:
        """Make the coupled problem, with the initial potential set.

        Raises:
            InputError: What only shows on the mesh: a boundary that is not there, a bump without a node, ...
        """
        body = geometry.build(self.geometry, self.fibres, comm)
        mechanics = Mechanics(
            body,
            kinematics=self.kinematics,
            material=self.material,
            law=self.law,
            deformation=self.deformation,
            robin=self.mechanics.robin,
            robin_boundary=self.mechanics.robin_boundary,
            fixed=self.mechanics.fixed,
            relaxation_time=self.mechanics.relaxation_time,
            imposed_stretch=self.mechanics.imposed_stretch,
            tolerance=self.mechanics.tolerance,
            options=self.solver.get("mechanics"),
        )
        potential = Potential(
            body,
            cell=self.cell,
            diffusivity=self.potential.diffusivity,
            balance=self.potential.balance,
            mass=self.potential.mass,
            deformation=mechanics.deformation,
            options=self.solver.get("potential"),
        )
        self.initial.apply(potential)
        return Electromechanics(potential, mechanics, self.scheme)

    def simulation(
        self,
        comm: Any = MPI.COMM_WORLD,
        out: Path | None = None,
        force: bool = False,
        resume: bool = False,
    ) -> Simulation:
        """Build the model and the simulation that runs it.

        Raises:
            InputError: It would not fit into memory or on the disk, or see :meth:`build`.
        """
        import time

        begin = time.perf_counter()
        sizes.check(self, out, comm)
        model = self.build(comm)
        return Simulation(
            model,
            step=self.time.step,
            end=self.time.end,
            out=out,
            probes=self.probes,
            every=None if self.output.every is None else min(self.output.every, self.time.end),
            fields=self.output.fields,
            checkpoint_every=self.output.checkpoint_every,
            checkpoint_seconds=self.output.checkpoint_seconds,
            force=force,
            resume=resume,
            case={"name": self.name, "parameters": self.parameters},
            setup_seconds=time.perf_counter() - begin,
        )


def _pick(section: dict[str, Any], key: str, choices: Mapping[str, Any], default: str | None = None) -> Any:
    """Take the word that chooses a class out of a section."""
    word = section.pop(key.split(".")[1], default)
    if word is None:
        raise InputError(f"missing; allowed: {', '.join(choices)}", key)
    if not isinstance(word, str) or word not in choices:
        raise InputError(f"{_shown(word)} is not known here; {nearest(_shown(word), choices)}", key)
    return choices[word]


def _make(
    cls: Any,
    values: Mapping[str, Any],
    section: str,
    also: Sequence[str] = (),
    sections: Mapping[str, str] | None = None,
) -> Any:
    """Make a description from a section; errors name the key.

    Args:
        cls: The class.
        values: Its values.
        section: Name of the section.
        also: Keys of the section that are known but not the class's, for the message.
        sections: Keys of the class that live in another section.
    """
    fields = [f.name for f in dataclasses.fields(cls)]
    for key in values:
        if key not in fields:
            where = (sections or {}).get(key, section)
            raise InputError(f"no such key; {nearest(key, [*fields, *also])}", _dotted(where, key))
    try:
        return cls(**values)
    except pydantic.ValidationError as error:
        # Of a union's complaints, the one that went deepest, and about the value rather than the type.
        found = max(error.errors(), key=lambda e: (len(e["loc"]), not e["type"].endswith("_type")))
    place = [part for part in found["loc"] if isinstance(part, int) or part.isidentifier()]
    place = [part for part in place if part not in ("float", "int", "str", "bool", "tuple", "ImposedStretch")]
    where = (sections or {}).get(str(place[0]), section) if place else section
    key = ".".join([where, *map(str, place)])
    if found["type"] == "missing" and not isinstance(place[-1], int):
        raise InputError("missing", key)
    if found["type"] == "unexpected_keyword_argument":
        inner = typing.get_args(typing.get_type_hints(cls)[str(place[0])])
        known = [f.name for part in inner if dataclasses.is_dataclass(part) for f in dataclasses.fields(part)]
        raise InputError(f"no such key; {nearest(str(place[-1]), known)}", key)
    kind = str(typing.get_type_hints(cls).get(str(place[0]))) if place else ""
    raise InputError(f"{_plain_words(found, kind)}, not {_shown(found['input'])}", key)


def _plain_words(error: Any, kind: str) -> str:
    """What pydantic says of a value, as something to do.

    Args:
        error: One of its errors.
        kind: The type that is wanted, as text.
    """
    texts = "str" in kind or "Literal" in kind
    some = 'texts, such as ["left"]' if texts else "numbers, such as [1.0, -1.0]"
    wanted = {
        "float_type": "give a number",
        "int_type": "give an integer",
        "int_from_float": "give an integer",
        "bool_type": "give a boolean, true or false",
        "string_type": "give a text",
        "path_type": 'give a path, such as "body.msh"',
        "tuple_type": f"give a list of {some}",
        "too_long": "give a shorter list",
        "missing": f"give a longer list of {some}",
        "mapping_type": "give a table, such as { name = [1.0, -1.0] }",
        "dict_type": "give a table, such as { name = [1.0, -1.0] }",
        "dataclass_type": "give a table, such as { value = 1.0 }",
    }
    said = error["msg"].removeprefix("Value error, ").replace("Input should be", "this should be")
    return wanted.get(error["type"], f"{said[0].lower()}{said[1:]}")


def _shown(value: Any) -> str:
    """A value for a message: short, whatever it is."""
    try:
        text = repr(value)
    except (ValueError, RecursionError):  # an integer of thousands of digits, tables in tables
        text = f"such a long {type(value).__name__}"
    return text if len(text) <= 100 else f"{text[:90]}..."


def _dotted(*parts: str) -> str:
    """A key for a message; a strange part is quoted and cut."""
    return ".".join(part if part.isprintable() and 0 < len(part) <= 50 else _shown(part) for part in parts)


def _whole(folder: Path, path: str) -> str:
    """A path that is relative to ``folder``, as an absolute one."""
    try:
        return str((folder / path).resolve())
    except (ValueError, OSError, RuntimeError) as error:  # a null byte, a loop of links
        raise InputError(f"{_shown(path)} is no path: {error}", "geometry.path") from error


def _make_probes(section: Mapping[str, Any]) -> dict[str, tuple[float, ...]]:
    checked = {}
    for name, point in section.items():
        if not name.isprintable() or not 0 < len(name) <= 100:
            raise InputError("call a probe by a short, printable name", _dotted("probes", name))
        try:
            checked[name] = pydantic.TypeAdapter(tuple[Finite, ...]).validate_python(point)
        except pydantic.ValidationError:
            raise InputError(
                f"give finite coordinates, such as [100.0], not {_shown(point)}", _dotted("probes", name)
            ) from None
    return checked


def _make_solver(section: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    for name, options in section.items():
        if name not in ("potential", "mechanics"):
            raise InputError(
                f"no such solver; {nearest(name, ('potential', 'mechanics'))}", _dotted("solver", name)
            )
        if not isinstance(options, Mapping):
            raise InputError('give PETSc options, such as { ksp_type = "cg" }', f"solver.{name}")
        for key, value in options.items():
            if not isinstance(value, str | int | float | bool):
                raise InputError(
                    f"give a text or a number, not {_shown(value)}", _dotted("solver", name, key)
                )
            _check_option(_dotted("solver", name, key), key, value)
    return {name: dict(options) for name, options in section.items()}


def _check_option(where: str, key: str, value: Any) -> None:
    """Refuse PETSc options that load code, write files, or cannot be options at all."""
    if not re.fullmatch(r"[A-Za-z0-9_]{1,100}", key):
        raise InputError("a PETSc option is a word, such as ksp_type", where)
    if isinstance(value, int) and abs(value) >= 2**31:
        raise InputError(f"give a number below 2^31, not {_shown(value)}", where)
    if isinstance(value, str) and not re.fullmatch(r"[A-Za-z0-9_.,+-]{1,100}", value):
        raise InputError(f"give a word or a number, not {_shown(value)}", where)
    if any(word in f"{key} {value}".lower() for word in ("python", "shell", "plugin", "binary_", "file")):
        raise InputError(
            "this option runs code or reads and writes files; a case file holds data only", where
        )
    if ("view" in key or "monitor" in key) and isinstance(value, str):
        raise InputError("give true: it is printed, not written to a file", where)


def _word(thing: Any, choices: Mapping[str, Any]) -> str:
    return next(word for word, cls in choices.items() if type(thing) is cls)


def _plain(value: Any) -> Any:
    """A value as TOML and JSON can hold it; None is left out of tables."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        value = {f.name: getattr(value, f.name) for f in dataclasses.fields(value)}
    if isinstance(value, Mapping):
        return {k: _plain(v) for k, v in value.items() if v is not None}
    if isinstance(value, tuple | list):
        return [_plain(v) for v in value]
    return str(value) if isinstance(value, Path) else value


def _resolved(texts: Mapping[str, str], made: Mapping[str, Any]) -> dict[str, Any]:
    """The case as nested dictionaries with everything resolved."""
    kin, scheme = _plain(made["kinematics"]), _plain(made["scheme"])
    pace = {"every": scheme.pop("every")} if "every" in scheme else {}
    sections = {
        "geometry": {"kind": _word(made["geometry"], GEOMETRIES), **_plain(made["geometry"])},
        "fibres": _plain(made["fibres"]) if made["fibres"] is not None else None,
        "cell": {"model": _word(made["cell"], CELLS), **_plain(made["cell"])},
        "potential": _plain(made["potential"]),
        "initial": _plain(made["initial"]),
        "activation": {
            "law": _word(made["law"], LAWS),
            **_plain(made["law"]),
            "deformation": _word(made["deformation"], DEFORMATIONS),
        },
        "material": {"model": _word(made["material"], MATERIALS), **_plain(made["material"])},
        "mechanics": {
            "kinematics": _word(made["kinematics"], KINEMATICS),
            **kin,
            **_plain(made["mechanics"]),
            **pace,
        },
        "time": {**_plain(made["time"]), "scheme": _word(made["scheme"], SCHEMES), **scheme},
        "probes": _plain(made["probes"]),
        "output": _plain(made["output"]),
        "solver": _plain(made["solver"]),
    }
    return {**texts, **{name: section for name, section in sections.items() if section}}
