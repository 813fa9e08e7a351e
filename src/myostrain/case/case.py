"""A case file (TOML) and the objects that it describes; every message names a key to act on."""

from __future__ import annotations

import dataclasses
import re
import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from myostrain import cases, geometry, kinematics
from myostrain.activation import FibreTension
from myostrain.case import building
from myostrain.case.exclusions import check_drive, check_rigid
from myostrain.case.overrides import Assignment, override
from myostrain.case.parsing import (
    make,
    make_cavities,
    make_placed,
    make_points,
    make_solver,
    make_stretch_currents,
    make_variations,
    pick,
    places_of,
    plain,
)
from myostrain.case.resolved import resolved
from myostrain.case.sections import (
    CELLS,
    CIRCULATIONS,
    DEFORMATIONS,
    FIBRES,
    GEOMETRIES,
    KINEMATICS,
    LAWS,
    LISTS,
    MATERIALS,
    SCHEMES,
    SECTIONS,
    TEXTS,
    CellSection,
    MechanicsSection,
    OutputSection,
    PotentialSection,
    Rigid,
    TimeSection,
    TransmuralSection,
    UnitsSection,
)
from myostrain.coupling import Electromechanics
from myostrain.electrics import Drive, InitialValues, Stimulus, StretchCurrent, Variation
from myostrain.engine import MPI
from myostrain.errors import InputError, dotted, nearest, shown
from myostrain.mechanics import Cavities, ImposedStretch
from myostrain.output.units import units_of
from myostrain.run.simulation import Simulation
from myostrain.schemes import Implicit
from myostrain.validation import shown_in_notebook

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
    units: UnitsSection
    geometry: Any
    fibres: Any
    cell: Any
    variations: tuple[Variation, ...]
    beginning: CellSection
    stretch_currents: tuple[StretchCurrent, ...]
    potential: PotentialSection
    initial: tuple[InitialValues, ...]
    stimuli: tuple[Stimulus, ...]
    drive: Drive | None
    law: Any
    active: Any
    transmural: TransmuralSection
    material: Any
    kinematics: Any
    mechanics: MechanicsSection
    cavities: Cavities | None
    unload: bool
    scheme: Any
    time: TimeSection
    probes: Mapping[str, tuple[float, ...]]
    electrodes: Mapping[str, tuple[float, ...]]
    output: OutputSection
    solver: Mapping[str, Mapping[str, Any]]
    parameters: Mapping[str, Any]

    def __repr__(self) -> str:
        """Its name, its title and its sections."""
        return f"Case({self.name}: {self.title}; {', '.join(self._sections())})"

    def _sections(self) -> dict[str, str]:
        """Sections of the case file and what they say."""
        found = {name: value for name, value in self.parameters.items() if isinstance(value, Mapping | list)}
        return {name: said for name, value in found.items() if (said := _said(value))}

    def _repr_html_(self) -> str:
        return shown_in_notebook(f"{self.name}: {self.title}", self._sections())

    @classmethod
    def from_file(cls, path: str | Path, overrides: Sequence[Assignment] = ()) -> Case:
        """Read a case file.

        Args:
            path: The TOML file; paths in it are relative to its folder.
            overrides: ``KEY=VALUE`` with dotted keys and values in TOML syntax, or pairs of key and value;
                paths in them are relative to the current folder.

        Raises:
            InputError: The file cannot be read, is not TOML, or says what cannot be.
        """
        path = Path(path)
        if str(path) in cases.names() and not path.exists():
            raise InputError(f"'{path}' is a named case, no file: give cases.path('{path}')", "FILE")
        geometry.readable(path, "FILE")
        try:
            if path.stat().st_size > MAX_FILE:
                raise InputError(f"{path} is larger than {MAX_FILE} bytes: it is not a case file")
            data = tomllib.loads(path.read_text(encoding="utf-8"))
        except InputError:
            raise
        except ValueError as error:  # of TOML, of UTF-8, and of integers that are too long
            raise InputError(f"{path} is not a valid TOML file: {error}") from error
        except RecursionError:
            raise InputError(f"{path} is not a case: its lists or tables are too deep") from None
        except OSError as error:
            raise InputError(f"{path} cannot be read: {error.strerror}") from error
        if not data:
            raise InputError(f"{path} holds no case: it has no section")
        for form in (data.get("geometry"), data.get("fibres"), data.get("cell"), data.get("drive")):
            if isinstance(form, dict) and isinstance(form.get("path"), str):
                form["path"] = str(path.parent.absolute() / form["path"])
        cell = data.get("cell")
        if isinstance(cell, dict) and isinstance(cell.get("initial"), str):
            cell["initial"] = str(path.parent.absolute() / cell["initial"])
        for table in _stimuli(data):
            if isinstance(table.get("times"), str):
                table["times"] = str(path.parent.absolute() / table["times"])
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
            places = places_of(unknown[0], data)
            better = (
                f"did you mean {' or '.join(places)}?" if places else nearest(unknown[0], (*SECTIONS, *TEXTS))
            )
            raise InputError(f"no such section or key; {better}", dotted(unknown[0]))
        for section, needed in SECTIONS.items():
            if needed and section not in data:
                raise InputError("this section is missing; `myostrain show sheet-2d` prints a case", section)
            given = data.get(section, {})
            listed = (
                section in LISTS and isinstance(given, list) and all(isinstance(g, Mapping) for g in given)
            )
            if not isinstance(given, Mapping) and not listed:
                raise InputError(
                    f"this is a section, [{section}], not a value; change one of its keys, {section}.KEY",
                    section,
                )
        check_drive(data)
        for key in TEXTS:
            if not isinstance(data.get(key, ""), str):
                raise InputError("give a text", key)
        if not re.fullmatch(r"[^/\\\x00-\x1f]{1,100}", data.get("name", "-")) or data.get("name") in (
            ".",
            "..",
        ):
            raise InputError(
                f"the result folder is named after it: give a short word, not {shown(data['name'])}", "name"
            )
        part = {section: dict(data.get(section, {})) for section in SECTIONS if section not in LISTS}

        form = pick(part["geometry"], "geometry.kind", GEOMETRIES)
        kin = pick(part["mechanics"], "mechanics.kinematics", KINEMATICS)
        line, rigid = kin is kinematics.Line, kin is Rigid
        if rigid:
            check_rigid(data)
        fibres = pick(part["fibres"], "fibres.kind", FIBRES, "uniform") if part["fibres"] else None
        model = pick(part["cell"], "cell.model", CELLS, "FitzHughNagumo")
        beginning, variations = _take(part["cell"], CellSection), part["cell"].pop("variation", [])
        if isinstance(beginning.get("initial"), str):
            beginning["initial"] = _whole(folder, beginning["initial"], "cell.initial")
        stretched = part["cell"].pop("stretch_current", ())
        law = pick(part["activation"], "activation.law", LAWS, "proportional")
        tension = getattr(law, "yields", "strain") == "tension"
        if tension and "deformation" in part["activation"]:
            raise InputError(
                "an active stress takes the place of a deformation; leave one out", "activation.deformation"
            )
        active = (
            FibreTension
            if tension
            else pick(part["activation"], "activation.deformation", DEFORMATIONS, "fibre")
        )
        strain = _take(part["activation"], active)
        through = _take(part["activation"], TransmuralSection)
        material = pick(part["material"], "material.model", MATERIALS, "Spring" if line else "NeoHookean")
        tied = "circulation" in data
        connected = pick(part["circulation"], "circulation.kind", CIRCULATIONS) if tied else None
        cavities, unload = make_cavities(connected, part["circulation"]) if tied else (None, False)
        scheme = pick(part["time"], "time.scheme", SCHEMES, "second-order")

        for section in ("geometry", "fibres", "cell", "drive"):
            if isinstance(part[section].get("path"), str):
                part[section]["path"] = _whole(folder, part[section]["path"], f"{section}.path")
        stimuli = [
            {**table, "times": _whole(folder, table["times"], "stimulus.times")}
            if isinstance(table.get("times"), str)
            else table
            for table in _stimuli(data)
        ]
        constraint = _take(part["mechanics"], kin)
        if line and part["mechanics"].pop("constraint", "total") != "total":
            raise InputError("a line has no constraint; leave the key out", "mechanics.constraint")
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
        driven = "drive" in data
        made = {
            "units": make(UnitsSection, part["units"], "units"),
            "geometry": make(form, part["geometry"], "geometry", also=("kind",)),
            "fibres": make(fibres, part["fibres"], "fibres", also=("kind",)) if fibres else None,
            "cell": make(
                model,
                getattr(model, "gathered", dict)(part["cell"]),
                "cell",
                also=(
                    "model",
                    "stretch_current",
                    "variation",
                    *(f.name for f in dataclasses.fields(CellSection)),
                ),
            ),
            "beginning": make(CellSection, beginning, "cell"),
            "potential": make(PotentialSection, part["potential"], "potential"),
            "initial": make_placed(InitialValues, data.get("initial", ()), "initial"),
            "stimuli": make_placed(Stimulus, stimuli, "stimulus"),
            "drive": make(Drive, part["drive"], "drive") if driven else None,
            "law": None
            if rigid
            else make(
                law,
                part["activation"],
                "activation",
                also=("law", "deformation", *(f.name for f in dataclasses.fields(TransmuralSection))),
            ),
            "active": None if rigid else make(active, strain, "activation"),
            "transmural": make(TransmuralSection, through, "activation"),
            "material": None if rigid else make(material, part["material"], "material", also=("model",)),
            "mechanics": make(
                MechanicsSection,
                part["mechanics"],
                "mechanics",
                also=("kinematics", "every", *(f.name for f in dataclasses.fields(kin))),
            ),
            "cavities": cavities,
            "unload": unload,
            "kinematics": make(kin, constraint, "mechanics"),
            "scheme": make(
                scheme,
                {**part["time"], **pace},
                "time",
                also=("scheme", "step", "end"),
                sections={"every": "mechanics"},
            ),
            "time": make(TimeSection, timing, "time"),
            "probes": make_points(part["probes"], "probes", "a probe", "[100.0]"),
            "electrodes": make_points(part["electrodes"], "electrodes", "an electrode", "[50.0, 0.0, 20.0]"),
            "output": make(OutputSection, part["output"], "output"),
            "solver": make_solver(part["solver"]),
        }
        made["stretch_currents"] = make_stretch_currents(stretched, made["cell"], None if rigid else kin.dim)
        made["variations"] = make_variations(variations, made["cell"])
        if made["output"].tip is not None and not rigid and kin.dim != 2:
            raise InputError("tips are found on sheets; leave it out", "output.tip")
        if made["mechanics"].ellipticity == "warn" and not rigid and kin.dim < 3:
            raise InputError("only a solid's is sampled; leave it out", "mechanics.ellipticity")
        units_of(None if driven else made["cell"], plain(made["units"]))
        texts = {"name": data.get("name", name)}
        texts |= {"title": data.get("title", texts["name"]), "cost": data.get("cost", "")}
        return cls(**texts, **made, parameters=resolved(texts, made))

    @property
    def dim(self) -> int | None:
        """Dimension of the body; None of a rigid one from a file."""
        return getattr(self.geometry if self.is_rigid else self.kinematics, "dim", None)

    @property
    def is_rigid(self) -> bool:
        """Whether no mechanics is made."""
        return isinstance(self.kinematics, Rigid)

    def rigid(self) -> Case:
        """The same case on a body that does not move."""
        held = ImposedStretch(value=1.0, until=float("inf"))
        mechanics = dataclasses.replace(self.mechanics, imposed_stretch=held)
        output = dataclasses.replace(self.output, rigid_twin=False)
        made = {f.name: getattr(self, f.name) for f in dataclasses.fields(self)}
        texts = {"name": f"{self.name}-rigid", "title": f"{self.title}, rigid", "cost": self.cost}
        made |= {"mechanics": mechanics, "cavities": None, "output": output, **texts}
        return Case(**{**made, "parameters": resolved(texts, made)})

    def to_toml(self) -> str:
        """The case as TOML with everything resolved; :meth:`from_file` reads it back."""
        import tomlkit  # takes a tenth of a second, which a start without a result folder need not wait for

        return tomlkit.dumps(dict(self.parameters))

    def build(self, comm: Any = MPI.COMM_WORLD) -> Electromechanics:
        """Make the coupled problem, with the initial potential set.

        Raises:
            InputError: What only shows on the mesh: a boundary that is not there, a bump without a node, ...
        """
        return building.model(self, comm)

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
        return building.simulation(self, comm, out, force, resume)


