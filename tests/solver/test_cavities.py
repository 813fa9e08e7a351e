"""Volumes of cavities with any number of rims, against closed forms of polyhedra."""

import myostrain as ms
from myostrain.engine import fem
from myostrain.mechanics.cavity import Cavity

import numpy as np
import pytest

from small_cases import ALONE

gmsh = pytest.importorskip("gmsh", exc_type=ImportError)

#: A deformation that is no rotation, with another centre.
A = np.array([[1.1, 0.1, 0.0], [0.0, 0.9, 0.2], [0.05, 0.0, 1.2]])


@pytest.fixture(scope="module")
def block(tmp_path_factory):
    """A block [0, 6] × [0, 4] × [0, 4] with a channel along X, one up from it, and a void.

    The channels' cross-section is 2 × 2. "channel" has three rims, at X = 0, X = 6 and Z = 4, "void" none.
    """
    path = tmp_path_factory.mktemp("block") / "block.msh"
    gmsh.initialize(interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.option.setNumber("Mesh.MeshSizeMax", 1.5)
        model, shapes = gmsh.model, gmsh.model.occ
        holes = [shapes.addBox(0, 1, 1, 6, 2, 2), shapes.addBox(2, 1, 3, 2, 2, 1)]
        holes.append(shapes.addBox(0.5, 0.25, 0.25, 1, 0.5, 0.5))
        shapes.cut([(3, shapes.addBox(0, 0, 0, 6, 4, 4))], [(3, hole) for hole in holes])
        shapes.synchronize()
        inside = {"channel": [], "void": []}
        for _, surface in model.getBoundary(model.getEntities(3), oriented=False):
            x, y, z = shapes.getCenterOfMass(2, surface)
            box = np.array(model.getBoundingBox(2, surface))
            if box[1] > 0.9 and box[4] < 3.1 and box[2] > 0.9 and 0.1 < x < 5.9 and z < 3.9:
                inside["channel"].append(surface)
            elif 0.2 < y < 0.8 and 0.2 < z < 0.8 and box[4] < 1:
                inside["void"].append(surface)
        for number, (name, surfaces) in enumerate(inside.items(), 1):
            model.addPhysicalGroup(2, surfaces, number, name)
        model.addPhysicalGroup(3, [v for _, v in model.getEntities(3)], 1, "body")
        model.mesh.generate(3)
        gmsh.write(str(path))
    finally:
        gmsh.finalize()
    return ms.build(ms.geometry.MeshFile(path=path), ms.UniformFibres(direction=(1.0, 0.0, 0.0)), ALONE)


@pytest.mark.parametrize("name, rims, volume", [("channel", 3, 28.0), ("void", 0, 0.25)])
def test_volumes_of_polyhedra(block, name, rims, volume):
    """Cavity docstring: exact where rims are plane, × det A under x → A x, whatever the number of rims.

    Then a displacement that lifts columns along Z, z = Z + Y (4 − Y)/10, and so keeps a closed volume. Its
    derivative is exact, that of the lids included.
    """
    u = fem.Function(fem.functionspace(block.mesh, ("Lagrange", 2, (3,))))
    cavity = Cavity(block, name, u, 2, u)
    assert cavity.rims == rims
    assert cavity.volume() == pytest.approx(volume, rel=1e-12)
    u.interpolate(lambda X: A @ X + np.array([[30.0], [-500.0], [7.0]]) - X)
    assert cavity.volume() == pytest.approx(volume * np.linalg.det(A), rel=1e-10)
    u.interpolate(lambda X: np.stack([0 * X[0], 0 * X[0], X[1] * (4 - X[1]) / 10]))
    # All columns along Z keep their heights; but the cone over the rim at Z = 4 is no such column's end.
    assert cavity.volume() == pytest.approx(volume, rel=0.01)
    rest, gradient, moved = u.x.array.copy(), cavity.gradient(), np.random.default_rng(1)
    direction = moved.standard_normal(len(rest))
    ends = []
    for step in (1e-5, -1e-5):
        u.x.array[:] = rest + step * direction
        ends.append(cavity.volume())
    assert gradient @ direction == pytest.approx((ends[0] - ends[1]) / 2e-5, rel=1e-7)
    u.x.array[:] = rest
    if name == "void":
        assert cavity.volume() == pytest.approx(volume, rel=1e-12)
