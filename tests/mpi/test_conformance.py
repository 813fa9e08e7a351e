"""The result does not depend on the number of processes: every shipped case, every exported model."""

import json
from pathlib import Path

from myostrain import Case, cases
from myostrain.case import sections
from myostrain.case.running import load_results
from myostrain.output.snapshots import Snapshots

import numpy as np
import pytest

from small_cases import LINE, REMOVED, SHEET, SOLID, changed, write_case

pytestmark = pytest.mark.mpi

#: Runs case files; results in the folder of the first argument.
DRIVER = """
import sys
from pathlib import Path
from myostrain import Case, run_case
for file in map(Path, sys.argv[2:]):
    run_case(Case.from_file(file), Path(sys.argv[1]) / file.stem, figures=False)
"""

#: A membrane of a file.
CELL_FILE = Path(__file__).parents[1] / "data" / "small_cell.ode"

#: Larger cases on coarser meshes; a case that is not here runs on its own.
COARSER = {
    "sheet-2d": ["geometry.spacing=6"],
    "spiral-2d": ["geometry.spacing=6", "output.tip.every=0.2"],
    "slab-3d": ["geometry.spacing=1.5"],
    "ventricle-3d": ["geometry.spacing=6"],
    "heartbeat-3d": ["geometry.spacing=25", "geometry.layers=1", "circulation.preload=0.005"],
    "heartbeat-3d-stress": ["geometry.spacing=25", "geometry.layers=1", "circulation.preload=0.005"],
    "biventricle-3d": ["geometry.spacing=30", "circulation.preload=[0.005, 0.005]"],
    "niederer-3d": ["geometry.spacing=1.5"],
    "land-1": ["geometry.spacing=0.5"],
    "land-2": ["geometry.spacing=6"],
    "land-3": ["geometry.spacing=6"],
    "arostica-0a": ["geometry.spacing=0.02", "geometry.layers=1"],
    "arostica-1": ["geometry.spacing=0.02", "geometry.layers=1"],
}

#: Mechanics to round-off: what is left is the potential's linear solver, whose preconditioner is each
#: process's own, so that a solve differs by its tolerance, 1e-10. Measured after six steps: 1.3e-9.
TOLERANCE, NEAR = 1e-10, 2e-8

#: Parameters that have no default, or one for another material.
PARAMETERS = {
    "active-stress": {"tension": 0.3},
    "hunter-1998": {"tension": 0.3},
    "nash-panfilov-2004": {"tension": 0.3},
    "timed": {"gamma_min": -0.2, "start": 0.0, "end": 0.1},
}

#: A membrane in ms and mV with calcium, for laws that ask for one.
IN_MILLIVOLTS = {
    "cell": {"model": "BuenoOrovio2008"},
    "initial.potential": 20.0,
    "time.step": 2.0,
    "time.end": 8.0,
    "output.every": 4.0,
    "potential.diffusivity": 0.1,
}


def shortened(name):
    """A shipped case's few first steps, as a case file's text."""
    case = Case.from_file(cases.path(name))
    step = case.time.step
    few = 2 if name.startswith(("land-", "arostica-", "heartbeat-", "biventricle-")) else 4
    changes = [
        *COARSER.get(name, []),
        *([] if name == "niederer-3d" else [f"mechanics.tolerance={TOLERANCE}"]),  # it is rigid
        f"time.end={few * step!r}",
        f"output.every={few // 2 * step!r}",
        *(["mechanics.every=2"] if getattr(case.scheme, "every", 1) > 1 else []),
    ]
    return Case.from_file(cases.path(name), changes).to_toml()


def exported():
    """A small case for everything that a case file can name."""
    short = {"mechanics.tolerance": TOLERANCE, "output.every": 1e-2}
    solid = changed(SOLID, {"fibres.sheet": [0.0, 1.0, 0.0], "time.end": 2e-2, **short})
    line = changed(LINE, {"time.end": 4e-3, **short})
    bodies = {1: line, 3: solid}
    found = {}
    for name, material in sections.MATERIALS.items():
        stiff = {"activation.beta": 0.01} if name == "Arostica2025" else {}  # in Pa, with stiff fibres
        case = {"material": {"model": name}, **stiff}
        found[f"material {name}"] = changed(bodies[material.tensor_dim], case)
    for name in sections.DEFORMATIONS:
        found[f"deformation {name}"] = changed(solid, {"activation.deformation": name})
    for name in sections.LAWS:
        law = {"activation": {"law": name, **PARAMETERS.get(name, {})}}
        wants_units = hasattr(sections.LAWS[name], "units")
        found[f"law {name}"] = changed(solid, {**law, **(IN_MILLIVOLTS if wants_units else {})})
    for name, membrane in sections.CELLS.items():
        cell = {"path": str(CELL_FILE)} if name == "file" else {}
        made = membrane(**cell)
        low, high = made.range
        excited = {"cell": {"model": name, **cell}, "initial.potential": low + 0.9 * (high - low)}
        if made.time_unit == "ms":
            excited |= {"time.step": 2e-2, "time.end": 8e-2, "output.every": 4e-2}
        if made.potential_unit == "mV":
            excited |= {"activation.beta": 1e-3}
        found[f"membrane {name}"] = changed(line, excited)
    for name in sections.SCHEMES:
        for balance in ("conservative", "advective"):
            every = REMOVED if name == "implicit" else 1
            scheme = {"time.scheme": name, "mechanics.every": every, "potential.balance": balance}
            found[f"scheme {name} {balance}"] = changed(line, {**scheme, "potential.mass": "averaged"})
    stretched = {"conductance": 20.0, "measure": "fibre", "center": [10.0, 12.0], "radius": 6.0}
    found["stretch current"] = changed(
        SHEET, {"cell.stretch_current": stretched, "mechanics.fixed": ["boundary"], **short}
    )
    for constraint in ("total", "elastic"):
        sheet = changed(SHEET, {"time.end": 4e-3, "mechanics.constraint": constraint, **short})
        for name in ("plane-stress", "plane-strain"):
            found[f"{name} {constraint}"] = changed(sheet, {"mechanics.kinematics": name})
        found[f"solid {constraint}"] = changed(solid, {"mechanics.constraint": constraint})
    moving = {"density": 1.0, "viscosity": 0.1, "damping_normal": {"right": 0.5}, "damping": {"top": 0.5}}
    free = {**solid["mechanics"], **moving, "fixed": []}
    found["inertia"] = changed(solid, {"mechanics": free})
    # Many of them are the same one case.
    resolved = {Case.from_dict(case).to_toml(): name for name, case in reversed(found.items())}
    return {name: found[name] for name in resolved.values()}


