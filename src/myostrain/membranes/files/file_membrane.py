"""A membrane whose equations are in a file."""

from __future__ import annotations

import dataclasses
import functools
import logging
import stat
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, ClassVar

from myostrain.errors import InputError, nearest
from myostrain.membranes.files import myokit_models, ode, roles
from myostrain.membranes.files.contents import Contents, Unreadable
from myostrain.membranes.files.formulas import Values, depth, names, ordered, undefined
from myostrain.validation import Finite, description, flat

log = logging.getLogger("myostrain")

KEY = "cell.path"
#: Bytes of a file at most: models of cells have some ten thousand.
MAX_FILE = 10_000_000
#: Operations in operations at most, a sum of as many terms among them: formulas are walked recursively.
DEEPEST = 150
READERS: dict[str, Callable[[str], Contents]] = {
    ".ode": ode.read_ode,
    ".mmt": myokit_models.read_mmt,
    ".cellml": myokit_models.read_cellml,
}
#: Lowest and highest potential to expect and threshold, by unit; of potentials from 0 to 1 without one.
RANGES = {"mV": ((-90.0, 50.0), -40.0), "V": ((-0.09, 0.05), -0.04)}


@description
class FileMembrane:
    """A cell from a file of another program: gotran's ``.ode``, Myokit's ``.mmt``, or ``.cellml``.

    Parameters and states have the file's names, such as "g_Na", or "ina.gmax" where they lie in components.
    In a case, parameters are keys of [cell] too: ``g_Na = 10.0``, or ``ina.gmax = 10.0``. The stimulus of a
    file is switched off: variables that are called so, the strength of its parameters, what Myokit paces.
    The file says du/dt in units of its own; nothing is converted. Nothing in it is run as code.

    Args:
        path: The file. In a case file, relative to the case file's folder.
        parameters: Values of parameters, by name; of others the file's.
        initial_states: What states start from, the potential among them, by name; others as in the file.
        potential: Name of the state that is the potential, where its name does not tell.
        calcium: Name of the state that is the calcium which drives contraction, where its name does not tell.
        calcium_unit: Its unit, where the file does not say.
        time_unit: Unit of time, where the file does not say.
        potential_unit: Unit of the potential, where the file does not say.
        range: Lowest and highest potential to expect; [−90, 50] mV or [0, 1] unless given.
        threshold: The potential above which a node counts as activated; −40 mV or the middle of the range
            unless given.
        pacing: Strength (rate of v) and duration of the stimulus that excites a single cell.
        stimulus: Names of variables that are the file's own stimulus, where their names do not tell.
    """

    path: Path
    parameters: Mapping[str, Finite] = dataclasses.field(default_factory=dict)
    initial_states: Mapping[str, Finite] = dataclasses.field(default_factory=dict)
    potential: str | None = None
    calcium: str | None = None
    calcium_unit: str | None = None
    time_unit: str | None = None
    potential_unit: str | None = None
    range: tuple[Finite, Finite] | None = None
    threshold: Finite | None = None
    pacing: tuple[Finite, Finite] | None = None
    stimulus: tuple[str, ...] = ()
    gates: ClassVar[tuple[str, ...]] = ()
    conserved: ClassVar[tuple[str, ...]] = ()
    #: Which states are gates is not known, but that cells have them is.
    exponential: ClassVar[bool] = True
    # Of each object, made when it is.
    states: ClassVar[tuple[str, ...]] = ()
    _contents: ClassVar[Contents]
    _attributes: ClassVar[dict[str, str]]
    _orders: ClassVar[tuple[list[str], list[str]]]

    @classmethod
    def gathered(cls, section: Mapping[str, Any]) -> dict[str, Any]:
        """A section [cell] with the parameters that are keys of it, or tables of it, under ``parameters``.

        Of a parameter that is given twice, the key of the section itself counts.
        """
        known = {field.name for field in dataclasses.fields(cls)}
        found = {key: value for key, value in section.items() if key in known}
        for table in ("parameters", "initial_states"):
            if isinstance(found.get(table), Mapping):
                found[table] = flat(found[table])
        others = flat({key: value for key, value in section.items() if key not in known})
        if others and isinstance(found.get("parameters", {}), Mapping):
            found["parameters"] = found.get("parameters", {}) | others
        return found

    def __post_init__(self) -> None:
        """Read the file, and find out what is what."""
        contents = _read(self.path)
        v = roles.potential_of(contents, self.potential)
        contents, off, gone = roles.without_stimulus(contents, self.stimulus)
        if off and off != self.stimulus:
            log.warning(
                "%s: the stimulus of %s is switched off: %s = 0; [[stimulus]] excites",
                KEY,
                self.path.name,
                " = ".join(off),
            )
        for state, rate in contents.rates.items():
            if chain := roles.chain_to(contents.time, f"the rate of {state}", rate, contents.formulas):
                raise InputError(
                    f"{self.path.name} depends on time, which is not allowed but for a stimulus: {chain}; if "
                    "one of these is the stimulus, name it: stimulus = [...]",
                    KEY,
                )
        parameters = contents.parameters | _checked(
            self.parameters, contents.parameters, "parameters", contents, gone
        )
        states = contents.states | _checked(self.initial_states, contents.states, "initial_states", contents)
        others = tuple(s for s in contents.states if s != v)
        calcium = roles.calcium_of(contents, self.calcium)
        if calcium == v:
            raise InputError(f"'{v}' is the potential", "cell.calcium")
        put = functools.partial(object.__setattr__, self)
        put("parameters", parameters)
        put("initial_states", states)
        put("potential", v)
        put("calcium", calcium)
        put("stimulus", off)
        for of, said in (
            ("calcium_unit", contents.units.get(calcium or "")),
            ("time_unit", contents.time_unit),
            ("potential_unit", contents.units.get(v)),
        ):
            given = getattr(self, of)
            if said is not None and given is not None and given != said:
                raise InputError(f"the file says {said}, not {given}; leave this out", f"cell.{of}")
            put(of, given or said)
        self._expect(states[v])
        # The tracer and variations in space know parameters as numbers among the attributes.
        taken = {name for name in parameters if name.startswith("_") or hasattr(self, name)}
        put("_attributes", {name: f"file.{name}" if name in taken else name for name in parameters})
        for name, value in parameters.items():
            put(self._attributes[name], float(value))
        put("_contents", contents)
        put("states", others)
        put("_orders", (self._order([v]), self._order(others)))

    def _expect(self, rest: float) -> None:
        """Range and threshold of the potential."""
        if self.range is None:
            unit = self.potential_unit or ("mV" if rest < -20 else None)
            if unit not in RANGES and not -0.25 <= rest < 0.5:
                raise InputError(
                    f"the potential starts at {rest:g}{f' {unit}' if unit else ''}, and what it ranges over "
                    "cannot be told: give range = [lowest, highest]",
                    "cell.range",
                )
            found, threshold = RANGES.get(unit or "", ((0.0, 1.0), 0.5))
            object.__setattr__(self, "range", found)
            if self.threshold is None:
                object.__setattr__(self, "threshold", threshold)
        low, high = self.range  # type: ignore[misc]
        if not low < high:
            raise InputError(f"give [lowest, highest], not [{low:g}, {high:g}]", "cell.range")
        if self.threshold is None:
            object.__setattr__(self, "threshold", 0.5 * (low + high))
        if not low < self.threshold < high:  # type: ignore[operator]
            raise InputError(f"{self.threshold:g} is not within [{low:g}, {high:g}]", "cell.threshold")

    def _order(self, states: Sequence[str]) -> list[str]:
        needed = sorted(set().union(*(names(self._contents.rates[s]) for s in states)) if states else ())
        return ordered(needed, self._contents.formulas)

    @property
    def files(self) -> tuple[Path, ...]:
        """What is read: a run is resumed with the same only."""
        return (self.path,)

    def resting_potential(self) -> float:
        """What the potential starts from."""
        return float(self.initial_states[self.potential])  # type: ignore[index]

    def resting_states(self) -> tuple[float, ...]:
        """What the other states start from."""
        return tuple(float(self.initial_states[name]) for name in self.states)

    def _rates(self, v: Any, states: Sequence[Any], wanted: Sequence[str], order: Sequence[str]) -> list[Any]:
        given = {name: getattr(self, attribute) for name, attribute in self._attributes.items()}
        given |= {str(self.potential): v, **dict(zip(self.states, states, strict=True))}
        values = Values(given, self._contents.formulas, self.potential)
        values.compute(order)
        return [values.of(self._contents.rates[name]) for name in wanted]

    def current(self, v: Any, states: Sequence[Any]) -> Any:
        """The rate of the potential with the opposite sign, without a stimulus."""
        return -self._rates(v, states, [self.potential or ""], self._orders[0])[0]

    def rates(self, v: Any, states: Sequence[Any]) -> Sequence[Any]:
        """The rates of the other states, as the file has them."""
        return self._rates(v, states, self.states, self._orders[1])


