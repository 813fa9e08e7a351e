"""Memory and disk that are free, by the system's files; nothing is known where there are none."""

from __future__ import annotations

import math
import shutil
from pathlib import Path

#: What a group has in memory but gives back, by version of its files.
CACHED = ("inactive_file ", "total_inactive_file ")


def free_memory() -> float:
    """Bytes of memory that can be had: of the machine, and of this process's group; infinite if unknown."""
    free = math.inf
    for line in _text(Path("/proc/meminfo")).splitlines():
        if line.startswith("MemAvailable:"):
            free = float(line.split()[1]) * 1024
    root = Path("/sys/fs/cgroup")
    for line in _text(Path("/proc/self/cgroup")).splitlines():
        _, kinds, inside = line.split(":", 2)
        if kinds and "memory" not in kinds.split(","):
            continue
        base = root / "memory" if kinds else root
        names = (
            ("memory.limit_in_bytes", "memory.usage_in_bytes") if kinds else ("memory.max", "memory.current")
        )
        # In a container the path is the host's, and what is mounted is the group itself.
        for place in {base, base / inside.lstrip("/")}:
            limit, used = (_text(place / name).strip() for name in names)
            if limit.isdigit() and used.isdigit():
                cached = [
                    s.split()[1] for s in _text(place / "memory.stat").splitlines() if s.startswith(CACHED)
                ]
                free = min(free, float(limit) - float(used) + max(map(float, cached), default=0.0))
    return max(free, 0.0)


def _text(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8")
    except OSError:
        return ""


def free_disk(folder: Path) -> float:
    """Bytes free where a folder is, or is going to be; infinite if unknown."""
    place = folder.absolute()
    while not place.exists() and place != place.parent:
        place = place.parent
    try:
        usage = shutil.disk_usage(place)
    except OSError:
        return math.inf
    # What has no size at all, as /proc, is no disk: that nothing can be written there is said elsewhere.
    return float(usage.free) if usage.total or usage.free else math.inf
