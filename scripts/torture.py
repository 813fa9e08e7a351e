"""Torture runs of the command line: kill, interrupt, damage, crowd out; resume, and compare the results.

    python scripts/torture.py [--quick] [--seed N] [--keep DIR]

Prints a table, and what went wrong; the exit status is 0 if nothing did.
"""

import argparse
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

from torture.campaign import Campaign, table
from torture.live import BARE, LINE, SHEET, SUBJECTS, Row, on


def quick(campaign: Campaign) -> Iterator[Row]:
    """The sample that the tests run too."""
    yield campaign.kills(LINE, 6)
    yield campaign.signals(BARE, 1)
    yield campaign.other_processes(BARE, 2, 1)
    yield campaign.damage(BARE, flips=1, kinds=("middle",))
    yield campaign.file_limit(BARE, (0.8,))
    yield campaign.in_use(BARE)


def whole(campaign: Campaign) -> Iterator[Row]:
    """Everything: about half an hour."""
    for processes in (1, 2):
        for subject in SUBJECTS:
            yield campaign.kills(on(processes, subject), 20 if subject is SHEET else 8)
        yield campaign.signals(on(processes, SHEET), 5)
        yield campaign.signals(on(processes, BARE), 4, twice=True)
    for subject in SUBJECTS:
        yield campaign.other_processes(subject, 1, 2)
        yield campaign.other_processes(subject, 2, 1)
    yield campaign.damage(BARE, flips=8)
    yield campaign.damage(on(2, BARE), flips=1)
    yield campaign.file_limit(SHEET, (0.1, 0.3, 0.5, 0.8, 0.95))
    yield campaign.small_disk(SHEET, (0.05, 0.2, 0.4, 0.6, 0.8))
    for subject in (SHEET, BARE):
        yield campaign.unwritable(subject)
        yield campaign.in_use(subject)
        yield campaign.at_once(subject)


def main() -> int:
    """Run a campaign and print its table."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--quick", action="store_true", help="a sample, in a minute or two")
    parser.add_argument("--seed", type=int, default=0, help="of the moments and places of the faults")
    parser.add_argument("--keep", type=Path, help="write the runs here and keep them")
    options = parser.parse_args()
    begin = time.monotonic()

    def say(text: str) -> None:
        print(f"{time.monotonic() - begin:6.0f} s  {text}", file=sys.stderr, flush=True)

    with tempfile.TemporaryDirectory() as temporary:
        folder = options.keep or Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        campaign = Campaign(folder, options.seed, say)
        rows = []
        for row in (quick if options.quick else whole)(campaign):
            rows.append(row)
            say(table([row]).partition("\n")[2])
    print(table(rows))
    return 0 if all(row.clean for row in rows) else 1


if __name__ == "__main__":
    sys.exit(main())