def _checked(
    given: Mapping[str, float],
    known: Mapping[str, float],
    table: str,
    contents: Contents,
    gone: frozenset[str] | set[str] = frozenset(),
) -> dict[str, float]:
    """Given values; names that are not known are refused.

    Raises:
        InputError: There is such a name.
    """
    for name in given:
        if name in known:
            continue
        key = f"cell.{table}.{name}"
        if name in gone:
            raise InputError(
                "this is of the file's own stimulus, which is switched off: use [[stimulus]]", key
            )
        if name in contents.states:
            raise InputError("this is a state: give what it starts from in cell.initial_states", key)
        if name in contents.formulas:
            raise InputError("this is computed from others, see the file; it cannot be set", key)
        raise InputError(f"the file has no such name; {nearest(name, known)}", key)
    return dict(given)


def _read(path: Path) -> Contents:
    """The contents of a file, checked.

    Raises:
        InputError: It cannot be read.
    """
    try:
        status = path.stat()
        if stat.S_ISDIR(status.st_mode):
            raise InputError(f"{path} is a folder, not a file", KEY)
        if not stat.S_ISREG(status.st_mode):
            raise InputError(f"{path} is not a regular file", KEY)
        if not 0 < status.st_size <= MAX_FILE:
            raise InputError(f"{path} has {status.st_size} bytes: it is not a model of a cell", KEY)
        reader = READERS.get(path.suffix.lower())
        if reader is None:
            raise InputError(f"'{path.name}' should end with one of {', '.join(READERS)}", KEY)
        text = path.read_text(encoding="utf-8-sig")
    except InputError:
        raise
    except (FileNotFoundError, NotADirectoryError):
        raise InputError(f"there is no file {path}", KEY) from None
    except OSError as error:
        raise InputError(f"the file {path} cannot be read: {error.strerror}", KEY) from None
    except ValueError as error:  # a zero byte in the name, and what is not UTF-8
        raise InputError(f"{str(path)!r} cannot be read: {error}", KEY) from None
    try:
        return _parsed(reader, text)
    except Unreadable as error:
        raise InputError(f"{path.name}: {error}", KEY) from None


