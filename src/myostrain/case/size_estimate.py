"""How large a case is, told from its description before anything is meshed; what cannot fit is refused."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from myostrain import kinematics
from myostrain.errors import InputError
from myostrain.output.nodal_values import WIDTHS
from myostrain.run.free_space import free_disk, free_memory

GB = 1e9

#: Time steps at most; with more, rounding spoils end/step, and no run comes to its end.
MAX_STEPS = 1_000_000_000

#: Magnitudes that products and squares of numbers survive.
SMALLEST, LARGEST = 1e-60, 1e60

#: Bytes that a process takes whatever the mesh: 111 MB after the imports, then kernels and writers.
BASE = 2e8

#: Bytes a node: c + g · log₂(nodes), where g is the fill of the direct factorization by nested
#: dissection, about 62 bytes an unknown of the mechanics. Measured, peak resident memory over
#: that after the imports, one process, three second-order steps with mechanics in each:
#:   line           10,001 nodes  28 MB,  300,001 nodes  527 MB: 1.72 kB for each more
#:   plane stress   10,267 nodes  48 MB,  101,017 nodes  448 MB: 4.41 kB
#:   plane strain    5,167 nodes 116 MB,   30,301 nodes  687 MB: 22.7 kB
#: Solids, P2–P1 with kept factors, by peaks of whole processes: 2,233 nodes 0.6 GB, 5,400 nodes 1.5 GB,
#: 15,561 nodes 3.6 GB.
PER_NODE: dict[Any, tuple[float, float]] = {
    kinematics.Line: (1_800.0, 0.0),
    kinematics.PlaneStress: (2_400.0, 124.0),
    kinematics.PlaneStrain: (14_500.0, 560.0),
    kinematics.Solid: (20_000.0, 15_000.0),
}

#: Bytes a node of a finer mesh of the potential, by dimension; measured likewise: 1.22 kB for each more on a
#: line, 2.45 kB on a sheet with J = Jo, 5.6 kB in a solid with J = 1.
PER_FINE_NODE = {1: 1_300.0, 2: 2_600.0, 3: 6_500.0}

#: Bytes a node and state of the membrane beyond the first, checkpoints included: measured 51 with 18 states.
PER_STATE = 55.0


@dataclass(frozen=True)
class Size:
    """How large a case is, about; infinite where it is beyond counting.

    Args:
        cells: Cells of the mesh, the potential's where there are two.
        nodes: Nodes of it.
        unknowns: Unknowns of potential, membrane and mechanics.
        bytes: Memory of all processes together.
        steps: Time steps.
        frames: Written frames.
        output_bytes: What the frames take on the disk.
    """

    cells: float
    nodes: float
    unknowns: float
    bytes: float
    steps: float
    frames: float
    output_bytes: float


def estimate(case: Any) -> Size:
    """The size of a case, from its description alone."""
    nodes, cells = _counts(case.geometry)
    kin, dim, states = case.kinematics, _dim(case), len(case.cell.states)
    fine, cells = _refined(dim, case.potential.refinement, nodes, cells)
    unknowns = fine * (1 + states)
    if not case.is_rigid:
        # P2 has a node on each edge too: 2 a node of a line, 4 of a sheet.
        displacement = dim * (1 if kin.degree == 1 else 2**dim)
        unknowns += nodes * (displacement + kin.has_pressure)
    steps = max(1.0, case.time.end / case.time.step)
    every = case.output.every or case.time.end / 60
    frames = 2 + min(steps, case.time.end / every)
    width = WIDTHS | {"states": states}
    # Numbers a node in double precision, for ParaView and for the figures.
    frame = 16 * fine * sum(width[name] for name in set(case.output.fields))
    if "displacement" in case.output.fields and not case.is_rigid and kin.degree == 2:
        # The middles of the edges, for the figures only; of about a cube there are 7 a node.
        frame += 8 * fine * dim * (2**dim - 1)
    runs = 2 if case.output.rigid_twin else 1
    needed = _both_bytes(case, nodes, fine)
    return Size(cells, fine, unknowns, needed, steps, frames, runs * frames * frame)


def _dim(case: Any) -> int:
    """The body's dimension; of a rigid one from a file, which is not counted, the dearest."""
    return int(case.dim or 3)


