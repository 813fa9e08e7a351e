"""Commands that draw: the pictures of a result folder, the curves of a material."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

from myostrain.cli.commands import _load_engine, _warnings_shown, app
from myostrain.errors import InputError

import typer


@app.command()
def plot(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="A result folder.")],
    formats: Annotated[
        str,
        typer.Option(
            "--format", metavar="F,F", help="png, pdf, svg; each picture is drawn in all that are named."
        ),
    ] = "png",
    dpi: Annotated[int, typer.Option("--dpi", metavar="N", help="Dots per inch.")] = 150,
    times: Annotated[
        str, typer.Option("--times", metavar="T,T", help="Simulated times at which to show fields.")
    ] = "",
    fields: Annotated[
        str,
        typer.Option("--fields", metavar="F,F", help="What to draw, such as potential,stress."),
    ] = "",
    style: Annotated[
        str,
        typer.Option("--style", metavar="NAME|FILE", help="A style of Matplotlib, such as dark_background."),
    ] = "",
) -> None:
    """Draw the pictures of a run again, all or some, for a paper."""
    from myostrain.output.figures.choice import Choice
    from myostrain.output.figures.draw import draw
    from myostrain.output.folder import check_path

    check_path(folder, "DIR")
    wanted = Choice(_parts(formats), dpi, _moments(times), _parts(fields), style)
    with _warnings_shown(True):
        for path in draw(folder, wanted):
            typer.echo(str(path))


@app.command()
def export(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="A result folder.")],
    kind: Annotated[
        str, typer.Option("--format", metavar="vtkhdf|vtu|xdmf", help="One file, one per frame, or HDF5.")
    ] = "vtkhdf",
    out: Annotated[
        Path | None, typer.Option("--out", metavar="DIR", help="Where to write; DIR/export by default.")
    ] = None,
    times: Annotated[
        str, typer.Option("--times", metavar="T,T", help="Simulated times; every frame by default.")
    ] = "",
    fields: Annotated[
        str, typer.Option("--fields", metavar="F,F", help="Which fields; all by default.")
    ] = "",
    deformed: Annotated[bool, typer.Option("--deformed", help="The mesh is the deformed one.")] = False,
    linear: Annotated[
        bool, typer.Option("--linear", help="Straight cells, also where the displacement is quadratic.")
    ] = False,
) -> None:
    """Write the fields of a run for ParaView, PyVista or meshio."""
    from myostrain.output.exporting import export as write

    wanted: Any = kind
    path = write(
        *(folder, wanted, out),
        fields=_parts(fields),
        times=_moments(times),
        deformed=deformed,
        linear=linear,
    )
    typer.echo(str(path))


def _moments(times: str) -> list[float]:
    """Simulated times that commas separate."""
    try:
        return [float(time) for time in _parts(times)]
    except ValueError:
        raise InputError(f"'{times}': give numbers with commas between, such as 0.5,1.5", "--times") from None


def _parts(text: str) -> list[str]:
    """What commas separate."""
    return [part.strip() for part in text.split(",") if part.strip()]


@app.command()
def material(
    name: Annotated[
        str | None, typer.Argument(metavar="NAME", help="A passive material; without it, they are listed.")
    ] = None,
    overrides: Annotated[
        list[str] | None,
        typer.Option("--set", metavar="KEY=VALUE", help="Change one parameter, such as mu=2.5."),
    ] = None,
    unit: Annotated[str, typer.Option("--unit", help="Unit of its stiffness, such as kPa.")] = "",
    out: Annotated[
        Path | None,
        typer.Option(
            "--out",
            metavar="FILE.png",
            help="The picture; NAME.png by default. An existing file is replaced.",
        ),
    ] = None,
) -> None:
    """Draw the stress-stretch curves of a passive material.

    They are uniaxial, equibiaxial and in simple shear, along fibre, sheet and normal.

    The material is incompressible and passive, as in the section [material] of a case file.
    """
    _load_engine()
    from myostrain.case.overrides import override
    from myostrain.case.parsing import make
    from myostrain.case.sections import MATERIALS
    from myostrain.errors import nearest
    from myostrain.output.figures.material import draw_material

    if name is None:
        solids = {word: cls for word, cls in MATERIALS.items() if cls.tensor_dim == 3}
        for word, cls in solids.items():
            numbers = ", ".join(f"{key} = {value:g}" for key, value in vars(cls()).items())
            typer.echo(f"{word:{max(map(len, solids))}}  {numbers}")
        return
    if name not in MATERIALS:
        raise InputError(f"no such material; {nearest(name, MATERIALS)}", "NAME")
    values: dict[str, Any] = {}
    override(values, overrides or [])
    made = make(MATERIALS[name], values, "material")
    typer.echo(str(draw_material(made, out or Path(f"{name}.png"), unit=unit)))


@app.command()
def view(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="A result folder.")],
    out: Annotated[
        Path | None, typer.Option("--out", metavar="FILE.html", help="The page; DIR/view.html by default.")
    ] = None,
    opened: Annotated[
        bool, typer.Option("--open/--no-open", help="Whether to open it in the browser.")
    ] = True,
) -> None:
    """Show a run in the browser, on one page.

    The page has a slider of time, the fields, the deformed body, a cut, fibres and probes.
    """
    import webbrowser

    from myostrain.output.viewing import view as write

    path = write(folder, out)
    typer.echo(str(path))
    if opened:
        webbrowser.open(path.resolve().as_uri())
