"""The page that shows a run: what it holds is what was recorded, it loads nothing, and a browser draws it."""

import base64
import html
import json
import re
import shutil
import subprocess

import myostrain as ms
from myostrain.output.figures.data import Recording
from myostrain.output.viewing import view

import numpy as np
import pytest
from PIL import Image
from test_figures import line, sheet

from picture_tools import finish
from small_cases import command_line
from snapshot_files import write_snapshots

BROWSER = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")


def held(path):
    """The data of a page."""
    return json.loads(re.search(r'id="data">(.*?)</script>', path.read_text(), re.S)[1].replace("<\\/", "</"))


def unpacked(field, *shape):
    shares = np.frombuffer(base64.b64decode(field["data"]), "<u2").reshape(shape)
    return field["least"] + field["span"] * shares / 65535


def test_a_page_holds_what_was_recorded(tmp_path):
    """Fields and displacements to 16 bits of their range, at every frame; nothing is loaded."""
    points, cells = sheet(tmp_path)
    finish(tmp_path, {"corner": [50.0, 10.0, 0.0]})
    done = command_line("view", tmp_path, "--no-open")
    assert (done.status, done.out.strip()) == (0, str(tmp_path / "view.html"))
    text = (tmp_path / "view.html").read_text()
    assert not re.search(r'(?:src|href)\s*=\s*"|https?://|@import', text)
    data, run = held(tmp_path / "view.html"), Recording(tmp_path)
    np.testing.assert_array_equal(np.frombuffer(base64.b64decode(data["cells"]), "<u4"), cells.ravel())
    assert data["times"] == run.time.tolist()
    (v,) = [field for field in data["fields"] if field["name"] == "potential"]
    np.testing.assert_allclose(unpacked(v, 5, -1), run.history("potential"), atol=v["span"] / 65535)
    moved = unpacked(data["displacement"], 5, -1, 3)
    np.testing.assert_allclose(moved[..., :2], run.history("displacement"), atol=60 / 65535)
    assert data["probes"][0]["name"] == "corner"
    assert data["probes"][0]["point"] == [50.0, 10.0, 0.0]
    nearest = np.linalg.norm(points - [50.0, 10.0], axis=1).argmin()
    np.testing.assert_allclose(
        data["probes"][0]["moved"][-1][:2], run.field("displacement")[nearest], rtol=1e-5
    )


def test_a_scale_may_end_at_zero(tmp_path):
    """γ goes from −0.2 to 0, and is called by its letter."""
    points, cells = np.linspace(0, 3, 4)[:, None], [[0, 1], [1, 2], [2, 3]]
    write_snapshots(tmp_path, points, cells, [0.0], gamma=np.array([[-0.2, -0.1, 0.0, 0.0]]))
    (gamma,) = held(view(tmp_path))["fields"]
    assert (gamma["low"], gamma["high"], gamma["label"]) == (-0.2, 0.0, "γ")


def test_of_a_solid_its_boundary_is_seen(tmp_path):
    """A cube of five tetrahedra has twelve triangles outside."""
    corners = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)], dtype=float)
    cells = np.array([[0, 3, 5, 6], [1, 0, 3, 5], [2, 0, 3, 6], [4, 0, 5, 6], [7, 3, 5, 6]])
    write_snapshots(tmp_path, corners, cells, [0.0], potential=corners[None, :, 0])
    data = held(view(tmp_path))
    assert len(base64.b64decode(data["cells"])) == 12 * 3 * 4
    assert data["displacement"] is None


def test_what_cannot_be_shown(tmp_path):
    with pytest.raises(ms.InputError, match="none is not there; name the result folder"):
        view(tmp_path / "none")
    (tmp_path / "sweep.json").touch()
    with pytest.raises(ms.InputError, match=r"is a sweep; name one of its runs, such as .*001"):
        view(tmp_path)
    (tmp_path / "sweep.json").rename(tmp_path / "case.toml")
    with pytest.raises(ms.InputError, match=r"output.fields was empty"):
        view(tmp_path)
    (tmp_path / "case.toml").unlink()
    line(tmp_path, 60)
    for path in (tmp_path / "snapshots").glob("frame-*"):
        path.unlink()
    with pytest.raises(ms.InputError, match="holds no frame yet"):
        view(tmp_path)


def browse(folder, *arguments):
    """Chromium without a window; the graphics are software's."""
    command = [
        *(BROWSER, "--headless", "--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"),
        *("--ignore-gpu-blocklist", f"--user-data-dir={folder / 'browser'}", *arguments),
    ]
    return subprocess.run(command, capture_output=True, text=True, check=False, timeout=120)


