"""Which variable of a file is what: the potential, the calcium, a stimulus of the file's own."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import replace

from myostrain.errors import InputError, nearest
from myostrain.membranes.files.contents import Contents
from myostrain.membranes.files.formulas import Formula, names, number, ordered

POTENTIALS = ("v", "vm", "v_m", "voltage", "membrane_potential", "transmembrane_potential", "potential", "em")
CALCIUMS = ("cai", "ca_i", "ca_cyt", "cacyt", "cytosolic_calcium", "cytosolic_ca", "calcium")
#: Parameters of a stimulus without which it is none.
STRENGTHS = ("amp", "strength", "current")


def short(name: str) -> str:
    """A name without its component, in small letters."""
    return name.rsplit(".", 1)[-1].lower()


def listed(names: Iterable[str]) -> str:
    """Names for a message, the first ones."""
    found = list(names)
    return ", ".join(found[:30]) + (", ..." if len(found) > 30 else "")


def potential_of(contents: Contents, given: str | None) -> str:
    """The state that is the potential.

    Raises:
        InputError: None is named so, or several are.
    """
    if given is not None:
        return _state(contents, given, "cell.potential")
    said = contents.roles.get("potential")
    found = [said] if said in contents.states else [s for s in contents.states if short(s) in POTENTIALS]
    if len(found) == 1 and found[0] is not None:
        return found[0]
    what = "several states may be the potential" if found else "which state is the potential cannot be told"
    raise InputError(
        f"{what}: name it, potential = ...; the states are {listed(found or contents.states)}",
        "cell.potential",
    )


def calcium_of(contents: Contents, given: str | None) -> str | None:
    """The state that is the cytosolic calcium; None if none is named so."""
    if given is not None:
        return _state(contents, given, "cell.calcium")
    said = contents.roles.get("calcium")
    found = [said] if said in contents.states else [s for s in contents.states if short(s) in CALCIUMS]
    return found[0] if len(found) == 1 else None


def _state(contents: Contents, given: str, key: str) -> str:
    if given not in contents.states:
        raise InputError(f"'{given}' is not a state of the file; {nearest(given, contents.states)}", key)
    return given


def without_stimulus(contents: Contents, also: Sequence[str]) -> tuple[Contents, tuple[str, ...], set[str]]:
    """The contents with the file's own stimulus at zero.

    Args:
        contents: The contents.
        also: Names of further variables that are a stimulus.

    Returns:
        The contents; what was switched off; parameters that had been the stimulus's only.

    Raises:
        InputError: A name is none, or a state's.
    """
    for name in also:
        if name not in contents.formulas and name not in contents.parameters:
            known = nearest(name, [*contents.formulas, *contents.parameters])
            raise InputError(f"'{name}' is not a variable that can be switched off; {known}", "cell.stimulus")
    before = reached(contents)
    said = contents.roles.get("stimulus")
    off = [
        name
        for name in (*contents.formulas, *contents.parameters)
        if name in also or (name in before and (name == said or _is_stimulus(name, contents.parameters)))
    ]
    formulas = contents.formulas | {name: number(0) for name in off}
    changed = replace(
        contents,
        formulas=formulas,
        parameters={n: x for n, x in contents.parameters.items() if n not in off},
    )
    gone = {n for n in contents.parameters if n in off or (n in before and n not in reached(changed))}
    # What led to the stimulus only is not said: naming the stimulus is enough.
    ends = [
        n for n in off if not any(n in names(contents.formulas[m]) for m in off if m in contents.formulas)
    ]
    changed = replace(changed, parameters={n: x for n, x in changed.parameters.items() if n not in gone})
    return changed, tuple(ends), gone


def _is_stimulus(name: str, parameters: Collection[str]) -> bool:
    last = short(name)
    if name not in parameters:
        return "stim" in last
    if "stim" not in last:
        # A component's, such as membrane.stim.amplitude or stimulus.amplitude.
        within = name.lower().rsplit(".", 1)[0] if "." in name else ""
        return "stim" in within and any(word in last for word in STRENGTHS)
    bare = last.replace("_", "")
    return bare in ("stim", "istim", "stimulus", "istimulus") or any(word in last for word in STRENGTHS)


def reached(contents: Contents) -> set[str]:
    """The variables on which a rate depends."""
    found = set().union(*(names(rate) for rate in contents.rates.values()))
    for name in ordered(sorted(found), contents.formulas):
        found |= {name, *names(contents.formulas[name])}
    return found


def chain_to(wanted: Collection[str], start: str, formula: Formula, formulas: Mapping[str, Formula]) -> str:
    """How a variable depends on one of some, such as "V → i_pulse → time"; empty if it does not."""
    left, seen = [(start, formula)], {start}
    while left:
        path, at = left.pop(0)
        for name in sorted(names(at)):
            if name in wanted:
                return f"{path} → {name}"
            if name in formulas and name not in seen:
                seen.add(name)
                left.append((f"{path} → {name}", formulas[name]))
    return ""