@functools.lru_cache(maxsize=8)
def _parsed(reader: Callable[[str], Contents], text: str) -> Contents:
    """What a file's text says.

    Raises:
        Unreadable: It is no model of a cell.
        InputError: A package is missing, or cannot write where it wants to.
    """
    try:
        found = reader(text)
    except ImportError as error:
        raise InputError(
            f"models from files need a package that is not there ({error}): pip install "
            "'myostrain[cellfiles]'",
            KEY,
        ) from None
    except OSError as error:
        raise InputError(
            f"the package that reads the file could not write ({error}); Myokit keeps settings in "
            "~/.config/myokit: set HOME to a folder that can be written, and TMPDIR where the disk is full",
            KEY,
        ) from None
    except RecursionError:
        raise Unreadable("its formulas are too deep") from None
    if not found.states:
        raise Unreadable("it has no states: it is not a model of a cell")
    if max(map(depth, (*found.formulas.values(), *found.rates.values()))) > DEEPEST:
        raise Unreadable(f"its formulas are too deep: more than {DEEPEST} operations in operations")
    known = {*found.parameters, *found.states, *found.time}
    for missing, variable in undefined({**found.formulas, **found.rates}, known).items():
        every = sorted({*known, *found.formulas})
        raise Unreadable(
            f"{missing}, of which {variable} is made, is nowhere defined; {_near(missing, every)}"
        )
    try:
        ordered(sorted(found.formulas), found.formulas)
    except ValueError as error:
        raise Unreadable(f"variables are computed from each other in a circle: {error}") from None
    return found


def _near(word: str, known: Sequence[str]) -> str:
    """What a name may have been meant to be, without a list of hundreds."""
    said = nearest(word, known)
    return said.split(" (known")[0] if said.startswith("did you mean") else f"known: {roles.listed(known)}"
