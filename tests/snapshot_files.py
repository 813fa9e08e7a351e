"""Snapshots as a run writes them, written without a run."""

import shutil
from pathlib import Path

from myostrain.output.snapshots import Snapshots

import numpy as np


def frame(folder: Path, number: int) -> Path:
    """The file of a frame."""
    return folder / "snapshots" / f"frame-{number:09d}.npz"


def write_snapshots(folder: Path, points, cells, time, activation_time=None, **fields) -> None:
    """Mesh, frames 0, 1, ... and activation times; replaces what is there."""
    shutil.rmtree(folder / "snapshots", ignore_errors=True)
    (folder / "snapshots").mkdir(parents=True)
    np.savez(folder / "snapshots" / "mesh.npz", points=points, cells=cells)
    for number, t in enumerate(time):
        np.savez(frame(folder, number), time=t, **{name: values[number] for name, values in fields.items()})
    if activation_time is not None:
        np.savez(folder / "snapshots" / "activation.npz", activation_time=activation_time)


def check_vtx(folder: Path) -> None:
    """``fields.bp`` holds every time and every value of the snapshots, bit by bit, whatever the order."""
    content = b"".join(path.read_bytes() for path in (folder / "fields.bp").iterdir())
    snapshots = Snapshots(folder)
    numbers = [snapshots.times]
    for name in snapshots.names:
        numbers += [snapshots.field(name, frame).ravel() for frame in range(len(snapshots.times))]
    missing = [number for number in np.unique(np.concatenate(numbers)) if number.tobytes() not in content]
    assert missing == []
    assert len(snapshots.times) > 0
    assert np.float64(0.123456789).tobytes() not in content
    assert not (folder / ".fields.bp.part").exists()
