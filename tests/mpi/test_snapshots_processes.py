"""A file that the first process cannot write or read is a failure of all: one message, no hanging."""

import json

import pytest

from small_cases import SHEET, write_case

DRIVER = """
import errno, json, sys
from pathlib import Path
import numpy as np
from myostrain import Case, ComputationError, InputError
from myostrain.engine import MPI
from myostrain.output.fields import FieldWriter, write_vtx

comm, folder = MPI.COMM_WORLD, Path(sys.argv[1])
model = Case.from_file(folder / "sheet.toml").build(comm)
model.start()
writer = FieldWriter(model, folder, ("potential", "displacement"))
writer.write(0, 0.0)
messages = []
savez = np.savez

def full(*_, **__):
    raise OSError(errno.ENOSPC, "No space left on device")

if comm.rank == 0:
    np.savez = full
try:
    writer.write(1, 0.1)
except ComputationError as error:
    messages.append(str(error))
np.savez = savez
writer.write(2, 0.2)
if comm.rank == 0:
    (folder / "snapshots" / "frame-000000002.npz").write_bytes(b"damaged")
comm.Barrier()
try:
    write_vtx(folder, model.potential.v.function_space)
except InputError as error:
    messages.append(str(error))
writer.close()
(folder / f"{comm.rank}.json").write_text(json.dumps(messages))
"""


@pytest.mark.mpi
def test_all_processes_learn_of_a_failure(on_processes, tmp_path):
    """folder.on_first: "every process learns of a failure"; reading for fields.bp is no different."""
    write_case(tmp_path / "sheet.toml", SHEET)
    on_processes(2, DRIVER, tmp_path)
    one, two = (json.loads((tmp_path / f"{rank}.json").read_text()) for rank in (0, 1))
    assert one == two
    assert "frame-000000001.npz cannot be written: No space left on device. Try: free space" in one[0]
    assert "frame-000000002.npz cannot be read" in one[1]
    assert sorted(path.name for path in tmp_path.iterdir()) == ["0.json", "1.json", "sheet.toml", "snapshots"]
    assert len(list((tmp_path / "snapshots").iterdir())) == 3
