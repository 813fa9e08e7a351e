"""The result folder: what is in it, what of it remains when a run fails, and what it never overwrites."""

import csv
import json
import tomllib

import myostrain as ms
from myostrain import Case, ComputationError, InputError, run_case
from myostrain.case.running import compare, load_results
from myostrain.output.snapshots import Snapshots

import numpy as np
import pytest

from small_cases import ALONE, LINE, SHEET, changed, strict_json, write_case
from snapshot_files import check_vtx

#: Interface, "Result folder", word for word.
INTERFACE = {
    "case": str, "completed": bool, "time": float, "steps": int, "processes": int, "metrics": dict,
    "probes": dict, "solver": dict, "seconds": dict, "cells": int, "unknowns": dict, "parameters": dict,
    "versions": dict,
}  # fmt: skip
METRICS = {
    "celerity", "width_material", "width_spatial", "potential_max", "potential_min", "displacement_max",
}  # fmt: skip

LONGER = changed(LINE, {"time.end": 0.3, "output.every": 0.05, "output.rigid_twin": True, "name": "short"})
SHEETS = changed(SHEET, {"mechanics.every": 2, "solver.potential": {"ksp_rtol": 1e-9}})


@pytest.fixture(scope="module", params=[LONGER, SHEETS], ids=["line", "sheet"])
def run(request, tmp_path_factory):
    """A run's case, folder and results."""
    case = Case.from_dict(request.param)
    folder = tmp_path_factory.mktemp("run") / "out"
    return case, folder, run_case(case, folder, comm=ALONE)


def read_probes(folder):
    with (folder / "probes.csv").open(newline="", encoding="utf-8") as stream:
        header, *rows = csv.reader(stream)
    return header, np.array(rows, dtype=float)


def test_results_are_those_of_the_interface(run):
    """Interface, results.json: these keys, of these types; "add to it freely"."""
    case, folder, returned = run
    found = strict_json((folder / "results.json").read_text(encoding="utf-8"))
    assert found == load_results(folder) == json.loads(json.dumps(returned))
    assert {key: type(found[key]) for key in INTERFACE} == INTERFACE
    assert set(found["metrics"]) >= METRICS
    assert (found["completed"], found["case"], found["processes"]) == (True, case.name, 1)
    assert found["time"] == case.time.end
    assert found["steps"] == round(case.time.end / case.time.step)
    for name, probe in found["probes"].items():
        assert set(probe) == {"position", "activation_time", "activation_times", "apd90"}
        assert probe["activation_time"] == next(iter(probe["activation_times"]), None)
        np.testing.assert_array_equal(probe["position"][: len(case.probes[name])], case.probes[name])
    assert list(found["probes"]) == list(case.probes)
    assert {"solves", "newton", "linear", "factorizations"} <= set(found["solver"]["mechanics"])
    assert {"solves", "linear"} <= set(found["solver"]["potential"])
    assert found["solver"]["potential"]["solves"] == found["steps"]
    assert found["solver"]["mechanics"]["solves"] == found["steps"] // case.scheme.every + 1
    phases = {"start", "setup", "potential", "mechanics", "output", "figures"}
    assert {"total", *phases} <= set(found["seconds"])
    assert all(value >= 0 for value in found["seconds"].values())
    assert {"myostrain", "dolfinx", "petsc", "mpi", "numpy", "python"} <= set(found["versions"])
    assert found["scheme"]["name"] == "SecondOrder"  # "Which one ran is in the results"
    # "and says in results.json which scheme and tolerances ran"
    extent = np.linalg.norm(np.ptp(Snapshots(folder).points, axis=0))
    chosen = case.solver.get("potential", {}).get("ksp_rtol", 1e-10)
    assert found["tolerances"]["potential"] == chosen
    assert found["tolerances"]["mechanics"] == pytest.approx(case.mechanics.tolerance * extent)
    assert found["parameters"] == json.loads(json.dumps(case.parameters))
    nodes = found["unknowns"]["potential"]
    assert (found["cells"], nodes, found["unknowns"]["states"]) in ((20, 21, 21), (96, 61, 61))
    assert found["unknowns"]["mechanics"] == (41 if nodes == 21 else 122)


