"""Beats recomputed from their files alone: SciPy's Windkessel, volumes and work from the frames."""

from myostrain import Case, cases, run_case
from myostrain.output.snapshots import Snapshots

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from small_cases import ALONE

#: Half a sphere of a few cells, activated and released over time, between an atrium and arteries.
BASE, INNER = 0.0, (10.0, 10.0)
SMALL = {
    "geometry": {
        "kind": "ventricle",
        "endocardium": list(INNER),
        "epicardium": [14.0, 14.0],
        "base": BASE,
        "spacing": 8.0,
        "layers": 1,
    },
    "fibres": {"kind": "ellipsoidal", "endocardium": list(INNER), "epicardium": [14.0, 14.0]},
    "drive": {"potential": [[0.0, 0.0], [2.0, 1.0], [4.0, 1.0], [5.5, 0.0]]},
    "activation": {"law": "proportional", "beta": 0.15},
    "material": {"model": "NeoHookean", "mu": 2.0},
    "mechanics": {
        "kinematics": "solid",
        "sliding": ["base"],
        "robin_normal": {"epicardium": 0.05},
        "tolerance": 1e-10,
    },
    "circulation": {
        "kind": "windkessel",
        "cavity": "endocardium",
        "filling_pressure": 0.25,
        "inlet_resistance": 1e-3,
        "resistance": 0.05,
        "compliance": 400.0,
        "impedance": 1e-3,
        "arterial_pressure": 0.38,
        "venous_pressure": 0.05,
    },
    "time": {"step": 0.125, "end": 7.0},
    "probes": {"a": [12.0, 0.0, -1.0]},
    "output": {"every": 0.125, "fields": ["displacement"]},
}

#: The shipped heart on a coarse mesh, with another circulation and another layer's cell.
HEART = (
    "geometry.spacing=18.0",
    "geometry.layers=1",
    "circulation.resistance=0.16",
    "circulation.compliance=12000.0",
    "circulation.impedance=0.01",
    "circulation.inlet_resistance=0.003",
    "circulation.filling_pressure=1.3",
    "circulation.arterial_pressure=9.6",
    "circulation.venous_pressure=0.8",
    'cell.set="ENDO"',
    "output.every=2.0",
    'output.fields=["displacement"]',
)


def windkessel(circuit, time, pressure, arteries, volume):
    """Arteries and volume (times,) by SciPy, driven by the pressure of the wall alone."""
    c = circuit

    def rates(t, values):
        p = np.interp(t, time, pressure)
        out = max(p - values[0], 0.0) / c["impedance"]
        leaving = (values[0] - c["venous_pressure"]) / c["resistance"]
        filling = max(c["filling_pressure"] - p, 0.0) / c["inlet_resistance"]
        return [(out - leaving) / c["compliance"], filling - out]

    return solve_ivp(
        rates,
        time[[0, -1]],
        [arteries, volume],
        t_eval=time,
        rtol=1e-8,
        atol=1e-8,
        max_step=time[1] - time[0],
    ).y


class Surface:
    """The deformed endocardium by its facets of six nodes, closed by the plane of the base.

    The facets are those of one cell whose corners are on the ellipsoid; nothing else of the run is used.
    """

    def __init__(self, folder, semi_axes, base):
        self._frames = Snapshots(folder)
        X, cells = self._frames.points, self._frames.cells
        faces = np.concatenate([np.delete(cells, i, axis=1) for i in range(4)])
        opposite = cells.T.reshape(-1)
        _, first, count = np.unique(np.sort(faces, axis=1), axis=0, return_index=True, return_counts=True)
        alone = first[count == 1]
        x = X / np.array([semi_axes[0], semi_axes[0], semi_axes[1]])
        on = (np.abs((x**2).sum(axis=1) - 1) < 1e-6)[faces[alone]].all(axis=1)
        self._faces, inner = faces[alone[on]], X[opposite[alone[on]]]
        corners = X[self._faces]
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        # Out of the cavity, into the wall.
        self._sign = np.sign(np.einsum("fi,fi->f", normals, inner - corners[:, 0]))
        self._origin = np.array([0.0, 0.0, base])
        edges, _ = self._frames.edges
        number = {tuple(sorted(edge)): n for n, edge in enumerate(edges.tolist())}
        pairs = self._faces[:, [[0, 1], [1, 2], [2, 0]]]
        self._edges = np.array([[number[tuple(sorted(e))] for e in face] for face in pairs.tolist()])
        self._middles = (corners + np.roll(corners, -1, axis=1)) / 2
        # Gauss's points in a square, folded into the triangle.
        t, w = np.polynomial.legendre.leggauss(4)
        s, r = np.meshgrid((t + 1) / 2, (t + 1) / 2)
        xi, eta = (s * (1 - r)).ravel(), r.ravel()
        self._weights = (np.outer(w, w) / 4 * (1 - r)).ravel()
        zero, one = np.zeros_like(xi), np.ones_like(xi)
        L, D = np.array([1 - xi - eta, xi, eta]), np.array([[-one, one, zero], [-one, zero, one]])
        a, b = [0, 1, 2], [1, 2, 0]
        self._shape = np.concatenate([L * (2 * L - 1), 4 * L[a] * L[b]])
        self._slopes = np.concatenate(
            [(4 * L - 1) * D, 4 * (L[a] * D[:, b] + L[b] * D[:, a])], axis=1
        )  # (2, nodes, points)

    def __len__(self):
        return len(self._frames.times)

    def at(self, frame):
        """Positions (facets, points, 3), and vectors of area out of the cavity."""
        corners = (self._frames.points + self._frames.field("displacement", frame))[self._faces]
        middles = self._middles + self._frames.middles(frame)[self._edges]
        nodes = np.concatenate([corners, middles], axis=1) - self._origin
        x = np.einsum("fni,nq->fqi", nodes, self._shape)
        along, across = np.einsum("fni,dnq->dfqi", nodes, self._slopes)
        return x, np.cross(along, across) * self._sign[:, None, None] * self._weights[None, :, None]

    def volume(self, x, area):
        return float((x * area).sum() / 3)