def _refined(dim: int, levels: int, nodes: float, cells: float) -> tuple[float, float]:
    """Nodes and cells after refinements, by Euler's formula; in three dimensions of about a cube."""
    for _ in range(min(levels, 300) if nodes else 0):
        rim = 6 * (cells / 6) ** (2 / 3) if dim == 3 else 0.0
        edges = cells if dim == 1 else nodes + cells - 1 + rim
        nodes, cells = nodes + edges, cells * 2**dim
    return nodes, cells


def _both_bytes(case: Any, nodes: float, fine: float) -> float:
    """Memory of mechanics with so many nodes, and of the potential's own mesh with others, if it has one."""
    each = PER_FINE_NODE[_dim(case)] + _states_bytes(case)
    return _bytes(case, nodes) + (fine * each if case.potential.refinement else 0.0)


def _counts(form: Any) -> tuple[float, float]:
    """Nodes and cells of a geometry; one that does not say is not checked."""
    nodes, cells = form.counts() if hasattr(form, "counts") else (0.0, 0.0)
    return float(nodes), float(cells)


def _bytes(case: Any, nodes: float) -> float:
    """Memory of a case on one mesh."""
    if case.is_rigid:
        constant, growth = PER_FINE_NODE[_dim(case)], 0.0
    else:
        constant, growth = PER_NODE.get(type(case.kinematics), PER_NODE[kinematics.PlaneStrain])
    return BASE + nodes * (constant + _states_bytes(case) + growth * math.log2(max(2.0, nodes)))


def _states_bytes(case: Any) -> float:
    """What the membrane's states but one take at a node."""
    return PER_STATE * max(0, len(case.cell.states) - 1)


def check(case: Any, folder: Path | None, comm: Any) -> None:
    """Refuse what fits neither into memory nor on the disk; the first process looks, all learn the outcome.

    Args:
        case: The case.
        folder: Its result folder, or None.
        comm: MPI communicator.

    Raises:
        InputError: The message names the key to change, and to what.
    """
    problem = _problem(case, folder) if comm.rank == 0 else None
    problem = comm.bcast(problem, root=0)
    if problem is not None:
        raise InputError(*problem)


def _problem(case: Any, folder: Path | None) -> tuple[str, str] | None:
    """What is wrong, and the key to change."""
    for key, number in _numbers(case.parameters):
        if key == "geometry.spacing":
            continue  # is only ever divided by; below, the message says what would fit
        if math.isfinite(number) and number != 0 and not SMALLEST <= abs(number) <= LARGEST:
            return f"{number:.3g} is out of all proportion: choose other units, or zero", key
    size = estimate(case)
    if size.steps > MAX_STEPS:
        return (
            f"gives {size.steps:.2g} steps, more than {MAX_STEPS:.0e}: a step of at least "
            f"{_up(case.time.end / MAX_STEPS)}, or an earlier time.end"
        ), "time.step"
    free = free_memory()
    if size.bytes > free:
        what = (
            f"this gives about {size.nodes:.3g} nodes ({size.cells:.3g} cells) and {size.unknowns:.3g} "
            f"unknowns, which need {size.bytes / GB:.3g} GB; {free / GB:.3g} GB are free"
        )
        if case.potential.refinement and _bytes(case, _counts(case.geometry)[0]) <= free:
            return f"{what}: {_fitting(case, *_counts(case.geometry), free)}", "potential.refinement"
        return _finer(case, what, free)
    room = math.inf if folder is None else free_disk(folder)
    if size.output_bytes > room:
        frame = size.output_bytes / size.frames
        if 3 * frame > room:  # no interval helps
            return (
                f"the disk of {folder} is full: three frames of {size.nodes:.3g} nodes need "
                f"{3 * frame / GB:.2g} GB, and {room / GB:.2g} GB are free. "
                "Make room, or name a folder on another disk"
            ), "--out"
        every = case.time.end / (room / frame - 2)  # beside the first frame and the last
        return (
            f"gives about {size.frames:.3g} frames of {size.nodes:.3g} nodes, which need "
            f"{size.output_bytes / GB:.3g} GB on the disk; {room / GB:.3g} GB are free: at least "
            f"{_up(every)}, or fewer output.fields"
        ), "output.every"
    return None


