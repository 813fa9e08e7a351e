"""Checkpoints: a state in one file, whole or not at all, for any number of processes."""

from __future__ import annotations

import hashlib
import io
import json
import os
import re
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from myostrain.engine import fem, lasting
from myostrain.errors import InputError
from myostrain.output.folder import on_first, read_regular, write_atomically
from myostrain.output.manifest import make_folder
from myostrain.output.ordering import Ordering, gather_cells, take_cells
from myostrain.solvers.linear import global_dofs
from myostrain.state import CellState, FieldState, State

import numpy as np

if TYPE_CHECKING:
    from myostrain.coupling import Electromechanics

#: First line of every checkpoint: what it is, and the version of its format.
FORMAT = "myostrain checkpoint 3"

#: Names of the files.
NAMES = re.compile(r"step-\d{9,}\.ckpt")

#: What stands for values in cells.
CELLS = {"space", "corners", "values"}

#: How many are kept.
KEPT = 2


def spaces_of(model: Electromechanics) -> list[fem.FunctionSpace]:
    """Function spaces of what a model's state holds."""
    spaces = [model.potential.v.function_space]
    if model.mechanics is not None:
        spaces += [model.mechanics.u.function_space, model.mechanics.activation.function_space]
    return spaces


class Checkpoints:
    """The checkpoints of a run, in the folder ``checkpoint`` of its result folder.

    A file holds a line with the format's version, a line with the SHA-256 of that one and of what follows,
    and a NumPy archive of the state's arrays, in an order that does not depend on the processes, and of the
    rest as JSON.

    Args:
        folder: The result folder.
        spaces: Function spaces of the state's fields.
    """

    def __init__(self, folder: Path, spaces: Iterable[fem.FunctionSpace]) -> None:
        self.folder = folder / "checkpoint"
        self._meshes: list[Any] = []  # that of the potential first
        self._spaces = {self._label(space): space for space in spaces}
        self._orderings: dict[str, Ordering] = {}
        self._comm = lasting(next(iter(self._spaces.values())).mesh.comm)
        self._mesh: str | None = None

    def write(self, step: int, state: State) -> None:
        """Write a checkpoint after so many steps, and remove all but the last two (collective).

        Raises:
            ComputationError: It cannot be written, as on a full disk; what was there is untouched.
        """
        arrays: dict[str, Any] = {}
        tree = self._packed({**state, "mesh": self._mesh_digest()}, arrays)

        path = self.folder / f"step-{step:09d}.ckpt"

        def save() -> None:
            content = io.BytesIO()
            text = json.dumps(tree).encode()
            np.savez(content, state=np.frombuffer(text, dtype=np.uint8), **arrays)
            payload = content.getbuffer()
            make_folder(self.folder)
            header = f"{FORMAT}\n{_digest(FORMAT, payload)}\n".encode()
            write_atomically(path, header, payload)
            _sync_folder(self.folder)
            for old in self.files()[KEPT:]:
                old.unlink(missing_ok=True)

        on_first(self._comm, save, path)

    def files(self) -> list[Path]:
        """The checkpoints that are there, newest first."""
        return sorted((p for p in self.folder.glob("*.ckpt") if NAMES.fullmatch(p.name)), reverse=True)

    def latest(self) -> tuple[State | None, list[str]]:
        """The newest undamaged state, None if there is no checkpoint; and what was wrong with newer ones.

        Raises:
            InputError: All are damaged, of a newer format, or of another mesh.
        """
        found: Any = (None, {}, [])
        problem = None
        mesh = self._mesh_digest()
        if self._comm.rank == 0:
            try:
                found = self._newest()
            except InputError as error:
                problem = str(error)
        problem = self._comm.bcast(problem, root=0)
        if problem is not None:
            raise InputError(problem)
        tree, arrays, damages = self._comm.bcast(found, root=0)
        if tree is None:
            return None, damages
        if tree.pop("mesh") != mesh:
            raise InputError(
                "the mesh is not that of the checkpoint: its file, the geometry or potential.refinement was "
                "changed; put it back, or start again",
                "geometry",
            )
        return self._unpacked(tree, arrays), damages

    def _newest(self) -> tuple[Any, dict[str, Any], list[str]]:
        damages: list[str] = []
        files = self.files()
        for path in files:
            try:
                tree, arrays = _load(path)
                self._check(tree, arrays)
            except OSError as error:
                damages.append(f"{path} cannot be read: {error.strerror or error}")
            except _Damage as error:
                damages.append(f"{path} is damaged: {error}")
            else:
                return tree, arrays, damages
        if damages:
            raise InputError(
                f"no checkpoint can be used: {'; '.join(damages)}. Run the case again into another folder: "
                f"`myostrain run {self.folder.parent / 'case.toml'} --out DIR`",
                "--resume",
            )
        return None, {}, []

    def _check(self, tree: Any, arrays: Mapping[str, Any]) -> None:
        """Refuse what has a checkpoint's checksum but not its content.

        Raises:
            _Damage: It has not.
            InputError: It is that of another case.
        """
        if not isinstance(tree, dict) or not isinstance(tree.get("mesh"), str):
            raise _Damage("it holds no state")
        waiting: list[Any] = [tree]
        while waiting:
            value = waiting.pop()
            if isinstance(value, dict) and value.keys() == {"field", "array"}:
                space = self._spaces.get(value["field"]) if isinstance(value["field"], str) else None
                if space is None:
                    raise InputError(
                        "the checkpoint is that of another case; start again in another folder", "--resume"
                    )
                array, size = arrays.get(str(value["array"])), global_dofs(space)
                if array is None or array.dtype != np.float64:
                    raise _Damage("it lacks numbers of a field")
                if array.shape != (size,) and tree["mesh"] == self._mesh:
                    raise _Damage(f"a field has {array.shape} numbers in place of {size}")
            elif isinstance(value, dict) and value.keys() == CELLS:
                if value["space"] not in self._spaces:
                    raise InputError(
                        "the checkpoint is that of another case; start again in another folder", "--resume"
                    )
                corners, values = (arrays.get(str(value[name])) for name in ("corners", "values"))
                if corners is None or values is None or corners.shape != values.shape[:2]:
                    raise _Damage("it lacks numbers of some cells")
            elif isinstance(value, dict):
                waiting += value.values()
            elif isinstance(value, list):
                waiting += value

    def _ordering(self, label: str) -> Ordering:
        if label not in self._orderings:
            self._orderings[label] = Ordering(self._spaces[label])
        return self._orderings[label]

    def _label(self, space: fem.FunctionSpace) -> str:
        """What a space is called: its element, and which mesh it is on if not on the first."""
        if not any(space.mesh is mesh for mesh in self._meshes):
            self._meshes.append(space.mesh)
        number = next(i for i, mesh in enumerate(self._meshes) if mesh is space.mesh)
        return f"{space.ufl_element()}{f' on mesh {number + 1}' if number else ''}"

    def _mesh_digest(self) -> str:
        """A digest of the meshes' nodes as they were given (collective)."""
        if self._mesh is None:
            digest = hashlib.sha256()
            for geometry in (mesh.geometry for mesh in self._meshes):
                owned = geometry.index_map().size_local
                parts = self._comm.gather((geometry.input_global_indices[:owned], geometry.x[:owned]), root=0)
                if parts is not None:
                    order = np.argsort(np.concatenate([numbers for numbers, _ in parts]))
                    digest.update(np.concatenate([x for _, x in parts])[order].tobytes())
            self._mesh = str(self._comm.bcast(digest.hexdigest(), root=0))
        return self._mesh

    def _packed(self, value: Any, arrays: dict[str, Any]) -> Any:
        """A tree for JSON; its arrays go into ``arrays``, equal ones once (collective)."""
        if isinstance(value, FieldState):
            label = self._label(value.space)
            whole = self._ordering(label).gather(value.values)
            return {"field": label, "array": _put(whole, arrays)}
        if isinstance(value, CellState):
            label = self._label(value.space)
            corners, values = gather_cells(self._ordering(label), value)
            return {"space": label, "corners": _put(corners, arrays), "values": _put(values, arrays)}
        if isinstance(value, dict):
            return {key: self._packed(entry, arrays) for key, entry in value.items()}
        if isinstance(value, list | tuple):
            return [self._packed(entry, arrays) for entry in value]
        return value

    def _unpacked(self, value: Any, arrays: dict[str, Any]) -> Any:
        if isinstance(value, dict) and value.keys() == {"field", "array"}:
            label = value["field"]
            return FieldState(self._spaces[label], self._ordering(label).take(arrays[value["array"]]))
        if isinstance(value, dict) and value.keys() == CELLS:
            label = value["space"]
            corners, values = (arrays[value[name]] for name in ("corners", "values"))
            return take_cells(self._ordering(label), self._spaces[label], corners, values)
        if isinstance(value, dict):
            return {key: self._unpacked(entry, arrays) for key, entry in value.items()}
        if isinstance(value, list):
            return [self._unpacked(entry, arrays) for entry in value]
        return value