def table(path):
    """The rows of a CSV file."""
    return np.loadtxt(path, delimiter=",", skiprows=1, ndmin=2)


def differences(one, other):
    """What differs between two result folders: metrics, tables and the fields of the last frame."""
    found = []

    def compare(what, a, b):
        a, b = np.asarray(a, dtype=float), np.asarray(b, dtype=float)  # a metric that is None becomes NaN
        if a.shape != b.shape or not np.array_equal(np.isnan(a), np.isnan(b)):
            found.append(f"{what}: {a.shape} and {b.shape}, or other NaNs")
            return
        error, size = (np.abs(x[~np.isnan(a)]).max(initial=0.0) for x in (a - b, a))
        if error > NEAR * max(1.0, size):
            found.append(f"{what}: {error:.2g} of {size:.2g}")

    first, second = load_results(one), load_results(other)
    alike = ("cells", "unknowns", "steps", "time", "parameters")
    found += [f"{key}: {first[key]} and {second[key]}" for key in alike if first[key] != second[key]]
    assert first["metrics"].keys() == second["metrics"].keys()
    for name, value in first["metrics"].items():
        compare(name, value, second["metrics"][name])
    for name in ("probes.csv", "measures.csv", "tip.csv", "ecg.csv"):
        if (one / name).exists() or (other / name).exists():
            compare(name, table(one / name), table(other / name))
    frames, others = Snapshots(one), Snapshots(other)
    compare("points", frames.points, others.points)
    compare("cells of the mesh", frames.cells, others.cells)
    compare("times", frames.times, others.times)
    assert frames.names == others.names
    for name in frames.names:
        compare(name, frames.field(name, len(frames.times) - 1), others.field(name, len(frames.times) - 1))
    return found


def compare_runs(run, folder, files, numbers):
    """Run the case files on so many processes each and compare all with one."""
    for number in (1, *numbers):
        run(number, DRIVER, folder / str(number), *files, timeout=900)
    found = {}
    for file in files:
        for number in numbers:
            one, other = (folder / str(n) / file.stem for n in (1, number))
            assert load_results(other)["processes"] == number
            if wrong := differences(one, other):
                found[f"{file.stem} on {number}"] = wrong
    assert found == {}


def test_shipped_cases(on_processes, tmp_path):
    """docs/howto/parallel.md: "The result is that of one process"."""
    files = []
    for name in cases.names():
        files.append(tmp_path / f"{name}.toml")
        files[-1].write_text(shortened(name), encoding="utf-8")
    assert {"slab-3d", "ventricle-3d", "land-1", "sheet-2d"} <= {file.stem for file in files}
    compare_runs(on_processes, tmp_path, files, (2, 3))


def test_exported_models(on_processes, tmp_path):
    """The same of every material, activation, membrane, scheme and kinematics."""
    files = [write_case(tmp_path / f"{name}.toml", case) for name, case in exported().items()]
    compare_runs(on_processes, tmp_path, files, (2,))


def test_differences_are_found(tmp_path):
    """The comparison is no formality: it names what differs."""
    run = [tmp_path / "a", tmp_path / "b"]
    for folder, value in zip(run, (1.0, 1.0 + 1e-6), strict=True):
        (folder / "snapshots").mkdir(parents=True)
        metrics = {"potential_max": value, "celerity": None}
        same = dict.fromkeys(("cells", "unknowns", "steps", "time", "parameters"), 1)
        results = {**same, "metrics": metrics, "seconds": {}}
        (folder / "results.json").write_text(json.dumps(results))
        (folder / "probes.csv").write_text(f"time,a_potential\n0.0,{value!r}\n")
        np.savez(folder / "snapshots" / "mesh.npz", points=[[0.0], [1.0]], cells=[[0, 1]])
        np.savez(folder / "snapshots" / "frame-000000000.npz", time=0.0, potential=[0.0, value])
    assert differences(run[0], run[0]) == []
    assert [what.split(":")[0] for what in differences(*run)] == ["potential_max", "probes.csv", "potential"]
