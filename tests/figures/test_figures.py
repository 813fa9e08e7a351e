"""Pictures of result folders that are written here, without a solver."""

import json

from myostrain.errors import InputError
from myostrain.output.figures.choice import Choice
from myostrain.output.figures.course import deformation_over_time
from myostrain.output.figures.data import Recording
from myostrain.output.figures.draw import draw
from myostrain.output.figures.line import leading_edge, resampled, sorted_line, telling_frames
from myostrain.output.figures.maps import band_levels
from myostrain.output.figures.measures import forces
from myostrain.output.figures.sheet import boundary_edges, film_frames
from myostrain.output.figures.style import plain, potential_range, symmetric_range
from myostrain.output.frames import Frames

import matplotlib as mpl
import numpy as np
import pytest
from PIL import Image

from picture_tools import bump, check_pictures, finish, names, pixels, share
from snapshot_files import frame, write_snapshots

LINE = ["potential.png", "evolution.png", "space-time.png", "deformation.png"]
SHEET = ["potential.png", "stress.png", "activation-times.png", "animation.gif", "deformation.png"]


def line(folder, speed, *, moves=True, frames=7, length=100):
    X = np.random.default_rng(1).permutation(np.arange(length + 1.0))
    order = np.argsort(X)
    time = np.linspace(0, 1, frames)
    v = bump(X - speed * time[:, None])
    fields = dict(potential=v, recovery=v / 4)
    if moves:
        fields.update(displacement=-0.05 * X[:, None] * np.ones((frames, 1, 1)), stress_trace=0 * v)
    write_snapshots(folder, X[:, None], np.column_stack([order[:-1], order[1:]]), time, **fields)
    return X


def sheet(folder, *, n=20, frames=5, without=()):
    """A rectangle 60 x 90, squeezed to half its width at the end, numbered at random."""
    i, j = (k.ravel() for k in np.meshgrid(np.arange(n), np.arange(n)))
    corner = i + (n + 1) * j
    cells = np.concatenate(
        [corner[:, None] + [0, 1, n + 2], corner[:, None] + [0, n + 2, n + 1]],
    )
    grid = np.stack(np.meshgrid(np.linspace(0, 60, n + 1), np.linspace(0, 90, n + 1)), axis=-1).reshape(-1, 2)
    number = np.random.default_rng(2).permutation(len(grid))
    points = np.empty_like(grid)
    points[number] = grid
    time = np.linspace(0, 1, frames)
    r = np.hypot(*(points - [60, 0]).T)
    v = bump(r - 60 * time[:, None])
    squeeze = -0.5 * time[:, None, None] * points * [1, 0]
    activation = np.where(r > 60, np.nan, r / 60)
    fields = dict(potential=v, displacement=squeeze, stress_trace=v - 0.5, activation_time=activation)
    fields = {k: a for k, a in fields.items() if k not in without}
    write_snapshots(folder, points, number[cells], time, **fields)
    return points, number[cells]


BLUE, VERMILION = (0, 114, 178), (213, 94, 0)


def test_line_with_rigid_twin(tmp_path):
    line(tmp_path, 60.0)
    finish(
        tmp_path,
        {"a": [10.0, 0, 0], "_b $": [20.0, 0, 0]},
        celerity=60.0,
        width_material=16.0,
        width_spatial=15.0,
    )
    line(tmp_path / "rigid", 50.0, moves=False)
    finish(tmp_path / "rigid", celerity=50.0, width_material=20.0, width_spatial=20.0)
    written = draw(tmp_path)
    assert names(written) == [*LINE, "probes.png"]
    check_pictures(written)
    assert share(pixels(written[0]), VERMILION) > 1e-3


def test_line_without_twin(tmp_path):
    line(tmp_path, 60.0)
    finish(tmp_path, celerity=60.0, width_material=None)
    written = draw(tmp_path)
    assert names(written) == LINE
    check_pictures(written)
    image = pixels(written[0])
    assert share(image, VERMILION) == 0
    assert share(image, BLUE) > 1e-3


def test_rigid_line_has_one_panel(tmp_path):
    line(tmp_path / "moves", 60.0)
    line(tmp_path / "rigid", 60.0, moves=False)
    heights = [len(pixels(draw(tmp_path / name)[0])) for name in ("moves", "rigid")]
    assert heights[1] < 0.7 * heights[0]


