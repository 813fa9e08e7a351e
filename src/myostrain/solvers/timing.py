"""Seconds spent in the phases of a run."""

from __future__ import annotations

import functools
import time
from collections.abc import Callable
from typing import Any


def timed[F: Callable[..., Any]](method: F) -> F:
    """Add the wall-clock seconds of each call of a method to its object's ``seconds``."""

    @functools.wraps(method)
    def wrapper(self: Any, *args: Any, **kwargs: Any) -> Any:
        begin = time.perf_counter()
        try:
            return method(self, *args, **kwargs)
        finally:
            self.seconds += time.perf_counter() - begin

    return wrapper  # type: ignore[return-value]
