"""A mesh from a file: of gmsh, openCARP, VTK, or a folder of cardiac-geometriesx."""

from __future__ import annotations

import mmap
import re
import tempfile
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from myostrain.errors import InputError
from myostrain.geometry import heart_folder, opencarp, vtu
from myostrain.geometry.checks import check
from myostrain.geometry.foreign import read_alone, readable
from myostrain.geometry.gmsh_model import says, to_meshed
from myostrain.geometry.mesh_arrays import MeshArrays, spread_out
from myostrain.geometry.meshed import Meshed
from myostrain.validation import Positive, description

#: Bytes of a file for one node and its cells, at least; measured: 90 to 104 for a sheet of 28,168 nodes,
#: MSH 2.2 and 4.1, text and binary.
NODE_BYTES = 80


@description
class MeshFile:
    """A mesh of straight cells from a file, whose format its ending says.

    - ``.msh`` of gmsh: lines, triangles or tetrahedra. The physical groups of the highest dimension are the
      body and its regions, those one dimension lower the boundaries that ``mechanics.fixed`` and others
      name. Groups with the same name are one part.
    - ``.pts``, ``.elem`` of openCARP: tetrahedra, whose tags are regions; boundaries are surfaces, in
      STEM.NAME.surf or in the files that ``boundaries`` names.
    - ``.vtu``, ``.vtk``: tetrahedra and, for boundaries, triangles, both with tags (PyVista reads them).
    - A folder of cardiac-geometriesx: mesh.xdmf and markers.json. ENDO, EPI, BASE, ENDO_LV and ENDO_RV are
      endocardium, epicardium, base, endocardium_left and endocardium_right.

    Args:
        path: The file. In a case file, relative to the case file's folder.
        scale: Factor on the coordinates, not for .msh: 1e-3 makes mm of the micrometres of openCARP.
        tags: Name of the data with the tags in a .vtu; the first of the usual ones unless given.
        boundaries: Names of boundaries: their tags in a .vtu, their .surf files of openCARP.
        regions: Names of regions, and their tags, in a .vtu.
    """

    path: Path
    scale: Positive = 1.0
    tags: str | None = None
    boundaries: Mapping[str, int | str] | None = None
    regions: Mapping[str, int] | None = None

    @property
    def files(self) -> tuple[Path, ...]:
        """What is read: a run is resumed with the same only."""
        if self.path.suffix in opencarp.ENDINGS:
            return opencarp.files_of(self.path, self.boundaries)
        return heart_folder.files_of(self.path) if self.path.is_dir() else (self.path,)

    def mesh(self, comm: Any) -> Meshed:
        """Read the file and spread the mesh over the processes of ``comm``.

        Raises:
            InputError: The file is missing, empty or unreadable, has no physical group for its cells, cells
                of another kind than straight lines, triangles or tetrahedra, cells of no size or inverted
                ones, nodes that no cell uses, or parts that do not hang together.
        """
        if (read := self._reader()) is not None:
            return spread_out(comm, read)

        def make(gmsh: Any) -> int:
            open_safely(gmsh, self.path, "geometry.path")
            dim = int(gmsh.model.getDimension())
            if dim < 0:
                raise InputError(
                    f"{self.path} has no cells: was it saved before it was meshed?", "geometry.path"
                )
            declared = declared_groups(self.path)
            join_namesakes(gmsh.model, dim, declared)
            check(gmsh.model, dim, self.path, declared)
            tags, _, _ = gmsh.model.mesh.getNodes()
            if tags.max() > len(tags):  # DOLFINx wants numbers without gaps
                gmsh.model.mesh.renumberNodes()
            return dim

        return to_meshed(comm, make, str(self.path), "geometry.path")

    def _reader(self) -> Callable[[], MeshArrays] | None:
        """What reads the file; None where gmsh does.

        Raises:
            InputError: A key is not for this format.
        """
        is_opencarp, is_folder = self.path.suffix in opencarp.ENDINGS, self.path.is_dir()
        for key, others in (
            ("tags", False),
            ("regions", False),
            ("boundaries", is_opencarp),
            ("scale", True),
        ):
            given = getattr(self, key) not in (None, 1.0)
            allowed = vtu.is_vtk(self.path) or (others and (key != "scale" or is_opencarp or is_folder))
            if given and not allowed:
                raise InputError(f"this is not for {self.path.name}; leave it out", f"geometry.{key}")
        if is_opencarp:
            return lambda: opencarp.read_opencarp(self.path, self.boundaries, self.scale)
        if vtu.is_vtk(self.path):
            return lambda: vtu.read_vtu(self.path, self.tags, self.boundaries, self.regions, self.scale)
        return (lambda: heart_folder.read_folder(self.path, self.scale)) if is_folder else None

    def counts(self) -> tuple[float, float]:
        """How many nodes and cells the file has at most, by its size, before anything reads it."""
        try:
            nodes = self.path.stat().st_size / NODE_BYTES
        except (OSError, ValueError):
            nodes = 0.0  # who reads it will say why
        return nodes, 2 * nodes


