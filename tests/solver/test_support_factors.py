"""Supports that vary within a part: the tilt of a rigid block on such springs and dampers, in closed form."""

import myostrain as ms
from myostrain import InputError
from myostrain.case.case import Case
from myostrain.case.running import run_case

import numpy as np
import pytest

from small_cases import ALONE

LENGTH, K, C, PULL = 2.0, 3.0, 0.6, 1e-3
#: Factor 0.5 at the left end, 2 at the right one.
LINEAR = ms.SupportProfile(axis=(3.0, 0.0), points=((0.0, 0.5), (LENGTH, 2.0)))


def block(factor, pull=(0.0, PULL), **supports):
    """A stiff block on springs below, pulled up at its top."""
    body = ms.build(ms.geometry.Rectangle(size=(LENGTH, 0.5), spacing=0.5), ms.UniformFibres((1.0, 0.0)))
    return ms.Mechanics(
        body,
        kinematics=ms.kinematics.PlaneStrain(),
        material=ms.materials.NeoHookean(mu=1e4),
        supports=ms.Supports(
            **({"robin_normal": {"bottom": K}} | supports),
            support_factor={"bottom": factor} if factor else {},
        ),
        loads=ms.Loads(traction={"top": pull}),
        tolerance=1e-11,
    )


def heights(mechanics):
    """How far the ends of the bottom were lifted."""
    u = mechanics.displacement()
    X = u.function_space.tabulate_dof_coordinates()
    below = X[:, 1] == 0.0
    return [float(u.x.array.reshape(-1, 2)[below & (X[:, 0] == x), 1][0]) for x in (0.0, LENGTH)]


def tilt(factor):
    """Heights of a rigid block's ends: a + b x with ∫ k f (a + b x) (1, x) dx = t ∫ (1, x) dx."""
    x, weights = np.polynomial.legendre.leggauss(20)
    x, weights = LENGTH / 2 * (x + 1), LENGTH / 2 * weights
    base = np.stack([np.ones_like(x), x])
    a, b = np.linalg.solve((K * factor(x) * weights * base) @ base.T, PULL * (weights * base).sum(axis=1))
    return [a, a + b * LENGTH]


@pytest.mark.parametrize("given", [LINEAR, lambda X: 0.5 + 0.75 * X[:, 0]], ids=["profile", "function"])
def test_a_block_tilts_on_springs_that_vary(given):
    """The soft end rises higher; the springs bear the pull, and its moment."""
    mechanics = block(given)
    mechanics.start()
    due = tilt(lambda x: 0.5 + 0.75 * x)
    assert heights(mechanics) == pytest.approx(due, rel=1e-3)
    assert due[0] > 1.8 * due[1]
    assert mechanics.reactions.values()["reaction_bottom_y"] == pytest.approx(-PULL * LENGTH, rel=1e-6)
    even = block(None)
    even.start()
    assert heights(even) == pytest.approx([PULL / K] * 2, rel=1e-3)


def test_dampers_vary_alike():
    """Springs and dampers of one factor: by backward differences 1 − (1 + h k/c)⁻ⁿ of the tilt at rest."""
    step = 0.1
    pull = ((0.0, (0.0, 0.0)), (step, (0.0, PULL)))
    side = {"left": 1e-4}  # along X alone
    mechanics = block(LINEAR, pull, robin_normal={"bottom": K} | side, damping_normal={"bottom": C})
    mechanics.start(0.0)
    for number in range(1, 4):
        mechanics.solve(number * step, order=1)
        mechanics.accept(number * step)
        share = 1 - (1 + step * K / C) ** -number
        assert heights(mechanics) == pytest.approx(share * np.array(tilt(lambda x: 0.5 + 0.75 * x)), rel=2e-3)


def test_a_case_has_profiles(tmp_path):
    """support_factor of a case is that of a script; it reads back, and the reactions have it."""
    case = Case.from_dict(
        {
            "geometry": {"kind": "rectangle", "size": [LENGTH, 0.5], "spacing": 0.5},
            "fibres": {"direction": [1.0, 0.0]},
            "drive": {"potential": 0.0},
            "material": {"model": "NeoHookean", "mu": 1e4},
            "mechanics": {
                "kinematics": "plane-strain",
                "robin_normal": {"bottom": K},
                "support_factor": {"bottom": {"axis": [3.0, 0.0], "points": [[0.0, 0.5], [LENGTH, 2.0]]}},
                "traction": {"top": [0.0, PULL]},
                "tolerance": 1e-11,
            },
            "time": {"step": 1.0, "end": 1.0, "scheme": "implicit"},
        }
    )
    again = Case.from_dict(case.parameters)
    assert again.mechanics.support_factor == {"bottom": LINEAR}
    run_case(again, tmp_path / "out", comm=ALONE, figures=False)
    rows = np.genfromtxt(tmp_path / "out" / "measures.csv", delimiter=",", names=True)
    assert rows["reaction_bottom_y"][-1] == pytest.approx(-PULL * LENGTH, rel=1e-6)


@pytest.mark.parametrize(
    "factors, words",
    [
        ({"top": LINEAR}, r"support_factor\.top: this has no effect"),
        ({"bottom": 2.0}, r"support_factor\.bottom: .*a table"),
        ({"bottom": ms.SupportProfile(axis=(1.0,), points=((0.0, 1.0),))}, r"bottom\.axis: .*coordinates, 2"),
        ({"bottom": lambda X: X}, r"bottom: gives the shape \(\d, 2\)"),
        ({"bottom": lambda X: X[:, 0] - 1.0}, r"bottom: is -1\.0 at \[0\.0, 0\.0\]; give .*zero or more"),
        ({"bottom": lambda X: 0 * X[:, 0]}, r"bottom: it is zero on all of the part"),
        ({"bottom": lambda: 1.0}, r"bottom: raises TypeError"),
    ],
)
def test_what_is_no_factor(factors, words):
    """With the key, before anything is solved."""
    body = ms.build(ms.geometry.Rectangle(size=(1.0, 1.0), spacing=1.0), ms.UniformFibres((1.0, 0.0)))
    with pytest.raises(InputError, match=rf"^mechanics\.{words}|{words}"):
        ms.Mechanics(
            body,
            kinematics=ms.kinematics.PlaneStrain(),
            material=ms.materials.NeoHookean(mu=1.0),
            supports=ms.Supports(robin_normal={"bottom": K}, support_factor=factors),
        )
    for points in ((), ((1.0, 1.0), (0.0, 1.0))):
        with pytest.raises(InputError, match="ascending heights"):
            ms.SupportProfile(axis=(1.0, 0.0), points=points)
