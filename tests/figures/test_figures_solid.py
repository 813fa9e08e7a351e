"""Pictures of solids: what is seen of a body, where it is drawn, and what happens without PyVista."""

import subprocess
import sys
from pathlib import Path

import myostrain as ms
from myostrain.output.fields import FieldWriter, cell_fibres
from myostrain.output.figures import scene as figures_scene
from myostrain.output.figures import solid as figures_solid
from myostrain.output.figures.data import Recording
from myostrain.output.figures.draw import draw
from myostrain.output.figures.fibres import draw_recorded_fibres, plane_angles
from myostrain.output.figures.scene import Scene, View, looks, why_not
from myostrain.output.figures.surface import boundary, boundary_triangles, cut_open, hollow

import numpy as np
import pytest
from PIL import Image

from picture_tools import check_pictures, finish, names, pixels, share
from small_cases import command_line
from snapshot_files import write_snapshots

rendered = pytest.mark.skipif(why_not() is not None, reason=str(why_not()))

ALL = [
    "potential.png",
    "displacement.png",
    "stress.png",
    "activation-times.png",
    "fibres.png",
    "animation.gif",
]


def box(counts=(5, 3, 2), size=(10.0, 6.0, 2.0)):
    """A box in tetrahedra, six a cell, nodes and cells numbered at random, of either orientation."""
    rng = np.random.default_rng(5)
    axes = [np.linspace(0, side, count + 1) for side, count in zip(size, counts, strict=True)]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    number = np.arange(len(points)).reshape([count + 1 for count in counts])
    cells = []
    for order in np.array([(0, 1, 2), (1, 2, 0), (2, 0, 1), (0, 2, 1), (2, 1, 0), (1, 0, 2)]):
        steps = np.vstack([np.zeros(3, int), np.cumsum(np.eye(3, dtype=int)[order], axis=0)])
        corner = [
            number[tuple(slice(s, s + n) for s, n in zip(step, counts, strict=True))].ravel()
            for step in steps
        ]
        cells.append(np.column_stack(corner))
    cells = rng.permuted(rng.permutation(np.concatenate(cells)), axis=1)
    new = rng.permutation(len(points))
    moved = np.empty_like(points)
    moved[new] = points
    return moved, new[cells]


def tube(counts=(24, 3, 8), radii=(7.0, 10.0), length=20.0):
    """A tube along Z, slit open along X > 0."""
    points, cells = box(counts, (2 * np.pi, 1.0, length))
    r = radii[0] + (radii[1] - radii[0]) * points[:, 1]
    return np.column_stack([r * np.cos(points[:, 0]), r * np.sin(points[:, 0]), points[:, 2]]), cells


def volume(points, triangles):
    """Of what closed, outward triangles enclose: the divergence theorem."""
    corners = points[triangles]
    return np.linalg.det(corners).sum() / 6


def area(points, triangles):
    corners = points[triangles]
    return np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2


def solid(folder, *, points=None, cells=None, frames=4, without=(), uniform=False):
    """A box across which a pulse travels, and which is stretched along X to twice its length and bent."""
    if points is None:
        points, cells = box()
    time = np.linspace(0, 1, frames)
    s = time[:, None]
    extent = np.ptp(points[:, 0])
    v = np.exp(-(((points[:, 0] - extent * s) / (0.2 * extent)) ** 2))
    if uniform:
        v = s * np.ones(len(points))
    u = s[:, :, None] * np.column_stack([points[:, 0], 0 * points[:, 0], 0.02 * points[:, 0] ** 2])
    times = np.where(points[:, 0] > 0.8 * extent, np.nan, points[:, 0] / extent)
    fields = dict(potential=v, displacement=u, stress_trace=v - 0.5, activation_time=times)
    fields = {name: values for name, values in fields.items() if name not in without}
    write_snapshots(folder, points, cells, time, **fields)
    if "fibres" not in without:
        fibres = np.broadcast_to([1.0, 0.0, 0.0], (len(cells), 3))
        np.savez(folder / "snapshots" / "mesh.npz", points=points, cells=cells, fibres=fibres)
    return points, cells, u


# What is seen of a body.


