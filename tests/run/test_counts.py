"""The work that shipped cases take, counted: a regression guard that no clock disturbs.

The bounds are the counts measured when they were last set, plus a tenth (integers: plus two). Who makes a
scheme cheaper lowers them; who raises one says why in the commit.
"""

import myostrain as ms
from myostrain import cases

import pytest

#: Case, overrides; measured: steps, CG iterations, mechanics solves, corrections, factorizations, assemblies
#: of the diffusion, fixed-point iterations.
MEASURED = [
    ("sheet-2d", ["geometry.spacing=2.428", "time.end=0.6"], (200, 599, 51, 96, 1, 52, 0)),
    ("sheet-2d", ["time.end=0.06", "probes={}"], (20, 79, 6, 17, 1, 7, 0)),
    ("pulse-1d", ["time.end=0.5", "output.rigid_twin=false"], (500, 1000, 501, 632, 1, 501, 0)),
    ("pulse-1d-rigid", ["time.end=0.5"], (500, 998, 0, 0, 0, 1, 0)),
    ("front-1d", ["time.end=0.5"], (500, 1000, 501, 658, 2, 501, 0)),
    ("startup-1d", [], (300, 2838, 1912, 3532, 1, 1912, 1911)),
]


@pytest.mark.parametrize("name, overrides, measured", MEASURED, ids=[f"{n}-{len(o)}" for n, o, _ in MEASURED])
def test_a_case_takes_no_more_work_than_it_did(name, overrides, measured):
    results = ms.Case.from_file(cases.path(name), overrides).simulation().run()
    solver = results["solver"]
    counted = (
        results["steps"],
        solver["potential"]["linear"],
        solver["mechanics"]["solves"],
        solver["mechanics"]["linear"],
        solver["mechanics"]["factorizations"],
        solver["potential"]["assemblies"],
        solver["coupling"]["iterations"],
    )
    bounds = tuple(max(int(1.1 * count), count + 2) for count in measured)
    assert counted[0] == measured[0]
    assert all(count <= bound for count, bound in zip(counted, bounds, strict=True)), (counted, measured)
    # And no less than a third: then the guard guards nothing and is to be set anew.
    assert all(3 * count >= bound for count, bound in zip(counted, measured, strict=True)), (
        counted,
        measured,
    )
