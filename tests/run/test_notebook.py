"""What a notebook shows of a case, a body, mechanics, a simulation and results, and how far a run is."""

import re
import sys
import types

import myostrain as ms
from myostrain.output.results import Outcome

from small_cases import ALONE, SHEET, changed


def cells(shown):
    """Names and values of a table."""
    return dict(re.findall(r"<tr><td[^>]*>(.*?)</td><td[^>]*>(.*?)</td></tr>", shown))


def test_a_case_and_what_it_builds_are_tables():
    """Sections with their values; sizes and names; supports that are given; nothing is taken for HTML."""
    case = ms.Case.from_dict(changed(SHEET, {"title": "a < b"}))
    shown = case._repr_html_()
    assert "a &lt; b" in shown
    assert "a < b" not in shown
    assert "beta = 0.3" in cells(shown)["activation"]
    assert repr(case).startswith("Case(")
    assert "activation" in repr(case)
    assert len(repr(case)) < 300
    model = case.build(ALONE)
    body, mechanics = cells(model.potential.body._repr_html_()), cells(model.mechanics._repr_html_())
    assert (body["dimension"], body["cells"]) == ("2", str(model.potential.body.cells))
    assert "boundary" in body["boundaries"]
    assert mechanics["supports"] == "robin = 1.0"
    assert "loads" not in mechanics
    assert mechanics["material"] == "NeoHookean(mu=1.0)"
    assert int(mechanics["unknowns"]) == len(model.mechanics.u.x.array)


class Handle:
    """A cell's output that is written anew."""

    def __init__(self):
        self.shown = []

    def display(self, thing, display_id):
        assert display_id
        self.update(thing)
        return self

    def update(self, thing):
        self.shown.append(thing)


def notebook(monkeypatch, shell):
    """As if IPython had loaded this: a shell with a kernel is a notebook, one without a terminal."""
    handle = Handle()
    kernel = types.ModuleType("IPython")
    kernel.get_ipython = lambda: shell
    display = types.ModuleType("IPython.display")
    display.display = handle.display
    monkeypatch.setitem(sys.modules, "IPython", kernel)
    monkeypatch.setitem(sys.modules, "IPython.display", display)
    return handle


def test_a_run_shows_a_bar_in_a_notebook_only(monkeypatch):
    """One output with a bar, full at the end, and what it says as text; in a terminal nothing."""
    case = ms.Case.from_dict(changed(SHEET, {"time.end": 0.02}))
    handle = notebook(monkeypatch, types.SimpleNamespace(kernel=object()))
    simulation = case.simulation(ALONE)
    shown = cells(simulation._repr_html_())
    assert shown["time"].endswith(f"to {simulation.end:.6g}")
    assert shown["result folder"] == "none"
    results = simulation.run()
    first, last = handle.shown[0]._repr_html_(), handle.shown[-1]._repr_html_()
    assert first.startswith(f'<progress value="0" max="{simulation.steps}"></progress> t = 0 of 0.02')
    assert last.startswith(f'<progress value="{simulation.steps}" max="{simulation.steps}">')
    assert repr(handle.shown[-1]) == f"t = 0.02 of 0.02, step {simulation.steps} of {simulation.steps}"
    assert isinstance(results, Outcome)
    rows = re.findall(r"<tr><td[^>]*>(.*?)</td><td[^>]*>(.*?)</td>", results._repr_html_())
    assert dict(rows)["displacement_max"] == f"{results['metrics']['displacement_max']:.5g}"
    handle = notebook(monkeypatch, types.SimpleNamespace())
    case.simulation(ALONE).run()
    assert handle.shown == []