@pytest.mark.parametrize("counts", [(1, 1, 1), (5, 3, 2)])
def test_boundary_of_a_box(counts):
    """figures_surface.boundary: two triangles a square, 4 (ab + bc + ca), outward, of the box's area."""
    a, b, c = counts
    points, cells = box(counts)
    triangles, cell = boundary_triangles(points, cells)
    assert len(triangles) == 4 * (a * b + b * c + c * a)
    assert all(set(t) <= set(k) for t, k in zip(triangles.tolist(), cells[cell].tolist(), strict=True))
    assert volume(points, triangles) == pytest.approx(10 * 6 * 2, rel=1e-12)
    assert area(points, triangles).sum() == pytest.approx(2 * (60 + 12 + 20), rel=1e-12)
    surface = boundary(points, cells)
    np.testing.assert_array_equal(surface.at(points)[surface.triangles], points[triangles])
    on_it = (np.isclose(points, 0) | np.isclose(points, [10.0, 6.0, 2.0])).any(axis=1)
    assert sorted(surface.first) == np.flatnonzero(on_it).tolist()


@pytest.mark.parametrize(
    "height, left",
    [
        (lambda x: x[:, 1] - 2.5, 10 * 3.5 * 2),  # within cells
        (lambda x: 4.5 - x[:, 1], 10 * 4.5 * 2),  # the other side
        (lambda x: x[:, 1] - 2.0, 10 * 4 * 2),  # through nodes
        (lambda x: 2 * (x[:, 0] - 5) + 3 * (x[:, 1] - 3) - (x[:, 2] - 1), 60.0),  # through the middle
        (lambda x: 1 + x[:, 0], 120.0),
    ],
    ids=["within", "other side", "nodes", "oblique", "none"],
)
def test_cut_body(height, left):
    """cut_open: the part where the height is not negative, closed and outward, of the volume that it has."""
    points, cells = box()
    h = height(points)
    surface = cut_open(points, cells, h)
    corners = surface.at(points)
    assert height(corners).min() > -1e-12
    assert volume(corners, surface.triangles) == pytest.approx(left, rel=1e-12)
    # Each edge is passed once each way: closed, up to triangles without area.
    kept = surface.triangles[area(corners, surface.triangles) > 1e-12]
    _, same = np.unique(corners.round(9), axis=0, return_inverse=True)
    edges = same[kept][:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    balance = np.zeros((len(same), len(same)), int)
    np.add.at(balance, tuple(edges.T), 1)
    assert (balance == balance.T).all()
    # Values are the linear function's own, also between nodes.
    linear = points @ [1.0, -2.0, 0.5] + 3
    np.testing.assert_allclose(surface.at(linear), corners @ [1.0, -2.0, 0.5] + 3, rtol=0, atol=1e-13)


def test_hollow():
    """hollow: a tube of radii 7 and 10 fills 0.4 of the box around it; a box all of it, even if turned."""
    points, cells = box()
    turn, _ = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))
    assert not hollow(points, cells)
    assert not hollow(points @ turn, cells)
    points, cells = tube()
    assert hollow(points, cells)
    assert hollow(points @ turn, cells)
    assert [look.name for look in looks(points, cells)] == ["cut open", "from outside"]


def test_view():
    """View: right and up are across the direction of view, and right is horizontal."""
    view = View((0.3, -1.0, 0.5))
    axes = np.vstack([view.screen, view.towards])
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-15)
    assert np.linalg.det(axes) == pytest.approx(1.0)
    assert view.screen[0, 2] == 0
    assert view.screen[1, 2] > 0


# Pictures.


@pytest.fixture
def shown(monkeypatch):
    """The corners of the surface that PyVista has at each picture, and their values."""
    seen = []
    image = Scene.image

    def spy(scene):
        mesh = scene.mesh
        values = mesh.point_data.get("values")
        seen.append((np.array(mesh.points), None if values is None else np.array(values)))
        return image(scene)

    monkeypatch.setattr(Scene, "image", spy)
    return seen


@rendered
def test_solid(tmp_path, shown):
    """draw: all pictures of a solid; what PyVista is given is X + u and v there, at each time."""
    points, _, u = solid(tmp_path)
    finish(tmp_path, {"a": [2.0, 0.0, 2.0]})
    written = draw(tmp_path)
    assert names(written) == [*ALL, "deformation.png", "probes.png"]
    check_pictures(written)
    on_it = (np.isclose(points, 0) | np.isclose(points, [10.0, 6.0, 2.0])).any(axis=1)
    run = Recording(tmp_path)
    # Four times of potential, displacement and stress; isochrones and fibres from two sides; the film's first
    # picture, then its frames.
    assert len(shown) == 3 * 4 + 2 + 2 + 1 + 4
    for pictures in (range(4), range(4, 8), range(8, 12), range(17, 21)):
        for frame, picture in enumerate(pictures):
            np.testing.assert_allclose(shown[picture][0], (points + u[frame])[on_it], atol=1e-12)
    for picture in range(12, 16):
        np.testing.assert_allclose(shown[picture][0], points[on_it], atol=1e-12)
    for frame in range(4):
        v = run.field("potential", frame)
        for picture, values in (
            (frame, v),
            (frame + 4, np.linalg.norm(u[frame], axis=1)),
            (frame + 8, v - 0.5),
            (frame + 17, v),
        ):
            np.testing.assert_allclose(shown[picture][1], values[on_it], atol=1e-12)


