"""Cases and the paper: the commands of ``myostrain`` but for those of cells, and how it ends."""

from __future__ import annotations

import contextlib
import io
import logging
import math
import os
import signal
import sys
import time
import traceback
from collections.abc import Iterator
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING, Annotated, Any, NoReturn

from myostrain.cli.options import CaseName, Force, Ordered, Out, Quiet
from myostrain.errors import ComputationError, InputError, Interrupted
from myostrain.output.clinical import SEGMENT, clinical
from myostrain.run.progress import ProgressDisplay, errors

import typer
from rich.console import Console

if TYPE_CHECKING:
    from myostrain.case.case import Case

app = typer.Typer(
    cls=Ordered,
    epilog="`myostrain COMMAND --help` explains one of them.",
    help="Cardiac electromechanics by active strain.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)
screen = Console(soft_wrap=True, highlight=False, markup=False)

#: Signals that :func:`_terminate` has seen.
_terminated: list[int] = []


def _version(wanted: bool) -> None:
    if wanted:
        import myostrain

        typer.echo(f"myostrain {myostrain.__version__}")
        raise typer.Exit


@app.callback()
def common(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version and exit.")
    ] = False,
) -> None:
    """Cardiac electromechanics by active strain."""


@app.command("list")
def list_cases() -> None:
    """List the cases that ship, with what each shows and costs.

    Seconds are those of two free cores, loading and pictures included, once the equations are compiled.
    """
    import tomllib

    from myostrain import cases

    width = max(len(name) for name in cases.names())
    for name in cases.names():
        data = tomllib.loads(cases.path(name).read_text(encoding="utf-8"))
        typer.echo(f"{name:{width}}  {data['title']} [{data['cost']}]")


@app.command()
def show(case: Annotated[str, typer.Argument(metavar="CASE", help="A named case.")]) -> None:
    """Print a case as a commented file: copy it, edit it, run it."""
    from myostrain import cases

    typer.echo(cases.path(case).read_text(encoding="utf-8"), nl=False)


@app.command()
def run(
    case: CaseName = None,
    overrides: Annotated[
        list[str] | None,
        typer.Option("--set", metavar="KEY=VALUE", help="Change one key; values as in TOML."),
    ] = None,
    out: Out = None,
    resume: Annotated[
        bool, typer.Option("--resume", help="Go on from the last checkpoint in DIR; CASE is not needed.")
    ] = False,
    quiet: Quiet = False,
    force: Force = False,
) -> None:
    """Run a case and write a result folder."""
    from myostrain import cases

    _load_engine()
    from myostrain.case.case import Case
    from myostrain.case.running import run_case
    from myostrain.engine import MPI
    from myostrain.output.figures.beside import Artist, worth_it
    from myostrain.output.folder import free_name

    comm = MPI.COMM_WORLD
    asked = None
    if case is not None:
        file = Path(case) if case.endswith(".toml") or "/" in case else cases.path(case)
        with _warnings_shown(comm.rank == 0):
            asked = Case.from_file(file, overrides or [])
    if resume:
        checked, resume = _resumed(asked, out, overrides or [], force=force)
    elif asked is None:
        raise InputError(f"name a case ({', '.join(cases.names())}) or a case file", "CASE")
    else:
        checked = asked
    folder = comm.bcast(out if out is not None else free_name(Path("runs") / checked.name), root=0)
    try:
        with (
            _warnings_shown(comm.rank == 0),
            Artist(beside=comm.rank == 0 and worth_it(comm.size), solid=checked.dim == 3) as artist,
            ProgressDisplay(comm.rank == 0, bar=not quiet) as display,
        ):
            results = run_case(
                checked,
                folder,
                force=force,
                resume=resume,
                comm=comm,
                progress=display.start,
                draw=artist.draw,
                start_seconds=_seconds_since_start(),
            )
    except Interrupted as stop:
        if math.isnan(stop.time):
            raise
        again = f"go on with `myostrain run --resume --out {folder}`"  # it came between two steps
        _leave(_complain(f"{stop} after a checkpoint; {again}", 128 + stop.number))
    if comm.rank == 0:
        _report(checked, results, folder)


def _load_engine() -> None:
    """Import the engine, but without Numba.

    FFCx loads Numba wherever it is installed, for kernels that a script writes in it: a second, and no
    command has any.
    """
    if "numba" in sys.modules:
        return
    sys.modules["numba"] = None  # type: ignore[assignment]
    try:
        import myostrain.engine  # noqa: F401
    finally:
        del sys.modules["numba"]