def declared_groups(path: Path) -> dict[tuple[int, int], str]:
    """Names of physical groups by dimension and tag, as the file has them.

    gmsh itself keeps a name for the first group only that has it.

    Raises:
        InputError: A name is not UTF-8.
    """
    with path.open("rb") as stream, mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ) as content:
        begin = content.find(b"\n$PhysicalNames")
        section = b"" if begin < 0 else content[begin : content.find(b"\n$End", begin + 1)]
    try:
        found = re.findall(r'^\s*(\d+)\s+(\d+)\s+"([^"\n]*)"', section.decode(), re.MULTILINE)
    except UnicodeDecodeError as error:
        raise InputError(
            f"{path} has a physical group whose name is not UTF-8; save in UTF-8, or rename it",
            "geometry.path",
        ) from error
    return {(int(dim), int(tag)): name for dim, tag, name in found}


def join_namesakes(model: Any, dim: int, declared: dict[tuple[int, int], str]) -> None:
    """Make one group of the physical groups that have one name and dimension."""
    groups: dict[tuple[int, str], list[int]] = {}
    for d, tag in model.getPhysicalGroups():
        if d in (dim, dim - 1) and (name := declared.get((d, tag))):
            groups.setdefault((d, name), []).append(tag)
    for (d, name), tags in groups.items():
        if len(tags) > 1:
            parts = {int(part) for tag in tags for part in model.getEntitiesForPhysicalGroup(d, tag)}
            model.removePhysicalGroups([(d, tag) for tag in tags])
            model.addPhysicalGroup(d, sorted(parts), tags[0], name)


def open_safely(gmsh: Any, path: Path, key: str) -> None:
    """Read a ``.msh`` file into gmsh, nothing else, as a gmsh of its own has understood and written it.

    A damaged file may make gmsh write where it should not. That need not kill it at once: what it has read
    never comes into this process but by a sound file.

    Args:
        gmsh: The module, in a session.
        path: The file.
        key: Key of a case file that names it, for messages.

    Raises:
        InputError: The file is missing, empty, no mesh, or damaged.
    """
    readable(path, key)
    _check_header(path, key)
    with _alone(path) as name, says(path, key, name):
        sound = Path(name).with_name("sound.msh")
        with suppress(OSError):  # no second process can be started here
            status, _, words = read_alone(READ, name, str(sound), path=path, key=key, reader="gmsh")
            if status:
                raise RuntimeError(words.strip().rpartition("\n")[2] or "it cannot be read")
            sound.replace(name)
        gmsh.open(name)


def _check_header(path: Path, key: str) -> None:
    """Refuse what is not a mesh: gmsh takes any other text for a script, and runs it."""
    with path.open("rb") as stream:
        begin = stream.read(80)
    if not begin.startswith(b"$MeshFormat"):
        raise InputError(
            f"{path} is not a gmsh mesh: it does not begin with $MeshFormat; mesh and export as .msh",
            key,
        )


@contextmanager
def _alone(path: Path) -> Iterator[str]:
    """The file's name in an empty folder: gmsh runs NAME.opt beside a file, and goes by its ending."""
    with tempfile.TemporaryDirectory() as folder:
        link = Path(folder) / "body.msh"
        link.symlink_to(path.resolve())
        yield str(link)


#: Reads a file in a process of its own, and writes it again: mesh, groups and fields.
READ = """
import sys, gmsh
gmsh.initialize(interruptible=False)
for option, value in {
    "General.Terminal": 0, "Mesh.Binary": 1, "Mesh.SaveAll": 1, "PostProcessing.SaveMesh": 0
}.items():
    gmsh.option.setNumber(option, value)
try:
    gmsh.open(sys.argv[1])
    gmsh.write(sys.argv[2])
    for view in gmsh.view.getTags():
        gmsh.view.write(view, sys.argv[2], append=True)
except Exception as error:
    sys.exit(" ".join(str(error).split()))
"""
