"""Draw the pictures of the gallery from its own examples: python docs/extensions/gallery_pictures.py.

Each example runs, and then the function below that bears its name. The pictures have no background and greys
in the middle, so that they suit a light page and a dark one.
"""

import contextlib
import io
import os
import re
import tempfile
from pathlib import Path

import myostrain as ms

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

DOCS = Path(__file__).parents[1]
IMAGES = DOCS / "images"
GREY = "#808080"
STYLE = {
    **dict.fromkeys(("axes.edgecolor", "axes.labelcolor", "text.color", "xtick.color", "ytick.color"), GREY),
    **dict.fromkeys(("axes.spines.top", "axes.spines.right", "legend.frameon"), False),
    **dict.fromkeys(("figure.facecolor", "axes.facecolor", "savefig.facecolor"), "none"),
    "axes.prop_cycle": mpl.cycler(color=["#3d8fd1", "#e0702f", "#2fa37c", "#c678a8"]),
    **dict.fromkeys(("font.size", "legend.fontsize"), 8),
    "lines.linewidth": 1.6,
}

DRAWN = {}


def draws(title):
    """Register what draws the picture of an example."""

    def register(function):
        DRAWN[title] = function
        return function

    return register


def name_of(title):
    """The file of an example's picture."""
    return "gallery-" + re.sub(r"[^a-z]+", "-", title.lower()).strip("-") + ".png"


def _last(panel, folder, **look):
    frames = ms.open(folder).frames
    X = frames.points[:, 0]
    order = np.argsort(X)
    panel.plot(X[order], frames[-1]["potential"][order], **look)
    panel.set(xlabel="material X", ylabel="v")