def _fitting(case: Any, nodes: float, cells: float, free: float) -> str:
    """The most refinements that fit, of a mesh that fits without one."""
    dim, most = _dim(case), 0
    while _both_bytes(case, nodes, _refined(dim, most + 1, nodes, cells)[0]) <= free:
        most += 1
    return f"at most {most}"


def check_refinement(case: Any, body: Any) -> None:
    """Refuse a refinement that does not fit into memory, now that the mesh is there (collective).

    Raises:
        InputError: It does not.
    """
    if not case.potential.refinement:
        return
    nodes, cells = float(body.mesh.geometry.index_map().size_global), float(body.cells)
    fine, _ = _refined(body.dim, case.potential.refinement, nodes, cells)
    free = body.comm.bcast(free_memory(), root=0)
    if (needed := _both_bytes(case, nodes, fine)) > free:
        raise InputError(
            f"the potential's mesh would have about {fine:.3g} nodes, which need {needed / GB:.3g} GB; "
            f"{free / GB:.3g} GB are free: {_fitting(case, nodes, cells, free)}",
            "potential.refinement",
        )


def _finer(case: Any, what: str, free: float) -> tuple[str, str]:
    """The message of too fine a mesh, with the finest that would fit."""
    nodes, each = 0.0, _bytes(case, 1e6) / 1e6
    for _ in range(5):
        nodes = max(free - BASE, 0.0) / each
        each = (_bytes(case, max(nodes, 1e3)) - BASE) / max(nodes, 1e3)
    if not hasattr(case.geometry, "spacing"):
        return f"{what}: a mesh of at most {nodes:.2g} nodes", "geometry.path"
    if nodes < 100:
        return f"{what}: not even a coarse mesh fits", "geometry.spacing"
    return f"{what}: at least {_up(_spacing(case.geometry, nodes))}", "geometry.spacing"


def _spacing(form: Any, nodes: float) -> float:
    """The finest spacing at which a geometry has at most so many nodes, to a tenth of a percent."""

    def fits(spacing: float) -> bool:
        return _counts(dataclasses.replace(form, spacing=spacing))[0] <= nodes

    fine = coarse = float(form.spacing)
    while not fits(coarse):
        fine, coarse = coarse, 10 * coarse
    while coarse > 1.001 * fine:
        middle = math.sqrt(fine) * math.sqrt(coarse)
        fine, coarse = (fine, middle) if fits(middle) else (middle, coarse)
    return coarse


def _numbers(value: Any, key: str = "") -> Iterator[tuple[str, float]]:
    """The numbers of a case with their keys, but for PETSc's options."""
    if isinstance(value, Mapping):
        for name, part in value.items():
            if name != "solver" or key:
                yield from _numbers(part, f"{key}.{name}" if key else name)
    elif isinstance(value, list | tuple):
        for part in value:
            yield from _numbers(part, key)
    elif isinstance(value, int | float) and not isinstance(value, bool):
        yield key, float(min(value, 10**300) if isinstance(value, int) else value)


def _up(value: float) -> str:
    """A number with two digits, not smaller."""
    return f"{1.05 * value:.2g}"