def test_metrics_are_what_the_interface_says(run):
    """Interface: celerity is distance over difference of activation times between the first two probes."""
    case, folder, results = run
    metrics = results["metrics"]
    (a, b) = (np.array(p) for p in list(case.probes.values())[:2])
    times = [results["probes"][name]["activation_time"] for name in list(case.probes)[:2]]
    if None in times:
        assert metrics["celerity"] is None
    else:
        assert metrics["celerity"] == pytest.approx(np.linalg.norm(b - a) / (times[1] - times[0]), rel=1e-12)
    v, u = (Snapshots(folder).field(name) for name in ("potential", "displacement"))
    assert (metrics["potential_min"], metrics["potential_max"]) == (v.min(), v.max())
    assert metrics["displacement_max"] == pytest.approx(np.linalg.norm(u, axis=-1).max(), rel=1e-15)
    if v.size == 61:
        assert metrics["width_material"] is metrics["width_spatial"] is None


def test_rigid_twin(run):
    """The rigid twin of pulse-1d: its metrics and the ratios; its own folder is whole, and it is rigid."""
    case, folder, results = run
    assert (folder / "rigid").exists() is case.output.rigid_twin
    if not case.output.rigid_twin:
        return
    twin = load_results(folder / "rigid")
    assert twin["metrics"]["displacement_max"] == 0.0
    assert results["metrics"]["celerity"] > 0
    for name in ("celerity", "width_material", "width_spatial"):
        assert results["metrics"][f"{name}_rigid"] == twin["metrics"][name]
    ratio = results["metrics"]["celerity"] / twin["metrics"]["celerity"]
    assert results["metrics"]["celerity_ratio"] == pytest.approx(ratio, rel=1e-15)
    assert case.rigid().parameters["mechanics"]["imposed_stretch"] == {"value": 1.0, "until": float("inf")}
    nothing = dict.fromkeys(("celerity", "width_material", "width_spatial"))
    assert set(compare(nothing, twin["metrics"]).values()) >= {None}
    assert compare({**nothing, "celerity": 1.0}, nothing)["celerity_ratio"] is None
    spirals = [{**nothing, "tip_period": period} for period in (3.0, 4.0)]
    assert compare(*spirals)["tip_period_ratio"] == 0.75


def test_the_resolved_case_repeats_the_run(run, tmp_path):
    """Interface: "myostrain run DIR/case.toml repeats it": the same metrics to the last digit."""
    case, folder, results = run
    again = Case.from_file(folder / "case.toml")
    assert again == case
    repeated = run_case(again, tmp_path / "again", comm=ALONE, figures=False)
    assert repeated["metrics"] == results["metrics"]
    assert repeated["probes"] == results["probes"]
    assert tomllib.loads((folder / "case.toml").read_text(encoding="utf-8")) == case.parameters


