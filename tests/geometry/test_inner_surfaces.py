"""A named surface inside the body is no boundary: whatever names it as one is refused."""

import myostrain as ms
from myostrain import Case, InputError
from myostrain.engine import fem
from myostrain.mechanics.cavity import Cavity

import pytest

from small_cases import ALONE

gmsh = pytest.importorskip("gmsh", exc_type=ImportError)


@pytest.fixture(scope="module")
def halves(tmp_path_factory):
    """Two cubes side by side; "left" and "right" at the ends, "middle" between them."""
    path = tmp_path_factory.mktemp("halves") / "halves.msh"
    gmsh.initialize(interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.option.setNumber("Mesh.MeshSizeMin", 1.0)
        model, shapes = gmsh.model, gmsh.model.occ
        cubes = [(3, shapes.addBox(x, 0, 0, 1, 1, 1)) for x in (0, 1)]
        shapes.fragment(cubes[:1], cubes[1:])
        shapes.synchronize()
        ends = {}
        for _, surface in model.getEntities(2):
            x, _, _ = shapes.getCenterOfMass(2, surface)
            ends.setdefault(round(x, 6), []).append(surface)
        for number, (name, x) in enumerate({"left": 0.0, "right": 2.0, "middle": 1.0}.items(), 1):
            model.addPhysicalGroup(2, ends[x], number, name)
        model.addPhysicalGroup(3, [1, 2], 1, "body")
        model.mesh.generate(3)
        gmsh.write(str(path))
    finally:
        gmsh.finalize()
    return path


def case(path, mechanics=(), **sections):
    return Case.from_dict(
        {
            "geometry": {"kind": "file", "path": str(path)},
            "fibres": {"direction": [1.0, 0.0, 0.0]},
            "mechanics": {"kinematics": "solid", **dict(mechanics)},
            "time": {"step": 1.0, "end": 1.0},
            **({"drive": {"potential": 0.0}} if "initial" not in sections else {}),
            **sections,
        }
    )


BUMP = {"potential": 1.0, "boundary": ["middle"]}
WALL = {"transmural": [1.0, 0.5], "transmural_between": ["left", "middle"]}
RULES = {"kind": "rule-based", "endocardium": "left", "epicardium": "middle", "base": "right"}
KEYS = {
    "mechanics.pressure.middle": {"mechanics": {"fixed": ["left"], "pressure": {"middle": 1.0}}},
    "mechanics.robin.middle": {"mechanics": {"robin": {"middle": 1.0}}},
    "mechanics.robin_boundary": {"mechanics": {"robin": 1.0, "robin_boundary": ["left", "middle"]}},
    "mechanics.robin_normal.middle": {"mechanics": {"robin_normal": {"middle": 1.0}}},
    "mechanics.fixed": {"mechanics": {"fixed": ["left", "middle"]}},
    "mechanics.sliding": {"mechanics": {"sliding": ["middle"]}},
    "initial.boundary": {"initial": BUMP},
    "activation.transmural_between": {"activation": WALL},
    "fibres.epicardium": {"fibres": RULES},
}


@pytest.mark.parametrize("key", KEYS)
def test_inner_surface_is_refused(halves, key):
    """Meshed.facets, Raises: some of a part's facets lie inside the body; a load there would do nothing."""
    found = case(halves, **KEYS[key])
    with pytest.raises(
        InputError, match=r"'middle' is not a part of the boundary: \d+ of its \d+ facets"
    ) as caught:
        found.build(ALONE)
    assert str(caught.value).startswith(f"{key}: ")


def test_inner_cavity_is_refused(halves):
    """Cavity, Raises: its surface is inside the body."""
    body = ms.build(ms.geometry.MeshFile(path=halves), ms.UniformFibres(direction=(1.0, 0.0, 0.0)), ALONE)
    still = fem.Function(fem.functionspace(body.mesh, ("Lagrange", 1, (3,))))
    with pytest.raises(InputError, match=r"^geometry: 'middle' is not a part of the boundary"):
        Cavity(body, "middle", still, 1)


def test_boundaries_of_the_halves_are_there(halves):
    """Meshed.facets: what is part of the boundary is found."""
    meshed = ms.geometry.MeshFile(path=halves).mesh(ALONE)
    assert len(meshed.facets(["left"])) == len(meshed.facets(["right"])) > 0
    assert len(meshed.facets(["left", "right"])) == 2 * len(meshed.facets(["left"]))
    assert set(meshed.facets(["left"])) < set(meshed.facets(None))