def _resumed(asked: Case | None, out: Path | None, overrides: list[str], *, force: bool) -> tuple[Case, bool]:
    """The case to go on with, and whether there is something to go on from.

    The same command with --resume may be given again and again, as batch scripts do: it begins, goes on, or
    shows the results. What does not change the meaning of a state may be another value.
    """
    from myostrain.case.case import Case
    from myostrain.case.running import goes_on, pictures_missing
    from myostrain.output.folder import check_path, load_results
    from myostrain.run.resume import differences, fixed, said

    if out is None or (asked is None and force):
        raise InputError("needs --out DIR, the folder to go on with, and no --force", "--resume")
    check_path(out, "--out")
    kept = out / "case.toml"
    if not kept.is_file():
        if asked is None:
            raise InputError(f"{out} holds no case.toml, so there is no run to go on with", "--resume")
        return asked, False
    before = Case.from_file(kept)
    case = asked or (Case.from_file(kept, overrides) if overrides else before)
    if refused := fixed(differences(before.parameters, case.parameters)):
        raise InputError(
            f"{out} holds a run of another case, or with other values ({before.name}, see {kept}: "
            f"{said(refused)}); leave CASE and --set out to go on with it, or name another folder",
            "--resume",
        )
    if (out / "results.json").exists() and not goes_on(case, load_results(out)) and _first_process():
        then = "; drawing what is missing of its figures" if pictures_missing(out) else ""
        screen.print(f"the run in {out} had ended already{then}")
    return case, True


@app.command()
def reproduce(
    what: Annotated[
        list[str] | None, typer.Argument(metavar="WHAT", help="Chapters, or open-questions; all by default.")
    ] = None,
    out: Annotated[Path, typer.Option("--out", metavar="DIR", help="Folder of the page.")] = Path(
        "runs/reproduce"
    ),
    quick: Annotated[
        bool, typer.Option("--quick", help="Coarser settings; takes about four minutes.")
    ] = False,
    fresh: Annotated[
        bool, typer.Option("--fresh", help="Compute everything again; use no earlier outcomes.")
    ] = False,
    quiet: Quiet = False,
) -> None:
    """Reproduce the paper, with a verdict on each statement.

    Its figures, theory and claims stand beside what is measured, on one HTML page.
    """
    _load_engine()
    from myostrain.reproduce import reproduce as make

    with ProgressDisplay(True, bar=not quiet) as display:
        numbers = make(what or (), out, quick=quick, fresh=fresh, tell=display.computations)
    for name, chapter in numbers["chapters"].items():
        for claim, judged in chapter["verdicts"].items():
            reading = f": {judged['reading']}" if judged["verdict"] == "agrees with a reading" else ""
            screen.print(f"{name:14} {claim:34} {judged['verdict']}{reading}")
    screen.print(f"{out / 'index.html'} (open it in a browser), numbers in {out / 'numbers.json'}")


@app.command()
def doctor() -> None:
    """Check the installation, in ten seconds.

    It prints the environment, and checks that it computes correctly.
    """
    _load_engine()
    from myostrain.doctor import report

    raise typer.Exit(report(typer.echo))


@contextlib.contextmanager
def _warnings_shown(active: bool, *, once: bool = False) -> Iterator[None]:
    """Show the warnings of ``run.log`` on the terminal too; once those that are the same, if asked for."""
    handler = _Warnings()
    if once:
        handler.addFilter(_Once())
    logger = logging.getLogger("myostrain")
    if active:
        logger.addHandler(handler)
    try:
        yield
    finally:
        logger.removeHandler(handler)


class _Once(logging.Filter):
    """Lets a message through the first time."""

    def __init__(self) -> None:
        super().__init__()
        self._said: set[str] = set()

    def filter(self, record: logging.LogRecord) -> bool:
        """Whether it was not there yet."""
        text = record.getMessage()
        new = text not in self._said
        self._said.add(text)
        return new


class _Warnings(logging.Handler):
    def emit(self, record: logging.LogRecord) -> None:
        """Show one."""
        if record.levelno == logging.WARNING:
            errors.print(f"myostrain: {record.getMessage()}")


