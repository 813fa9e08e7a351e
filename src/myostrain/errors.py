"""What can go wrong, in two kinds: the user's input, and the computation."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Sequence
from typing import Any


class MyostrainError(Exception):
    """Base of every error that myostrain raises on purpose."""


class InputError(MyostrainError, ValueError):
    """A value that the user gave cannot be used (exit status 2 on the command line).

    Args:
        message: What is wrong, what is allowed, what to try.
        key: The dotted key of a case file that the message is about, if there is one.
    """

    def __init__(self, message: str, key: str | None = None) -> None:
        super().__init__(message if key is None else f"{key}: {message}")
        self.key = key


class UnknownName(InputError, KeyError):
    """A name that a mapping does not hold; also a ``KeyError``, so that ``in`` and ``get`` work."""

    def __str__(self) -> str:
        """The message; that of a ``KeyError`` would be in quotes."""
        return str(self.args[0])


class ComputationError(MyostrainError, RuntimeError):
    """The computation failed although the input was acceptable (exit status 3).

    Args:
        reason: What happened.
        time: Simulated time at which it happened, if known.
        advice: What to try.
        where: Material coordinates of the worst place, if there is one.
    """

    def __init__(
        self,
        reason: str,
        *,
        time: float | None = None,
        advice: str | None = None,
        where: Sequence[float] | None = None,
    ) -> None:
        when = "" if time is None else f"at t = {time:.6g}: "
        then = "" if advice is None else f". Try: {advice}"
        super().__init__(f"{when}{reason.rstrip('.') if then else reason}{then}")
        self.reason = reason
        self.time = time
        self.advice = advice
        self.where = None if where is None else list(where)

    def at(self, time: float) -> ComputationError:
        """The same failure, with the simulated time at which it happened."""
        return type(self)(self.reason, time=time, advice=self.advice, where=self.where)

    def adding(self, more: str) -> ComputationError:
        """The same failure with more said about it; itself where there is nothing."""
        if not more:
            return self
        return type(self)(f"{self.reason}; {more}", time=self.time, advice=self.advice, where=self.where)


class Interrupted(KeyboardInterrupt):
    """A signal ended the run after a step and a checkpoint (exit status 128 + its number).

    Args:
        number: The signal's number, such as ``signal.SIGTERM``.
        time: Simulated time that the run had reached.
    """

    def __init__(self, number: int, time: float) -> None:
        super().__init__(f"interrupted at t = {time:.6g}")
        self.number, self.time = number, time


def nearest(word: str, known: Iterable[str]) -> str:
    """A half sentence that names what ``word`` may have been meant to be, or all that is known."""
    names = sorted(known)
    close = difflib.get_close_matches(word, names, n=1, cutoff=0.5)
    if not close:  # capitals, or none
        small = {name.casefold(): name for name in names}
        close = [small[name] for name in difflib.get_close_matches(word.casefold(), small, n=1, cutoff=0.5)]
    listed = f"known: {', '.join(names)}"
    return f"did you mean '{close[0]}'? ({listed})" if close else listed


def shown(value: Any) -> str:
    """A value for a message: short, whatever it is."""
    try:
        text = repr(value)
    except (ValueError, RecursionError):  # an integer of thousands of digits, tables in tables
        text = f"such a long {type(value).__name__}"
    return text if len(text) <= 100 else f"{text[:90]}..."


def dotted(*parts: str) -> str:
    """A key for a message; a strange part is quoted and cut."""
    return ".".join(part if part.isprintable() and 0 < len(part) <= 50 else shown(part) for part in parts)
