"""What the pictures of sweeps and comparisons leave out: what hardly differs, does not change, vanishes."""

from types import SimpleNamespace

import myostrain as ms
from myostrain.output.figures.comparison import MEASURES, _measures, _probes
from myostrain.output.reader import Reader
from myostrain.sweeping.picture import PANELS, choose
from myostrain.sweeping.table import Rows

import numpy as np
import pytest
import xarray as xr


def rows(folder, **metrics):
    """A table of a sweep of as many runs as each metric has values."""
    count = len(next(iter(metrics.values())))
    members = [SimpleNamespace(name=f"{n:03d}") for n in range(1, count + 1)]
    made = Rows(SimpleNamespace(members=members), folder)
    for n, member in enumerate(members):
        made.metrics[member.name] = {name: values[n] for name, values in metrics.items()}
    return made


def test_a_sweep_draws_what_differs_by_a_thousandth(tmp_path):
    """Of the largest value; a run without a number does not count."""
    found = rows(
        tmp_path,
        same=[2.0, 2.0, 2.0],
        close=[1.0, 1.0009, 1.0],
        far=[1.0, 1.0011, 1.0],
        alone=[None, 3.0, None],
        holey=[None, 3.0, 4.0],
        negative=[-1.0, -1.5, -1.0],
        none=[None, None, None],
    )
    assert choose(found) == ["far", "holey", "negative"]
    assert choose(found, ["same"]) == ["same"]
    with pytest.raises(ms.InputError, match="--plot: no metric is called 'fer'; did you mean 'far'"):
        choose(found, ["fer"])


def test_a_sweep_draws_the_best_known_metrics_first(tmp_path):
    names = ["a", "b", "c", "d", "e", "f", "displacement_max", "celerity"]
    chosen = choose(rows(tmp_path, **{name: [1.0, 2.0] for name in names}))
    assert chosen == ["celerity", "displacement_max", "a", "b", "c", "d"]
    assert len(chosen) == PANELS


def test_a_sweep_leaves_out_forces_that_vanish(tmp_path, monkeypatch):
    monkeypatch.setattr(Reader, "least_force", 1e-6)
    found = rows(tmp_path, reaction_left_x=[1e-9, -9e-7], reaction_left_y=[1e-9, -2e-6], twist=[1e-9, 2e-9])
    assert choose(found) == ["twist", "reaction_left_y"]


def run(least=0.0, probes=(), **measures):
    """As much of a run as a comparison draws."""
    time = np.linspace(0, 1, 5)
    table = xr.Dataset(
        {name: ("time", np.asarray(v, dtype=float)) for name, v in measures.items()}, {"time": time}
    )
    v = xr.DataArray(np.zeros((len(probes), 5)), {"probe": list(probes), "time": time}, ("probe", "time"))
    return SimpleNamespace(measures=table, least_force=least, probes=xr.Dataset({"potential": v}))


def test_a_comparison_draws_what_changes_in_one_run_and_two_have():
    still, moving = np.ones(5), np.linspace(0, 1, 5)
    barely = 1 + 1e-10 * moving
    first = run(one=moving, both=still, rest=still, noise=barely)
    second = run(both=moving, rest=still, noise=barely)
    found = _measures([first, second])
    assert list(found) == ["both"]
    assert sorted(found["both"]) == [0, 1]


def test_a_comparison_leaves_out_forces_that_vanish():
    """Run by run: the force of one that is above stays, and one curve alone is none to compare."""
    small, large = 0.9e-6 * np.linspace(-1, 1, 5), 1.1e-6 * np.linspace(-1, 1, 5)
    runs = [run(least=1e-6, reaction_a_x=small, reaction_b_x=large, reaction_c_x=small) for _ in range(2)]
    runs.append(run(least=1e-6, reaction_c_x=large))
    assert list(_measures(runs)) == ["reaction_b_x"]


def test_a_comparison_draws_probes_that_two_have_and_so_many_panels():
    found = _probes([run(probes="abc"), run(probes="bcd"), run(probes="c")])
    assert {name: sorted(curves) for name, curves in found.items()} == {
        "potential at b": [0, 1],
        "potential at c": [0, 1, 2],
    }
    many = {f"m{n}": np.linspace(0, 1, 5) for n in range(20)}
    assert list(_measures([run(**many), run(**many)])) == [f"m{n}" for n in range(MEASURES)]