def _take(section: dict[str, Any], cls: Any) -> dict[str, Any]:
    """Take the keys of a class out of a section that it shares with others."""
    return {f.name: section.pop(f.name) for f in dataclasses.fields(cls) if f.name in section}


def _stimuli(data: Mapping[str, Any]) -> list[dict[str, Any]]:
    """The tables of [stimulus] or [[stimulus]]."""
    given = data.get("stimulus", [])
    return [table for table in (given if isinstance(given, list) else [given]) if isinstance(table, dict)]


def _whole(folder: Path, path: str, key: str) -> str:
    """A path that is relative to ``folder``, as an absolute one."""
    try:
        whole = str((folder / path).resolve())
        whole.encode()
        return whole
    except UnicodeEncodeError:
        raise InputError(
            f"the path {str(folder / path)!a} is not UTF-8, and no case file can hold it; rename it",
            key,
        ) from None
    except (ValueError, OSError, RuntimeError) as error:  # a null byte, a loop of links
        raise InputError(f"{shown(path)} is not a path: {error}", key) from error


def _said(value: Any) -> str:
    """A section on one line."""
    if isinstance(value, Mapping):
        return ", ".join(f"{key} = {_said(each)}" for key, each in value.items() if each is not None)
    if isinstance(value, list | tuple):
        return f"[{', '.join(_said(each) for each in value)}]"
    return f"{value:g}" if isinstance(value, float) else str(value)
