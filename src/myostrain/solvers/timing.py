"""Seconds spent in the phases of a run."""

from __future__ import annotations

import functools
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any


@contextmanager
def charged(to: Any) -> Iterator[None]:
    """Add the wall-clock seconds of what is done meanwhile to an object's ``seconds``, once if nested."""
    before, begin = to.seconds, time.perf_counter()
    try:
        yield
    finally:
        to.seconds = before + time.perf_counter() - begin


def timed[F: Callable[..., Any]](method: F) -> F:
    """Add the wall-clock seconds of each call of a method to its object's ``seconds``."""

    @functools.wraps(method)
    def wrapper(self: Any, *args: Any, **kwargs: Any) -> Any:
        with charged(self):
            return method(self, *args, **kwargs)

    return wrapper  # type: ignore[return-value]
