"""What a notebook shows of a case, a body, mechanics and results."""

import re

import myostrain as ms

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