@rendered
def test_body_is_drawn_where_it_is(tmp_path):
    """Scene: what is not white is the deformed body, to a pixel or two, and `project` says where."""
    points, cells, u = solid(tmp_path)
    look, x = looks(points, cells)[0], points + u[-1]
    below = np.array([[-2.0, 0.0, -3.0]])  # so that the body is not in the middle
    scene = Scene(look, points, np.concatenate([points, x, below]), 0.05)
    scene.colour(np.ones(len(look.surface.first)), "viridis", figures_solid.Normalize(0, 1))
    scene.move(look.surface.at(x), np.ones(len(look.surface.first)))
    image = scene.image().astype(int)
    scene.close()
    rows, columns = np.nonzero((image < 200).any(axis=2))
    drawn = [columns.min(), columns.max(), rows.min(), rows.max()]
    places = scene.project(x)
    expected = np.array([places.min(axis=0), places.max(axis=0)]).T.ravel()
    np.testing.assert_allclose(drawn, expected, atol=2.0)  # measured: at most 1.3
    assert image.shape == (scene.size[1], scene.size[0], 3)
    low, high = scene.project(points).min(axis=0), scene.project(points).max(axis=0)
    assert (high - low)[0] < 0.7 * (places.max(axis=0) - places.min(axis=0))[0]  # else the test says little


@rendered
def test_static_case_shows_displacement(tmp_path):
    """draw_solid: a potential that is the same everywhere is not drawn, nor are isochrones."""
    solid(tmp_path, uniform=True, frames=2)
    written = draw(tmp_path)
    assert names(written) == [
        "displacement.png",
        "stress.png",
        "fibres.png",
        "animation.gif",
        "deformation.png",
    ]
    check_pictures(written)


@rendered
@pytest.mark.parametrize(
    "missing, expected",
    [
        (
            ("displacement", "stress_trace", "fibres"),
            ["potential.png", "activation-times.png", "animation.gif"],
        ),
        (("potential", "displacement", "activation_time", "fibres"), ["stress.png"]),
        (("potential", "displacement", "stress_trace", "activation_time", "fibres"), []),
    ],
)
def test_missing_fields(tmp_path, missing, expected):
    """draw: what was not recorded is left out; a rigid body is drawn at rest."""
    solid(tmp_path, frames=2, without=missing)
    written = draw(tmp_path)
    assert names(written) == expected
    check_pictures(written)


@rendered
def test_film_moves(tmp_path, monkeypatch):
    """draw_solid: at most 60 frames, with the same around the body, which is twice as long at the end."""
    monkeypatch.setattr(figures_solid, "PANELS", 1)
    solid(tmp_path, frames=70, without=("stress_trace", "activation_time", "fibres"))
    with Image.open(next(path for path in draw(tmp_path) if path.suffix == ".gif")) as film:
        assert film.n_frames == 60
        shown = []
        for frame in (0, 59):
            film.seek(frame)
            shown.append(np.asarray(film.convert("RGB")).astype(int))
        assert film.info["duration"] > 1000
    assert (shown[0][0] == 255).all()
    np.testing.assert_array_equal(shown[0][-60:], shown[1][-60:])  # colour bar and axes
    inside = [image[60:-110] for image in shown]
    widths = [np.ptp(np.nonzero(np.ptp(image, axis=2) > 40)[1]) for image in inside]
    assert widths[1] > 1.5 * widths[0]  # measured 1.8: X doubles, Y does not


@rendered
def test_isochrones(tmp_path):
    """Scene.isochrones: a band of its colour between two levels, grey where nothing was activated."""
    points, cells = box()
    look = looks(points, cells)[0]
    scene = Scene(look, points, points, 0.03)
    times = look.surface.at(np.where(points[:, 0] > 5, np.nan, points[:, 0] / 10))
    levels = np.array([0.0, 0.1, 0.2, 0.3, 0.4])
    scene.isochrones(times, levels, figures_solid.colormaps["viridis"].resampled(4))
    image = scene.image().astype(int)
    scene.close()
    bands = np.array(figures_solid.colormaps["viridis"].resampled(4)(range(4)))[:, :3] * 255
    shades = [share(image, band, tolerance=30) for band in bands]
    assert min(shades) > 0.03  # measured 0.05 to 0.1
    assert share(image, (225, 225, 225), tolerance=25) > 0.2


