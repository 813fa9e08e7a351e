"""Random damage of gmsh files: each is read and run, or refused by a message that names the file."""

import functools
import os
import tempfile
from pathlib import Path

from myostrain import Case, ComputationError, InputError

import hypothesis
import pytest
from hypothesis import strategies as st

from mesh_files import write_mesh
from small_cases import ALONE, SHEET, changed, write_case

try:
    import gmsh  # noqa: F401
except (ImportError, OSError) as missing:
    pytest.skip(f"gmsh cannot be loaded: {missing}", allow_module_level=True)

TIMES = int(os.environ.get("MYOSTRAIN_FUZZ", "1"))

TOKENS = (b"", b"0", b"1", b"-1", b"2", b"3", b"4", b"7", b"15", b"nan", b"inf", b"1e308", b"1e-308", b"0.5")
TOKENS += (b"99999", b"2147483648", b"18446744073709551616", b"x", b'"', b"$End", b"\0", b"\xff", b"1 1")


@functools.cache
def text(version):
    """A good file of 20 × 6 in few triangles, with two regions and two named ends."""
    with tempfile.TemporaryDirectory() as folder:
        return write_mesh(Path(folder) / "body.msh", step=4.0, version=version).read_bytes()


@st.composite
def damaged(draw):
    """A file with one to three lines or numbers deleted, repeated, swapped or replaced, or cut off."""
    lines = text(draw(st.sampled_from([2.2, 4.1]))).split(b"\n")
    for _ in range(draw(st.integers(1, 3))):
        place = draw(st.integers(1, len(lines) - 1)) if len(lines) > 1 else 0
        what = draw(st.sampled_from(["delete", "repeat", "swap", "token", "token", "numbers", "flip", "cut"]))
        line = lines[place]
        tokens = line.split(b" ")
        at = draw(st.integers(0, len(tokens) - 1))
        if what == "delete":
            del lines[place]
        elif what == "repeat":
            lines.insert(draw(st.integers(1, len(lines))), line)
        elif what == "swap":
            other = draw(st.integers(0, len(lines) - 1))
            lines[place], lines[other] = lines[other], line
        elif what == "token":
            tokens[at] = draw(st.sampled_from(TOKENS))
            lines[place] = b" ".join(tokens)
        elif what == "numbers":
            other = draw(st.integers(0, len(tokens) - 1))
            tokens[at], tokens[other] = tokens[other], tokens[at]
            lines[place] = b" ".join(tokens)
        elif what == "flip" and line:
            at = draw(st.integers(0, len(line) - 1))
            lines[place] = line[:at] + bytes([line[at] ^ 1 << draw(st.integers(0, 7))]) + line[at + 1 :]
        elif what == "cut":
            lines = [*lines[:place], line[: draw(st.integers(0, len(line)))]]
    return b"\n".join(lines)


CASE = changed(
    SHEET,
    {
        "geometry": {"kind": "file", "path": "body.msh"},
        "fibres": {"direction": [2.0, 0.0]},
        "mechanics": {"kinematics": "plane-stress", "robin": 1.0},
        "initial": {"potential": 0.9, "center": [4.0, 3.0], "radius": 5.0},
        "probes": {},
    },
)


def holds(content):
    """Whether the property holds: the mesh is used for two steps, or the file is named in one line."""
    with tempfile.TemporaryDirectory() as folder:
        mesh, out = Path(folder) / "body.msh", Path(folder) / "out"
        mesh.write_bytes(content)
        try:
            file = write_case(Path(folder) / "case.toml", CASE)
            simulation, message = Case.from_file(file).simulation(ALONE, out), ""
        except InputError as error:
            message = str(error)
        if message:
            assert "\n" not in message
            assert not out.exists()
            named = "geometry.path" in message and str(mesh) in message
            # The body may be a good one of another shape: then the start of the wave may not be in it.
            assert named or message.startswith("initial."), message
            return "refused"
        try:
            simulation.model.start()
            simulation.model.step(simulation.step)
            simulation.model.step(2 * simulation.step)
        except ComputationError:
            return "fails"
        return "runs"


@hypothesis.settings(
    deadline=None,
    derandomize=TIMES == 1,
    database=None,
    max_examples=20 * TIMES,
    suppress_health_check=list(hypothesis.HealthCheck),
)
@hypothesis.given(content=damaged())
def test_damaged_mesh_runs_or_is_refused(content):
    """Requirements, "Fuzz", "Likewise mutated .msh files": no traceback, no crash of gmsh."""
    holds(content)


@pytest.mark.parametrize("version", [2.2, 4.1])
def test_the_good_file_runs(version):
    """What is damaged above is good before."""
    assert holds(text(version)) == "runs"
