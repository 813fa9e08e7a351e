"""Commands that draw: the pictures of a result folder, the curves of a material."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

from myostrain.cli.commands import _load_engine, _warnings_shown, app
from myostrain.errors import InputError

import typer


@app.command()
def plot(folder: Annotated[Path, typer.Argument(metavar="DIR", help="A result folder.")]) -> None:
    """Draw the pictures of a result folder again."""
    from myostrain.output.figures.draw import draw
    from myostrain.output.folder import check_path

    check_path(folder, "DIR")
    with _warnings_shown(True):
        for path in draw(folder):
            typer.echo(str(path))


@app.command()
def material(
    name: Annotated[
        str | None, typer.Argument(metavar="NAME", help="A passive material; without one they are listed.")
    ] = None,
    overrides: Annotated[
        list[str] | None,
        typer.Option("--set", metavar="KEY=VALUE", help="Change one parameter, such as mu=2.5."),
    ] = None,
    unit: Annotated[str, typer.Option("--unit", help="Unit of its stiffness, such as kPa.")] = "",
    out: Annotated[
        Path | None,
        typer.Option("--out", metavar="FILE.png", help="The picture; NAME.png by default. Is replaced."),
    ] = None,
) -> None:
    """Draw a material's curves: uniaxial, equibiaxial and simple shear, by fibre, sheet and normal.

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