@draws("A pulse on a contracting line")
def _(panel, names, out):
    frames = ms.open("runs/pulse").frames
    for frame in frames[:: len(frames) // 4]:
        order = np.argsort(frame.deformed[:, 0])
        shade = 0.25 + 0.7 * frame.time / frames.times[-1]
        panel.plot(frame.deformed[order, 0], frame["potential"][order], color="#3d8fd1", alpha=shade)
    panel.set(xlabel="x", ylabel="v")


@draws("The same line, rigid")
def _(panel, names, out):
    _last(panel, "runs/pulse", label="contracting")
    _last(panel, "runs/rigid", label="rigid", linestyle="--")
    panel.legend()


@draws("Viscosity")
def _(panel, names, out):
    _last(panel, "runs/pulse", label="elastic")
    _last(panel, "runs/viscous", label="viscous", linestyle="--")
    panel.legend()


@draws("Two runs beside each other")
def _(panel, names, out):
    for folder, dash in (("pulse", "-"), ("rigid", "--")):
        v = ms.open(f"runs/{folder}").probes["potential"].sel(probe="b")
        panel.plot(v.time, v, dash, label=f"b, {folder}")
    panel.set(xlabel="t", ylabel="v")
    panel.legend()


@draws("Pacing a tissue")
def _(panel, names, out):
    v = ms.open("runs/paced").probes["potential"].sel(probe="middle")
    panel.plot(v.time, v)
    panel.set(xlabel="t (ms)", ylabel="v in the middle")


def _trace(panel, found, cycle, label=None):
    begin = found.time[-1] - cycle
    late = found.time >= begin
    panel.plot(found.time[late] - begin, found.potential[late], label=label)
    panel.set(xlabel="t since the last stimulus", ylabel="v", xlim=(0, 400))


@draws("A membrane without a body")
def _(panel, names, out):
    _trace(panel, names["paced"], 500.0)


@draws("Restitution")
def _(panel, names, out):
    for cycle in (350.0, 500.0, 800.0):
        found = ms.cell(ms.membranes.MitchellSchaeffer2003(), cycle=cycle, beats=4)
        _trace(panel, found, cycle, label=f"{cycle:.0f} ms")
    panel.legend()


@draws("A membrane of your own")
def _(panel, names, out):
    _trace(panel, names["own"], 400.0)


@draws("A sheet that shortens")
def _(panel, names, out):
    mechanics = names["mechanics"]
    body = mechanics.body
    X = body.mesh.geometry.x[:, :2]
    u = mechanics.displacement().x.array.reshape(-1, 2)
    cells = body.mesh.geometry.dofmap
    panel.triplot(*X.T, cells, color=GREY, linewidth=0.6, linestyle=":")
    panel.triplot(*(X + u).T, cells, linewidth=1.2)
    panel.set(aspect="equal", xlabel="x", ylabel="y")


@draws("A slab, by active strain and by active stress")
def _(panel, names, out):
    for row, line in enumerate(out.splitlines()):
        name, *stretches = line.split()
        panel.bar(np.arange(2) + 0.35 * row, [float(s) - 1 for s in stretches], 0.33, label=name)
    panel.axhline(0, color=GREY, linewidth=0.7)
    panel.set_xticks([0.17, 1.17], ["free", "pulled"])
    panel.set(ylabel="stretch − 1")
    panel.legend()


@draws("Loads over time")
def _(panel, names, out):
    t = np.linspace(0, 1, 101)
    panel.plot(t, 0.2 * np.sin(np.pi * t), label="traction")
    panel.plot(t, -0.1 * t, label="γ")
    panel.set(xlabel="t")
    panel.legend()


@draws("Watching a run")
def _(panel, names, out):
    panel.plot(np.linspace(0, 1, len(names["seen"])), names["seen"], "o-")
    panel.set(xlabel="t", ylabel="mean fibre stretch")


@draws("A law with a delay")
def _(panel, names, out):
    seen = [(0.0, 0.0)]
    late = names["late"]
    model = ms.Electromechanics(
        names["drive"], names["plate"](supports=ms.Supports(robin=1.0)), law=names["Late"]()
    )

    def watch(simulation):
        seen.append((model.time, float(model.activation.states.min())))

    ms.Simulation(model, step=0.125, end=1.0, on_step=watch).run()
    assert seen[-1][1] == float(late.activation.states.min())
    panel.plot([0, 1], [0, -0.2], "--", color=GREY, label="wanted")
    panel.plot(*np.array(seen).T, "o-", label="γ")
    panel.set(xlabel="t")
    panel.legend()


@draws("A material of your own")
def _(panel, names, out):
    found = []
    for traction in (0.0, 0.25, 0.5, 1.0, 1.5):
        pulled = ms.Mechanics(
            names["sheet"],
            kinematics=ms.kinematics.PlaneStress(),
            material=names["Stiffening"](),
            supports=ms.Supports(sliding=["left", "bottom"]),
            loads=ms.Loads(traction={"right": [traction, 0.0]}),
        )
        pulled.start(time=0.0)
        found.append((pulled.fibre_stretch().mean(), traction))
    panel.plot(*np.array(found).T, "o-")
    panel.set(xlabel="stretch", ylabel="traction")


@draws("The curves of a material")
def _(panel, names, out):
    from myostrain.output.figures.material import uniaxial

    stretch = np.linspace(0.9, 1.15, 60)
    for along, stress in uniaxial(ms.materials.HolzapfelOgden2009(), stretch).items():
        panel.plot(stretch, stress, label=along)
    panel.set(xlabel="stretch", ylabel="Cauchy stress (kPa)")
    panel.legend()


@draws("Fibres by a function")
def _(panel, names, out):
    X = np.stack(np.meshgrid(np.linspace(0, 4, 13), np.linspace(0, 2, 7)), axis=-1).reshape(-1, 2)
    f = names["turning"](X)
    panel.quiver(*X.T, *f.T, color="#3d8fd1", headaxislength=0, headlength=0, headwidth=1, pivot="mid")
    panel.set(aspect="equal", xlabel="X", ylabel="Y")


@draws("A mesh made in gmsh")
def _(panel, names, out):
    mesh = names["oval"].mesh
    panel.triplot(*mesh.geometry.x[:, :2].T, mesh.geometry.dofmap, linewidth=0.8)
    panel.set(aspect="equal", xlabel="X", ylabel="Y")


@draws("Results as data")
def _(panel, names, out):
    names["run"].probes["potential"].plot(hue="probe", ax=panel)
    panel.set_title("")


@draws("Strain, afterwards")
def _(panel, names, out):
    run, last = names["run"], names["last"]
    centres = run.frames.points[run.frames.cells].mean(axis=1)[:, 0]
    order = np.argsort(centres)
    panel.step(centres[order], last.J()[order], where="mid")
    panel.set(xlabel="X", ylabel="J")


@draws("A figure for a paper")
def _(panel, names, out):
    frames = ms.open("runs/pulse").frames
    for time in (0.2, 0.4):
        frame = frames.at(time)
        order = np.argsort(frame.deformed[:, 0])
        panel.plot(frame.deformed[order, 0], frame["potential"][order], label=f"t = {frame.time:g}")
    panel.set(xlabel="spatial x", ylabel="v")
    panel.legend()


@draws("A sweep")
def _(panel, names, out):
    betas = (0.0, 0.1, 0.2, 0.3)
    found = [names["pulse"](f"runs/beta-{b}", f"activation.beta={b}")["celerity"] for b in betas]
    panel.plot(betas, found, "o-")
    panel.set(xlabel="activation.beta", ylabel="celerity")


def examples():
    """Title and Python block, if there is one, of each example of the page, in order."""
    page = (DOCS / "gallery.md").read_text(encoding="utf-8")
    for title, content in re.findall(r"^### (.*?)\n(.*?)(?=^##|\Z)", page, re.S | re.M):
        block = re.search(r"^```python\n(.*?)^```$", content, re.S | re.M)
        yield title, block[1] if block else ""


def main():
    """Run the examples in an empty folder, and write the pictures."""
    names = {"__name__": "__main__"}
    with tempfile.TemporaryDirectory() as folder, mpl.rc_context(STYLE):
        os.chdir(folder)
        for title, code in examples():
            out = io.StringIO()
            with contextlib.redirect_stdout(out):
                exec(compile(code, title, "exec"), names)
            if title in DRAWN:
                figure = Figure(figsize=(4.2, 2.2), dpi=120, layout="constrained")
                DRAWN[title](figure.add_subplot(), names, out.getvalue())
                figure.savefig(IMAGES / name_of(title), metadata={"Software": None})
                print(title)


if __name__ == "__main__":
    main()