@rendered
def test_colours_of_fibres(tmp_path):
    """draw_recorded_fibres: fibres along X are orange, along Y dark, and not the other way round."""
    points, cells, _ = solid(tmp_path, frames=1)
    oranges = []
    for direction in ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0]):
        fibres = np.broadcast_to(direction, (len(cells), 3))
        np.savez(tmp_path / "snapshots" / "mesh.npz", points=points, cells=cells, fibres=fibres)
        picture = draw_recorded_fibres(Recording(tmp_path), tmp_path / "fibres.png")
        image = pixels(picture)[:-150]  # without the colour bar
        oranges.append(share(image, (230, 159, 0), tolerance=60))
    assert oranges[0] > 5e-3
    assert oranges[1] == 0


def test_plane_angles():
    """plane_angles: from X towards Y, of a direction without sense."""
    f0 = np.array([[1.0, 1, 0], [1, -1, 5], [-1, -1, 0], [0, 1, 0]])
    np.testing.assert_allclose(plane_angles(f0), [45.0, -45.0, 45.0, 90.0], atol=1e-12)


# On disk.


def test_fibres_are_recorded_by_cell(tmp_path):
    """FieldWriter: mesh.npz has the fibre directions at the centres of the cells, in the order of these."""
    slab = ms.geometry.Slab(size=(4.0, 2.0, 1.0), spacing=1.0)
    body = ms.build(slab, Turning())
    potential = ms.Potential(body, membrane=ms.membranes.FitzHughNagumo(), diffusivity=1.0)
    writer = FieldWriter(ms.Electromechanics(potential), tmp_path, ("potential",))
    writer.write(0, 0.0)
    run = Recording(tmp_path)
    angle = run.points[run.cells].mean(axis=1) @ [0.5, 0.1, 0.0]
    expected = np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
    np.testing.assert_allclose(run.fibres, expected, atol=1e-14)
    assert cell_fibres(body).shape == (6 * 8, 3)


class Turning:
    """Fibres whose angle is X/2 + Y/10."""

    def directions_on(self, meshed):
        """Unit directions."""
        import ufl

        x = ufl.SpatialCoordinate(meshed.mesh)
        angle = x[0] / 2 + x[1] / 10
        return ms.geometry.Microstructure(ufl.as_vector([ufl.cos(angle), ufl.sin(angle), 0 * x[0]]))


def test_sheets_and_lines_record_none(tmp_path):
    """FieldWriter: fibres are kept of solids."""
    body = ms.build(ms.geometry.Line(length=4.0, spacing=1.0))
    potential = ms.Potential(body, membrane=ms.membranes.FitzHughNagumo(), diffusivity=1.0)
    FieldWriter(ms.Electromechanics(potential), tmp_path, ("potential",))
    assert Recording(tmp_path).fibres is None


# Without PyVista.


@pytest.fixture
def anew():
    """What was found out about this machine is forgotten, before and afterwards."""
    why_not.cache_clear()
    yield
    why_not.cache_clear()


def test_without_pyvista(tmp_path, monkeypatch, anew):
    """Without the extra a run or plot does not fail: a warning says how to get pictures."""
    solid(tmp_path)
    finish(tmp_path, {"a": [2.0, 0.0, 2.0]})
    monkeypatch.setitem(sys.modules, "vtkmodules.vtkRenderingCore", None)
    done = command_line("plot", tmp_path)
    assert done.status == 0
    assert done.out.split() == [
        str(tmp_path / "figures" / name) for name in ("deformation.png", "probes.png")
    ]
    assert "pip install 'myostrain[render]'" in done.err
    assert f"myostrain plot {tmp_path}" in done.err


def test_without_opengl(tmp_path, monkeypatch, anew):
    """VTK ends the process where there is no OpenGL (measured: signal 11), so a process of its own tries."""
    pytest.importorskip("pyvista")
    solid(tmp_path)
    ended = subprocess.CompletedProcess([], -11, "", "")
    monkeypatch.setattr(figures_scene.subprocess, "run", lambda *a, **k: ended)
    done = command_line("plot", tmp_path)
    assert (done.status, [Path(line).name for line in done.out.split()]) == (0, ["deformation.png"])
    assert "apt install libegl1" in done.err
    points, cells = box()
    look = looks(points, cells)[0]
    with pytest.raises(ms.InputError, match="OpenGL"):
        Scene(look, points, points, 0.1)