def file_digests(files: Mapping[str, Sequence[Path]], comm: Any) -> dict[str, str]:
    """A SHA-256 of the contents of a case's files, by the key that names them (collective).

    Args:
        files: The files by key.
        comm: MPI communicator; its first process reads.
    """

    def digests() -> dict[str, str]:
        found = {}
        for key, paths in files.items():
            digest = hashlib.sha256()
            for path in paths:
                with path.open("rb") as stream:
                    digest.update(hashlib.file_digest(stream, "sha256").digest())
            found[key] = digest.hexdigest()
        return found

    return dict(comm.bcast(digests() if comm.rank == 0 else None, root=0))


def _put(array: Any, arrays: dict[str, Any]) -> str:
    """Put an array among others, if there is one, under a name that equal ones share."""
    if array is None:
        return ""
    name = hashlib.blake2b(array.tobytes(), digest_size=16).hexdigest()
    arrays[name] = array
    return name


class _Damage(Exception):
    """What is wrong with a checkpoint."""


def _load(path: Path) -> tuple[Any, dict[str, Any]]:
    stream = io.BytesIO(read_regular(path))
    version, digest = stream.readline(200), stream.readline(200).strip()
    payload = stream.read()
    if not version.startswith(b"myostrain checkpoint "):
        raise _Damage("it does not begin as a checkpoint does")
    named = version.decode(errors="replace").rstrip("\n")
    if _digest(named, payload).encode() != digest:
        raise _Damage("its checksum is wrong")
    if named != FORMAT:
        raise InputError(
            f"{path} has the format {named!r}, this program reads {FORMAT!r}; resume with the version that "
            "wrote it",
            "--resume",
        )
    try:
        with np.load(io.BytesIO(payload), allow_pickle=False) as archive:
            arrays = {name: archive[name] for name in archive.files}
        return json.loads(arrays.pop("state").tobytes()), arrays
    except Exception as error:  # whatever else is packed as one
        raise _Damage(f"it holds no state ({type(error).__name__})") from error


def _digest(version: str, payload: Any) -> str:
    digest = hashlib.sha256(version.encode())
    digest.update(payload)
    return digest.hexdigest()


def _sync_folder(folder: Path) -> None:
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