def recomputed(folder, semi_axes, base):
    """Volumes (frames,), and the work of a pressure of one in each step."""
    surface = Surface(folder, semi_axes, base)
    volumes, work, last = [], [], None
    for frame in range(len(surface)):
        x, area = surface.at(frame)
        volumes.append(surface.volume(x, area))
        if last is not None:
            work.append(float(((area + last[1]) / 2 * (x - last[0])).sum()))
        last = x, area
    return np.array(volumes), np.array(work)


def check(folder, circuit, semi_axes, base, tolerance):
    """Everything of a run's files against what is computed here."""
    table = np.genfromtxt(folder / "cavities.csv", delimiter=",", names=True)
    time, pressure, volume = (table[n] for n in ("time", "pressure_endocardium", "volume_endocardium"))
    arteries = table["pressure_arteries"]
    stroke = np.ptp(volume)
    given = time, pressure, arteries[0], volume[0]
    found = windkessel(circuit, *given)
    off = np.abs(found[0] - arteries).max() / np.ptp(arteries), np.abs(found[1] - volume).max() / stroke
    volumes, work = recomputed(folder, semi_axes, base)
    assert len(volumes) == len(time)
    np.testing.assert_allclose(volumes, volume, rtol=1e-7)
    middle = (pressure[1:] + pressure[:-1]) / 2
    by_volume, at_wall = -float(middle @ np.diff(volume)), -float(middle @ work)
    print(f"arteries {off[0]:.1e}, volume {off[1]:.1e}, work {by_volume:.6g} and {at_wall:.6g}")
    print(f"volumes {np.abs(volumes / volume - 1).max():.1e}, ejected {stroke:.6g} of {volume.max():.6g}")
    assert max(off) < tolerance
    other = {**circuit, "resistance": 1.1 * circuit["resistance"]}
    assert np.abs(windkessel(other, *given)[0] - arteries).max() / np.ptp(arteries) > 3 * tolerance
    assert at_wall == pytest.approx(by_volume, rel=1e-4)
    assert stroke > 0.02 * volume.max()
    assert np.ptp(arteries) > 0.02 * arteries.max()


def test_a_small_beat(tmp_path):
    """The wall's pressure drives SciPy's Windkessel alike; volumes and work are those of the facets."""
    run_case(Case.from_dict(SMALL), tmp_path / "out", comm=ALONE, figures=False)
    check(tmp_path / "out", SMALL["circulation"], INNER, BASE, 0.02)


@pytest.mark.slow
def test_a_whole_heartbeat(tmp_path):
    """The heart with other resistances, compliance, pressures and calcium."""
    case = Case.from_file(cases.path("heartbeat-3d"), HEART)  # to 290 ms 1e-3, and the work to 2e-5
    results = run_case(case, tmp_path / "out", comm=ALONE, figures=False)
    # With the material's own switch of tension, a tenth as wide, filling takes hundreds.
    assert results["solver"]["mechanics"]["factorizations"] < 200
    given = case.parameters
    shape = given["geometry"]
    check(tmp_path / "out", given["circulation"], shape["endocardium"], shape["base"], 4e-3)