def test_pulse_is_drawn_where_it_is(tmp_path):
    """Unsorted nodes give one clean curve, whose peak in the picture sits at the right share of the axis."""
    line(tmp_path, 60.0, moves=False)
    image = pixels(draw(tmp_path)[0])
    rows, columns = np.nonzero(np.abs(image - np.array(BLUE)).max(axis=-1) < 10)
    peak = columns[rows < rows.min() + 0.5 * np.ptp(rows)]
    peak = peak[peak < 0.7 * image.shape[1]]  # the legend is at the right
    place = (np.median(peak) - columns.min()) / np.ptp(columns)
    assert place == pytest.approx(0.6, abs=0.02)


def test_space_time_shows_the_front_moving(tmp_path):
    line(tmp_path, 60.0, frames=41)
    image = pixels(draw(tmp_path)[2])
    rows, columns = np.nonzero((image[..., 0] > 220) & (image[..., 1] > 200) & (image[..., 2] < 90))
    inside = columns < 0.7 * image.shape[1]  # not the colour bar
    rows, columns = rows[inside], columns[inside]
    assert np.corrcoef(rows, columns)[0, 1] < -0.95  # rightwards as time goes up


def test_sheet(tmp_path):
    sheet(tmp_path)
    finish(tmp_path, {"corner": [50.0, 10.0, 0.0], "far": [10.0, 80.0, 0.0]})
    written = draw(tmp_path)
    assert names(written) == [*SHEET, "probes.png"]
    check_pictures(written)


def test_sheet_is_drawn_deformed_with_equal_axes(tmp_path):
    """The body, 60 x 90, ends squeezed to 30 x 90, and a unit is as long across as up."""
    sheet(tmp_path)
    image = pixels(draw(tmp_path, Choice(times=[1.0]))[0])
    coloured = np.ptp(image, axis=-1) > 40
    coloured[:, int(0.8 * image.shape[1]) :] = False  # the colour bar
    rows, columns = np.nonzero(coloured)
    assert np.ptp(columns) / np.ptp(rows) == pytest.approx(30 / 90, rel=0.03)


def test_never_activated_part_is_grey(tmp_path):
    sheet(tmp_path)
    image = pixels(draw(tmp_path)[2])
    assert share(image, (228, 228, 228), tolerance=3) > 0.02


