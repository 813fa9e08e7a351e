"""Work against precision of `sheet-2d` beside a textbook DOLFINx solution: docs/benchmarks.md and its plot.

    python benchmarks/work_precision.py [--repeat 3] [--textbook-steps 60] [--end 3.0] [--reuse FILE]

Every measurement is a process of its own (`measure.py`); repeats go round and round through all variants, so
that a machine whose speed drifts treats them alike, and medians are quoted. The textbook's step costs the
same all along the run, so that its time to t = 3 is steps times the median step of its beginning.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from statistics import median

import page
from apart import apart

HERE = Path(__file__).parent

SPACING = 1.214  # of sheet-2d: 12,097 nodes
COARSE = 2.428  # 3,169 nodes
FINE = 0.607  # 48,007 nodes
#: To where the paper's scheme and the textbook are run once, for their errors: the first probe is reached.
ONCE = 0.54
TEXTBOOK_STEP = 1e-3

#: Time-step variants of the fast scheme on the mesh of sheet-2d: step, mechanics every.
STEPS = [(2e-3, 2), (3e-3, 4), (4e-3, 4), (8e-3, 2), (10e-3, 2), (16e-3, 1)]
#: Variants in space: spacing, step, every.
MESHES = [(0.86, 3e-3, 4), (1.214, 3e-3, 4), (1.7, 6e-3, 2), (COARSE, 8e-3, 2), (COARSE, 16e-3, 1)]
#: Refinements at one step, for the cost a node, on one process and on two.
SCALING = [COARSE, SPACING, FINE, 0.4, 0.3035]
PROCESSES = [1, 2]


def measure(*arguments: str, processes: int = 1) -> dict:
    """Run one measurement."""
    print("  ", *arguments, f"({processes} processes)" if processes > 1 else "", flush=True)
    return apart(HERE / "measure.py", *arguments, processes=processes)


def ours(step: float, every: int, spacing: float = SPACING, *more: str) -> list[str]:
    """Arguments of a run of the fast scheme."""
    return ["sheet", f"time.step={step}", f"mechanics.every={every}", f"geometry.spacing={spacing}", *more]


def rounds(variants: dict[str, list[str]], repeat: int) -> dict[str, dict]:
    """Measure each variant ``repeat`` times in turn; medians of the times, the rest from the last."""
    seen: dict[str, list[dict]] = {name: [] for name in variants}
    for _ in range(repeat):
        for name, arguments in variants.items():
            seen[name].append(measure(*arguments))
    times = ("stepping", "step", "to_first_step")
    return {
        name: {
            **runs[-1],
            **{key: median(run[key] for run in runs) for key in times if key in runs[0]},
            "spread": [min(values), max(values)]
            if (values := [run[key] for run in runs for key in ("stepping", "step") if key in run])
            else None,
        }
        for name, runs in seen.items()
    }


def everything(repeat: int, textbook_steps: int, end: float) -> dict:
    """All measurements, by name."""
    until = f"time.end={end}"
    found: dict = {"end": end, "repeat": repeat, "textbook_steps": textbook_steps}
    print("variants in turn")
    variants = {"textbook": ["textbook", str(textbook_steps), str(TEXTBOOK_STEP), str(SPACING)]}
    variants["first order"] = ["sheet", "time.scheme=implicit", "mechanics.every=1", "time.step=1e-3"]
    variants["first order"] += [f"time.end={textbook_steps * 1e-3}", "probes={}"]
    variants |= {f"time {step} {every}": [*ours(step, every), until] for step, every in STEPS}
    variants |= {f"space {h} {step} {every}": [*ours(step, every, h), until] for h, step, every in MESHES}
    variants["line"] = ["line", "time.step=8e-3", "output.rigid_twin=false"]
    found |= rounds(variants, repeat)
    print("two processes, refinements")
    for h in SCALING:
        for n in PROCESSES:
            found[f"scaling {h} {n}"] = measure(*ours(3e-3, 4, h, "time.end=0.18", "probes={}"), processes=n)
    print("references, once")
    found["reference in time"] = measure(*ours(1e-3, 1), until)
    found["reference in space"] = measure(*ours(2e-3, 2, FINE), until)
    found["reference of the line"] = measure("line", "time.step=5e-4", "output.rigid_twin=false")
    print("errors of the first-order scheme and of the textbook, once")
    found["first order, arrival"] = measure(
        "sheet", "time.scheme=implicit", "mechanics.every=1", "time.step=1e-3", f"time.end={ONCE}"
    )
    for name, h, step in (
        ("textbook, arrival", SPACING, TEXTBOOK_STEP),
        ("textbook, coarse", COARSE, TEXTBOOK_STEP),
        ("textbook, coarse, half the step", COARSE, TEXTBOOK_STEP / 2),
    ):
        found[name] = measure("textbook", str(round(ONCE / step)), str(step), str(h))
    found["textbook, finer"] = measure("textbook", "5", str(TEXTBOOK_STEP), "0.607")
    found["coasting"] = measure("coasting", "output.every=3.0")
    found["bandwidth"] = measure("bandwidth")["bytes_per_second"]
    return found


def main() -> None:
    """Measure, write the page and the plot."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeat", type=int, default=3)
    parser.add_argument("--textbook-steps", type=int, default=60)
    parser.add_argument("--end", type=float, default=3.0)
    parser.add_argument("--reuse", type=Path, help="write the page from the measurements in this file")
    arguments = parser.parse_args()
    kept = arguments.reuse or HERE.parent / "runs" / "benchmarks.json"
    if not arguments.reuse:
        found = everything(arguments.repeat, arguments.textbook_steps, arguments.end)
        kept.parent.mkdir(exist_ok=True)
        kept.write_text(json.dumps(found, indent=1), encoding="utf-8")
    page.write(json.loads(kept.read_text(encoding="utf-8")))


if __name__ == "__main__":
    main()