@pytest.mark.skipif(BROWSER is None, reason="there is no chromium here")
def test_a_browser_draws_it(tmp_path):
    """At a time that is asked for the wave has its colours; the console says nothing."""
    sheet(tmp_path)
    finish(tmp_path, {"corner": [50.0, 10.0, 0.0]})
    page = view(tmp_path)
    options = ["--enable-logging=stderr", "--window-size=800,700", f"--screenshot={tmp_path / 'page.png'}"]
    done = browse(tmp_path, *options, f"{page.as_uri()}#frame=2&probe=0&field=potential")
    assert "CONSOLE" not in done.stderr, done.stderr
    pixels = np.asarray(Image.open(tmp_path / "page.png").convert("RGB"), dtype=int)[90:600]
    rest, peak = (68, 57, 131), (253, 231, 37)  # of viridis, at 0 and at 1 on a scale from -0.2
    for colour in (rest, peak):
        assert (np.abs(pixels - colour).max(axis=-1) < 25).sum() > 500
    chosen = np.abs(pixels - (0xD5, 0x5E, 0x00)).max(axis=-1) < 10  # the probe, and the time on its curve
    assert chosen.sum() > 150


#: Uses the page as a reader does, and says what happened: the slider, another field, clicks everywhere until
#: a probe answers.
DRIVER = """
<script>window.said = [];
addEventListener("error", (e) => said.push(String(e.message)));
console.error = (...words) => said.push(words.join(" "));
Element.prototype.setPointerCapture = () => {};  // of pointers that no hand moves
</script>"""
CLICKS = """
<script>
const by = (id) => document.getElementById(id), tell = {};
const event = (node, kind, more) => node.dispatchEvent(new (more ? PointerEvent : Event)(kind, more));
tell.end = by("clock").textContent;
by("time").value = 0; event(by("time"), "input"); tell.begin = by("clock").textContent;
const other = [...by("field").options].findIndex((each) => each.value === "displacement");
by("field").selectedIndex = other; event(by("field"), "change"); tell.label = by("label").textContent;
by("deformed").click(); by("rest").click(); by("home").click();
const marks = by("marks"), box = marks.getBoundingClientRect();
search: for (let y = 4; y < box.height; y += 18) for (let x = 4; x < box.width; x += 18) {
  const at = { clientX: box.left + x, clientY: box.top + y, pointerId: 1 };
  event(marks, "pointerdown", at); event(marks, "pointerup", at);
  if (!by("curve").hidden) break search;
}
tell.probe = by("probe").textContent; tell.hidden = by("curve").hidden; tell.said = said;
document.title = JSON.stringify(tell);
</script>"""


@pytest.mark.skipif(BROWSER is None, reason="there is no chromium here")
@pytest.mark.parametrize(
    "dim", [pytest.param(1, marks=pytest.mark.slow), 2, pytest.param(3, marks=pytest.mark.slow)]
)
def test_a_browser_is_used(tmp_path, dim):
    """Open, move the slider, change the field, click a probe: each answers, and nothing is complained of."""
    points, cells = {
        1: (np.linspace(0, 4, 5)[:, None], np.column_stack([np.arange(4), np.arange(1, 5)])),
        2: (np.array([[0.0, 0], [2, 0], [0, 1], [2, 1]]), np.array([[0, 1, 2], [1, 3, 2]])),
        3: (np.vstack([np.zeros(3), np.eye(3)]), np.array([[0, 1, 2, 3]])),
    }[dim]
    times = np.array([0.0, 0.5, 2.0])
    v = times[:, None] * points[:, 0] / 8
    write_snapshots(tmp_path, points, cells, times, potential=v, displacement=v[..., None] * np.eye(dim)[0])
    finish(tmp_path, {"mark": points[1].tolist() + [0.0] * (3 - dim)})
    page = view(tmp_path)
    text = page.read_text(encoding="utf-8")
    page.write_text(text.replace("<body>", f"<body>{DRIVER}").replace("</body>", f"{CLICKS}</body>"))
    done = browse(tmp_path, "--window-size=500,500", "--dump-dom", page.as_uri())
    told = json.loads(html.unescape(re.search(r"<title>(\{.*?\})</title>", done.stdout)[1]))
    assert told["said"] == []
    assert (told["begin"], told["end"]) == ("t = 0", "t = 2")
    assert told["label"].startswith("displacement")
    assert not told["hidden"]
    assert "mark" in told["probe"]