def test_film(tmp_path):
    sheet(tmp_path, n=6, frames=150)
    with Image.open(draw(tmp_path)[3]) as film:
        count = film.n_frames
        assert count <= 60
        shown = []
        for frame in (0, count - 1):
            film.seek(frame)
            shown.append(np.asarray(film.convert("RGB")).astype(int))
        assert film.info["duration"] > 1000  # the last one stays
    widths = [np.ptp(np.nonzero((np.ptp(im, axis=-1) > 40)[:, : im.shape[1] * 3 // 4])[1]) for im in shown]
    assert widths[1] / widths[0] == pytest.approx(0.5, abs=0.05)


@pytest.mark.parametrize(
    "missing, expected",
    [
        (("activation_time",), ["potential.png", "stress.png", "animation.gif", "deformation.png"]),
        (("stress_trace",), ["potential.png", "activation-times.png", "animation.gif", "deformation.png"]),
        (("displacement",), SHEET[:-1]),
        (("potential",), ["stress.png", "activation-times.png", "deformation.png"]),
        (("potential", "displacement", "stress_trace", "activation_time"), []),
    ],
)
def test_missing_fields(tmp_path, missing, expected):
    sheet(tmp_path, n=5, frames=2, without=missing)
    written = draw(tmp_path)
    assert names(written) == expected
    check_pictures(written)


def test_single_frame_gives_no_film(tmp_path):
    sheet(tmp_path, n=5, frames=1)
    assert names(draw(tmp_path)) == ["potential.png", "stress.png", "activation-times.png"]


@pytest.mark.parametrize("times", [np.nan, 0.5])
def test_nothing_to_contour(tmp_path, times):
    points, _ = sheet(tmp_path, n=5, frames=2, without=("potential",))
    np.savez(tmp_path / "snapshots" / "activation.npz", activation_time=np.full(len(points), times))
    assert names(draw(tmp_path)) == ["stress.png", "deformation.png"]


def test_run_that_failed_half_way(tmp_path):
    """No results, no activation times, half a file of the last frame, half a row of probes."""
    X = line(tmp_path, 60.0, frames=5)
    last = frame(tmp_path, 4)
    last.with_name(f".{last.name}.part").write_bytes(last.read_bytes()[:1000])
    last.unlink()
    (tmp_path / "case.toml").write_text('title = "Failed"\n[probes]\na = [10.0]\n')
    (tmp_path / "probes.csv").write_text("time,a_potential,a_recovery\n0,0.1,0\n0.1,0.2,0\n0.2,0.3\n")
    run = Recording(tmp_path)
    assert run.time.tolist() == [0, 0.25, 0.5, 0.75]
    assert run.field("potential").shape == X.shape
    assert run.field("potential") == pytest.approx(bump(X - 45.0), abs=1e-6)
    assert run.activation() is None
    assert "not finished" in run.title
    assert run.probes["a"].tolist() == [10.0]
    times, histories = run.probe_histories("potential")
    assert times.tolist() == [0, 0.1]
    assert histories["a"].tolist() == [0.1, 0.2]
    written = draw(tmp_path)
    assert names(written) == [*LINE, "probes.png"]
    check_pictures(written)


def test_twin_is_shown_at_the_same_time(tmp_path):
    """A contracting run that stopped at a third is compared with the twin's frame of that time."""
    line(tmp_path, 60.0, frames=7)
    line(tmp_path / "rigid", 60.0, moves=False, frames=7)
    for number in range(3, 7):
        frame(tmp_path, number).unlink()
    image = pixels(draw(tmp_path)[0])
    image = image[len(image) // 2 :]  # over X, where the two coincide and the dashes hide under the line
    assert share(image[: int(0.9 * len(image)), : int(0.7 * image.shape[1])], VERMILION) < 5e-4


def test_no_frame(tmp_path):
    write_snapshots(tmp_path, np.zeros((2, 1)), [[0, 1]], np.empty(0), potential=np.empty((0, 2)))
    assert draw(tmp_path) == []


def test_solid_gives_its_probes(tmp_path):
    points, cells = np.eye(4, 3), [[0, 1, 2, 3]]
    write_snapshots(tmp_path, points, cells, [0.0, 1.0], potential=np.zeros((2, 4)))
    finish(tmp_path, {f"p{i}": [0, 0, 0] for i in range(9)})
    written = draw(tmp_path)
    assert names(written) == ["probes.png"]
    check_pictures(written)


def test_empty_folder(tmp_path):
    with pytest.raises(InputError, match=r"holds no frames.*result folder"):
        draw(tmp_path)
    with pytest.raises(InputError, match="typo is not there"):
        draw(tmp_path / "typo")
    assert list(tmp_path.iterdir()) == []


def test_unreadable_files(tmp_path):
    line(tmp_path, 60.0)
    (tmp_path / "case.toml").write_text("title = ")
    with pytest.raises(InputError, match=r"case.toml cannot be read"):
        draw(tmp_path)
    (tmp_path / "case.toml").unlink()
    (tmp_path / "probes.csv").write_text("time,a_potential\n0,none\n")
    with pytest.raises(InputError, match=r"probes.csv cannot be read"):
        draw(tmp_path)


def test_folder_that_cannot_be_written(tmp_path):
    line(tmp_path, 60.0)
    (tmp_path / "figures").write_text("a file in the way")
    with pytest.raises(InputError, match="figures cannot be written"):
        draw(tmp_path)


def test_users_settings_stay(tmp_path):
    line(tmp_path, 60.0)
    with mpl.rc_context({"figure.facecolor": "red", "lines.linewidth": 7.0}):
        before = {
            key: dict.__getitem__(mpl.rcParams, key) for key in mpl.rcParams
        }  # would choose a backend else
        check_pictures(draw(tmp_path))
        assert {key: dict.__getitem__(mpl.rcParams, key) for key in mpl.rcParams} == before


def test_deformed_points(tmp_path):
    points, _ = sheet(tmp_path, n=4, frames=3)
    run = Recording(tmp_path)
    assert run.deformed(0) == pytest.approx(points)
    assert run.deformed() == pytest.approx(points * [0.5, 1])
    assert run.deformed(1) == pytest.approx(points * [0.75, 1])
    sheet(tmp_path, n=4, without=("displacement",))
    run = Recording(tmp_path)
    assert run.deformed() == pytest.approx(points)


def test_labels(tmp_path):
    line(tmp_path, 60.0)
    run = Recording(tmp_path)
    assert run.label("x", "length") == "x"
    assert run.label("v", "potential") == "v"
    assert run.heading.endswith(", non-dimensional")
    run.case = {"units": {"length": "mm"}}
    assert run.label("x", "length") == "x (mm)"
    assert run.label("t", "time") == "t"
    assert plain("$5") == r"\$5"


def test_sorted_line():
    X, v = sorted_line(np.array([2.0, 0.0, 1.0]), np.array([[20.0, 0.0, 10.0], [21.0, 1.0, 11.0]]))
    assert X.tolist() == [0, 1, 2]
    assert v.tolist() == [[0, 10, 20], [1, 11, 21]]


def test_telling_frames():
    X = np.arange(300.0)
    travelling = bump(X - 2 * np.arange(101)[:, None] - 40)
    assert telling_frames(travelling, 6) == [0, 20, 40, 60, 80, 100]
    decaying = 0.9 ** np.arange(101)[:, None] * bump(X)
    frames = telling_frames(decaying, 6)
    assert frames[0] == 0
    assert frames[-1] == 100
    assert frames[-2] < 20
    assert telling_frames(np.zeros((4, 9)), 6) == [0, 3]
    assert telling_frames(np.zeros((1, 9)), 6) == [0]


def test_leading_edge():
    X = np.array([0.0, 1.0, 2.0, 4.0, 5.0])
    v = np.array([[1, 0.25, 1, 0, 0], [0, 0, 0, 0, 0], [1, 1, 1, 1, 1.0]])
    assert leading_edge(X, v) == pytest.approx([3.0, np.nan, np.nan], nan_ok=True)


def test_resampled():
    at = np.array([0.0, 1.0, 4.0])
    values = np.column_stack([3 * at + 1, at * 0])
    assert resampled(values, at, 9) == pytest.approx(np.column_stack([1.5 * np.arange(9) + 1, np.zeros(9)]))


def test_boundary_edges():
    square = np.array([[0, 1, 2], [2, 1, 3]])
    assert boundary_edges(square).tolist() == [[0, 1], [0, 2], [1, 3], [2, 3]]


def test_film_frames():
    assert film_frames(3) == [0, 1, 2]
    assert film_frames(61, 60)[:2] == [0, 1]
    chosen = film_frames(1000, 60)
    assert len(chosen) == 60
    assert (chosen[0], chosen[-1]) == (0, 999)


def test_band_levels():
    levels = band_levels(np.array([0.0, np.nan, 2.96]))
    assert levels[0] == 0
    assert levels[-1] == 3
    assert np.ptp(np.diff(levels)) < 1e-12
    assert len(band_levels(np.array([np.nan]))) == 0
    assert len(band_levels(np.array([1.0, 1.0]))) == 0


def test_ranges():
    assert potential_range(np.array([-0.3, 1.1])) == (-0.2, 1.0)
    assert potential_range(np.array([0.0, 1.28])) == (-0.2, 1.28)  # a plateau is not cut
    assert potential_range(np.array([-85.0, 40.0])) == (-85, 40)
    stress = np.append(np.full(10_000, -0.5), 1e6)
    assert symmetric_range(stress) == (-0.5, 0.5)
    assert symmetric_range(np.zeros(3)) == (-1, 1)


def test_maps_tips_and_electrodes(tmp_path):
    """APD, velocity, tip and electrodes are drawn where there are any; a map without a whole cell is not."""
    points, _ = sheet(tmp_path)
    r = np.hypot(*(points - [60, 0]).T)
    begun = np.where(r > 60, np.nan, r / 60)
    lone = np.where(np.arange(len(r)) == r.argmin(), 1.0, np.nan)
    np.savez(
        tmp_path / "snapshots" / "activation.npz",
        activation_time=begun,
        activation_times=begun[None],
        repolarization_times_90=begun[None] + 0.3 + r / 600,
        repolarization_times_50=begun[None] + lone,
        conduction_velocity=np.where(r < 5, np.nan, 60 + 0 * r)[None],
    )
    finish(tmp_path, {"a": [50.0, 10.0, 0.0]})
    t = np.linspace(0, 1, 40)
    X = np.column_stack([30 + 10 * np.cos(9 * t), 45 + 10 * np.sin(9 * t)])
    tips = np.column_stack([t, X, X * [0.5, 1], np.ones_like(t)])
    np.savetxt(tmp_path / "tip.csv", tips, delimiter=",", header="time,X,Y,x,y,sense", comments="")
    ecg = np.column_stack([t, np.sin(t), np.cos(t)])
    np.savetxt(tmp_path / "ecg.csv", ecg, delimiter=",", header="time,V1,V2", comments="")
    written = draw(tmp_path)
    maps = ["activation-times.png", "apd90.png", "conduction-velocity.png"]
    expected = ["potential.png", "stress.png", *maps, "animation.gif", "tip.png"]
    expected += ["deformation.png", "probes.png", "ecg.png"]
    assert names(written) == expected
    check_pictures([path for path in written if path.name != "conduction-velocity.png"])  # of one colour
    wide, high = pixels(tmp_path / "figures" / "tip.png").shape[1::-1]
    assert wide > 1.3 * high  # two panels: the reference body and space


def test_a_sheet_is_shown_at_several_times_with_a_scale_bar(tmp_path):
    """Without --times up to six, as a solid is; each panel to one scale, a bar of a round length below."""
    sheet(tmp_path)
    image = pixels(draw(tmp_path, Choice(fields=["potential"]))[0])
    body = np.ptp(image[: int(0.85 * len(image))], axis=-1) > 40
    gaps = np.flatnonzero(np.diff(body.any(axis=0).astype(int)) == 1)
    assert len(gaps) == len(telling_frames(Recording(tmp_path).history("potential"), 5)) > 3
    bar = np.abs(image - 0x44).max(axis=-1) < 8
    longest = max(np.bincount(np.cumsum(~row)[row]).max() for row in bar if row.any())
    first = np.flatnonzero(body.any(axis=0))
    wide = np.flatnonzero(np.diff(first) > 1)[0] + 1  # of the first panel: 60 wide
    assert longest / wide == pytest.approx(20 / 60, rel=0.1)


def test_deformation_over_time(tmp_path):
    """A rectangle that is squeezed to half its width: |u| and J are those of the formula."""
    sheet(tmp_path)
    found = deformation_over_time(Frames(Recording(tmp_path)))
    np.testing.assert_allclose(found["displacement"], 30 * np.linspace(0, 1, 5), atol=1e-12)
    np.testing.assert_allclose(found["J"], np.tile(1 - 0.5 * np.linspace(0, 1, 5), (3, 1)), atol=1e-12)
    assert "fibre_stretch" not in found  # no fibres were written
    line(tmp_path / "line", 60)
    found = deformation_over_time(Frames(Recording(tmp_path / "line")))
    np.testing.assert_allclose(found["fibre_stretch"], 0.95, atol=1e-12)
    assert "J" not in found


def test_probes_show_what_moves_and_what_contracts(tmp_path):
    """A panel each of the potential, of the activation and of |u|, where there is any."""
    line(tmp_path, 60)
    finish(tmp_path, {"a": [10.0, 0, 0]})
    heights = []
    for activation, u in ((0.0, 0.0), (0.0, 0.1), (-0.2, 0.1)):
        rows = [f"{t},{t},{activation * t},{u * t}" for t in (0.0, 0.5, 1.0)]
        head = "time,a_potential,a_activation,a_displacement_x"
        (tmp_path / "probes.csv").write_text("\n".join([head, *rows, ""]))
        (path,) = draw(tmp_path, Choice(dpi=50, fields=["probes"]))
        heights.append(len(pixels(path)))
    assert np.diff(heights) == pytest.approx([100, 100], abs=2)


@pytest.mark.parametrize("unit", [1.0, 1e-6, 1e6])
def test_forces_that_vanish_are_not_drawn(tmp_path, unit):
    """Whatever the unit: a sum of springs all round vanishes beside the modulus, or beside another force."""
    points, cells = sheet(tmp_path / "sheet")
    for name, about in (("run", {"modulus": unit}), ("plain", {})):
        write_snapshots(tmp_path / name, points, cells, [0.0, 1.0], potential=np.zeros((2, len(points))))
        mesh = tmp_path / name / "snapshots" / "mesh.npz"
        np.savez(mesh, points=points, cells=cells, about=json.dumps(about))
    sums = {"reaction_boundary_x": unit * np.array([0.0, -2e-7]), "volume_ratio": np.ones(2)}
    both = sums | {"reaction_left_x": unit * np.array([0.0, 0.1])}
    assert forces(Recording(tmp_path / "run"), sums) == []
    assert forces(Recording(tmp_path / "run"), both) == ["reaction_left_x"]
    assert forces(Recording(tmp_path / "plain"), both) == ["reaction_left_x"]