def test_probe_table(run):
    """Interface: "a row a sampled time, a column a probe and field"; the last row is the last state."""
    case, folder, results = run
    header, rows = read_probes(folder)
    line = case.name == "short"
    fields = ["potential", "recovery", "activation", "displacement_x", *([] if line else ["displacement_y"])]
    assert header == ["time", *(f"{probe}_{field}" for probe in case.probes for field in fields)]
    steps = results["steps"]
    # A row every thousandth of the run, at most every step that solves mechanics, from 0 to the end.
    times = np.linspace(0.0, case.time.end, steps // case.scheme.every + 1)
    np.testing.assert_allclose(rows[:, 0], times, rtol=1e-12)
    if line:  # where both probes are nodes; the table has nine digits
        snapshots = Snapshots(folder)
        at = [int(np.argmin(np.abs(snapshots.points[:, 0] - p[0]))) for p in case.probes.values()]
        np.testing.assert_allclose(rows[-1][[1, 5]], snapshots.field("potential")[at], rtol=1e-8)
    np.testing.assert_allclose(rows[:, 3], -0.3 * rows[:, 1], rtol=1e-7, atol=1e-15)


def test_snapshots(run):
    """Snapshots, from which figures are drawn: the mesh, and every chosen field in double precision."""
    case, folder, results = run
    with np.load(folder / "snapshots" / "mesh.npz", allow_pickle=False) as mesh:
        points, cells = mesh["points"], mesh["cells"]
    nodes, dim = points.shape
    assert (nodes, cells.shape) == (results["unknowns"]["potential"], (results["cells"], dim + 1))
    turn = case.scheme.every  # what is written is of one time: frames are where mechanics is solved
    apart = turn * max(1, round(case.output.every / (results["step"] * turn)))
    numbers = sorted({*range(0, results["steps"], apart), results["steps"]})
    names = {"mesh.npz", "activation.npz", *(f"frame-{number:09d}.npz" for number in numbers)}
    assert {path.name for path in (folder / "snapshots").iterdir()} == names
    for number in numbers:
        with np.load(folder / "snapshots" / f"frame-{number:09d}.npz", allow_pickle=False) as frame:
            shapes = {name: (frame[name].dtype, frame[name].shape) for name in frame}
            assert frame["time"] == pytest.approx(number * results["step"], rel=1e-12)
        scalars = dict.fromkeys(("potential", "recovery", "stress_trace"), (np.float64, (nodes,)))
        expected = {**scalars, "displacement": (np.float64, (nodes, dim)), "time": (np.float64, ())}
        if dim == 1:  # its displacement is quadratic
            expected["displacement.middles"] = (np.float64, (len(cells), dim))
        assert shapes == expected
    edges = points[cells]
    volume = np.abs(np.linalg.det(edges[:, 1:] - edges[:, :1])) / dim
    # The whole body, once: of the ellipse, the distortion (0.5 %) and the polygon (1.1 %) take 1.6 %.
    assert volume.sum() == pytest.approx(20.0 if dim == 1 else 0.984 * np.pi * 20 * 24 / 4, rel=1e-3)
    (initial,) = case.initial
    start = np.where(np.linalg.norm(points - initial.where.center, axis=1) <= 5.0, 0.9, 0.0)
    np.testing.assert_array_equal(Snapshots(folder).field("potential", 0), start)


def test_vtx_holds_every_frame(run):
    """Interface: fields.bp is VTX, "fields over time": every time and every value of the snapshots."""
    _, folder, _ = run
    check_vtx(folder)


def test_figures_are_drawn(run):
    """Interface: figures/*.png, "what the case is about, ready to look at"."""
    _, folder, _ = run
    found = sorted(path.name for path in (folder / "figures").iterdir())
    assert found
    assert all((folder / "figures" / name).read_bytes()[:4] in (b"\x89PNG", b"GIF8") for name in found)


def test_chosen_fields(tmp_path):
    """Interface, [output] fields: what is not chosen is not written; none at all is allowed too."""
    chosen = Case.from_dict(changed(LINE, {"output.fields": ["potential"]}))
    run_case(chosen, tmp_path / "one", comm=ALONE)
    assert Snapshots(tmp_path / "one").names == {"potential"}
    none = Case.from_dict(changed(LINE, {"output.fields": [], "probes": {}}))
    results = run_case(none, tmp_path / "none", comm=ALONE)
    assert results["completed"]
    expected = {
        ".manifest",
        "case.toml",
        "results.json",
        "references.bib",
        "run.log",
        "checkpoint",
        "measures.csv",
    }
    assert {path.name for path in (tmp_path / "none").iterdir()} == expected


def test_a_few_lines_of_python(tmp_path, monkeypatch):
    """Interface: "Everything the command line does is a few lines of Python over the public names".

    Paths may be texts, as for Simulation, and the fields asked for are checked as in a case file.
    """
    monkeypatch.chdir(tmp_path)
    write_case(tmp_path / "line.toml", LINE)
    results = ms.run_case(ms.Case.from_file("line.toml", ["cell.alpha=0.2"]), "out", figures=False)
    assert results == load_results(tmp_path / "out")
    assert results["parameters"]["cell"]["alpha"] == 0.2
    model = ms.Case.from_file(tmp_path / "line.toml").build(ALONE)
    with pytest.raises(InputError, match="'potential'"):
        ms.Simulation(model, step=1e-3, end=1e-2, fields=("potental",))


# Failure.

BREAKS = 0.006


def breaking_simulation(out, **options):
    """A run of 10 steps that fails in the step to t = 0.007."""

    def source(x, time):
        return np.full(len(x), np.nan if time > BREAKS + 1e-9 else 0.0)

    body = ms.build(ms.geometry.Line(length=20.0), comm=ALONE)
    mechanics = ms.Mechanics(
        body,
        kinematics=ms.kinematics.Line(),
        material=ms.materials.Spring(),
        supports=ms.Supports(fixed=["left"]),
    )
    potential = ms.Potential(
        body,
        membrane=ms.membranes.FitzHughNagumo(),
        diffusivity=100.0,
        deformation=mechanics.deformation,
        initial=[ms.InitialValues(where=ms.Place(center=(0.0,), radius=5.0), potential=0.9)],
        source=source,
    )
    model = ms.Electromechanics(potential, mechanics)
    return ms.Simulation(model, step=1e-3, end=1e-2, out=out, probes={"a": (6.0,)}, every=2e-3, **options)


def check_remains(folder):
    """What was computed before the failure is readable, and nothing says that the run ended well."""
    assert not (folder / "results.json").exists()
    failure = strict_json((folder / "failure.json").read_text(encoding="utf-8"))
    assert failure["time"] == pytest.approx(BREAKS, abs=1.01e-3)
    assert failure["reason"]
    assert failure["advice"]
    _, rows = read_probes(folder)
    np.testing.assert_allclose(rows[:, 0], np.arange(7) * 1e-3, atol=1e-12)
    assert np.isfinite(rows).all()
    left = Snapshots(folder)
    np.testing.assert_allclose(left.times, [0.0, 0.002, 0.004, 0.006], atol=1e-12)
    frames = [left.field(name, i) for name in sorted(left.names) for i in range(4)]
    assert all(np.isfinite(values).all() for values in frames)
    assert {"potential", "displacement", "stress_trace"} <= left.names
    assert left.activation() is None
    assert (folder / "fields.bp").is_dir()


def test_failure_leaves_what_was_computed(tmp_path):
    """Requirements: NaN "stops the run with the physical time and the reason"; the rest "stays readable".

    results.json is "present only when the run ended well", so it is absent although an earlier run left one.
    """
    out = tmp_path / "out"
    run_case(Case.from_dict(LINE), out, comm=ALONE, figures=False)
    assert (out / "results.json").exists()
    with pytest.raises(ComputationError, match=r"at t = 0\.00[67]"):
        breaking_simulation(out, force=True).run()
    check_remains(out)


def test_failure_of_the_rigid_twin_is_a_failure(tmp_path, monkeypatch):
    """Interface: results.json is "present only when the run ended well"; the twin is part of the run."""

    def fails(self, *_):
        raise ComputationError("the twin's failure")

    case = Case.from_dict(changed(LINE, {"output.rigid_twin": True}))
    solve = ms.Mechanics.solve

    def solve_or_fail(mechanics, time, **options):
        return fails(mechanics) if mechanics.held(time) else solve(mechanics, time, **options)

    monkeypatch.setattr(ms.Mechanics, "solve", solve_or_fail)
    with pytest.raises(ComputationError, match="the twin's failure"):
        run_case(case, tmp_path / "out", comm=ALONE, figures=False)
    assert not (tmp_path / "out" / "results.json").exists()