def _seconds_since_start() -> float:
    """Seconds that this process is old, the loading of Python and of all else included."""
    with contextlib.suppress(OSError, AttributeError, IndexError, ValueError):  # where the system tells
        began = float(Path("/proc/self/stat").read_text().rpartition(")")[2].split()[19])
        return max(0.0, time.clock_gettime(time.CLOCK_BOOTTIME) - began / os.sysconf("SC_CLK_TCK"))
    return time.process_time()


def _report(case: Case, results: dict[str, Any], folder: Path) -> None:
    from myostrain.output.quantities import attributes

    screen.print(f"{case.title}")
    numbers = {k: v for k, v in results["metrics"].items() if v is not None and not SEGMENT.fullmatch(k)}
    width = max((len(name) for name in numbers), default=0)
    for name, value in numbers.items():
        unit = attributes(name, results.get("units", {}), case.dim).get("units", "1")
        screen.print(f"  {name:{width}} {float(value):.5g}{'' if unit == '1' else f' {unit}'}")
    if rows := clinical(results["metrics"], results.get("units", {})):
        screen.print("the heart")
        for name, value, unit in rows:
            screen.print(f"  {name:32} {value:10.4g} {unit}")
    seconds = results["seconds"]
    phases = ", ".join(
        f"{phase} {seconds[phase]:.1f}"
        for phase in ("start", "setup", "potential", "mechanics", "output", "figures")
        if phase in seconds
    )
    screen.print(
        f"{results['steps']} steps to t = {results['time']:g} on {results['cells']} cells "
        f"in {seconds['total']:.1f} s ({phases})"
    )
    screen.print(f"numbers in {folder / 'results.json'}, pictures in {folder / 'figures'}")


def main() -> NoReturn:
    """Run the command line: 0 done, 2 wrong input, 3 failed computation, 128 + n ended by signal n."""
    signal.signal(signal.SIGTERM, _terminate)
    for stream in (sys.stdout, sys.stderr):  # a terminal without our letters gets their codes
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")
    try:
        _check_encoding(sys.argv[1:])
        stopped = app(standalone_mode=False)
        status = stopped if isinstance(stopped, int) else 0
        if status == 128 + signal.SIGINT:  # typer has turned an exception into this
            _interrupted()
    except InputError as error:
        status = _complain(str(error), 2)
    except ComputationError as error:
        colon = ":" if error.time is None else ""  # else "at t = ...:" follows
        status = _complain(f"the computation failed{colon} {error}", 3)
    except typer.Exit as stop:
        status = stop.exit_code
    except KeyboardInterrupt:
        _interrupted()
    except Exception as error:  # noqa: BLE001
        status = _usage(error)
    _leave(status)


def _check_encoding(arguments: list[str]) -> None:
    """Refuse arguments that are not UTF-8, beside which DOLFINx cannot be imported."""
    for argument in arguments:
        try:
            argument.encode()
        except UnicodeEncodeError:
            raise InputError(
                f"{argument!a} is not UTF-8; rename the file or folder, or set a locale of UTF-8, such as "
                "LC_ALL=C.UTF-8"
            ) from None


def _usage(error: Exception) -> int:
    if type(error).__name__ == "Abort":
        _interrupted()
    if hasattr(error, "show"):  # an option or argument that does not exist
        if _first_process():
            error.show()
        return 2
    traceback.print_exc()
    return 1


def _complain(message: str, status: int) -> int:
    if _first_process():
        errors.print(f"myostrain: {message}")
    return status


def _first_process() -> bool:
    engine = sys.modules.get("mpi4py.MPI")
    return engine is None or engine.COMM_WORLD.rank == 0


def _terminate(number: int, frame: FrameType | None) -> NoReturn:
    """SIGTERM outside the steps of a run, which handle it themselves."""
    _terminated.append(number)
    raise Interrupted(number, math.nan)


def _interrupted() -> NoReturn:
    """Exit after a signal that came outside the steps of a run."""
    status = 128 + (_terminated or [signal.SIGINT])[0]
    _leave(_complain("interrupted; what was written so far stays readable", status), alone=True)


def _leave(status: int, *, alone: bool = False) -> NoReturn:
    """Exit; when this process alone failed or stopped, take the others along so that none hangs."""
    engine = sys.modules.get("mpi4py.MPI")
    if (alone or status == 1) and engine is not None and engine.COMM_WORLD.size > 1:
        sys.stdout.flush()
        sys.stderr.flush()
        engine.COMM_WORLD.Abort(status)
    sys.exit(status)
