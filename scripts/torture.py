"""Torture runs of the command line: kill, interrupt, damage, crowd out; resume, and compare the results.

    python scripts/torture.py [--quick] [--seed N] [--minutes N] [--keep DIR]

Prints a table, and what went wrong; the exit status is 0 if nothing did. After so many minutes nothing new is
begun.
"""

import argparse
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

from torture.campaign import Campaign, table
from torture.live import BARE, LINE, SHEET, SOLID, SUBJECTS, Row, on

Rows = Iterator[Callable[[], Row]]


def quick(campaign: Campaign) -> Rows:
    """The sample that the tests run too."""
    yield partial(campaign.kills, LINE, 7)
    yield partial(campaign.signals, BARE, 1)
    yield partial(campaign.other_processes, BARE, 2, 1)
    yield partial(campaign.damage, BARE, flips=1, kinds=("middle",))
    yield partial(campaign.file_limit, BARE, (0.8,))
    yield partial(campaign.in_use, BARE)


def whole(campaign: Campaign) -> Rows:
    """Everything: a quarter of an hour on two cores."""
    for subject in SUBJECTS:
        yield partial(campaign.kills, subject, 14 if subject is SHEET else 7)
    for subject in (SHEET, SOLID):
        yield partial(campaign.kills, on(2, subject), 7)
    yield partial(campaign.cold_kills, BARE, 2)
    for processes in (1, 2):
        yield partial(campaign.signals, on(processes, SHEET), 6)
        yield partial(campaign.signals, on(processes, BARE), 4, twice=True)
    for subject in SUBJECTS:
        yield partial(campaign.other_processes, subject, 1, 2)
        yield partial(campaign.other_processes, subject, 2, 1)
    yield partial(campaign.damage, BARE, flips=3)
    yield partial(campaign.file_limit, SHEET, (0.1, 0.5, 0.9))
    yield partial(campaign.small_disk, SHEET, (0.05, 0.4, 0.8))
    yield partial(campaign.unwritable, BARE)
    yield partial(campaign.in_use, BARE)
    for subject in (SHEET, BARE):
        yield partial(campaign.at_once, subject)


def main() -> int:
    """Run a campaign and print its table."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--quick", action="store_true", help="a sample, in a minute or two")
    parser.add_argument("--seed", type=int, default=0, help="of the moments and places of the faults")
    parser.add_argument("--minutes", type=float, default=15.0, help="begin nothing new after so long")
    parser.add_argument("--keep", type=Path, help="write the runs here and keep them")
    options = parser.parse_args()
    begin = time.monotonic()

    def say(text: str) -> None:
        print(f"{time.monotonic() - begin:6.0f} s  {text}", file=sys.stderr, flush=True)

    with tempfile.TemporaryDirectory() as temporary:
        folder = options.keep or Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        campaign = Campaign(folder, options.seed, say)
        rows, skipped = [], 0
        for make in (quick if options.quick else whole)(campaign):
            if time.monotonic() - begin > 60 * options.minutes:
                skipped += 1
                continue
            rows.append(make())
            say(table(rows[-1:]).partition("\n")[2])
    print(table(rows))
    if skipped:
        print(f"{skipped} rows were not begun: {options.minutes:g} minutes were over (--minutes)")
    return 0 if all(row.clean for row in rows) else 1


if __name__ == "__main__":
    sys.exit(main())
