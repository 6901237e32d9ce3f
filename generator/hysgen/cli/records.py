"""The options by which every verb reads records."""

from __future__ import annotations

import argparse
from pathlib import Path

from hysgen.cli.console import Console
from hysgen.errors import RecordError
from hysgen.record import Columns, Record, load_record
from hysgen.record.checks import ACCEPTABLE
from hysgen.record.sampling import JITTER


def add_record_options(parser: argparse.ArgumentParser) -> None:
    """How records are read: `--columns` for other names, units and separators; what odd samples are let through."""
    parser.add_argument(
        "--columns",
        metavar="KEY=VALUE,...",
        default="",
        help="names, units and separators, e.g. voltage=force_N,displacement=x_nm,separator=tab,Ts_s=2e-5 "
        "(default: time_s, voltage_V, displacement_um)",
    )
    parser.add_argument(
        "--accept", choices=ACCEPTABLE, action="append", default=[], help="take a record in spite of this finding"
    )
    parser.add_argument(
        "--jitter",
        type=float,
        default=JITTER,
        metavar="PART",
        help="deviation of a time stamp that is let through, as a part of the sampling period (default %(default)g)",
    )
    parser.add_argument(
        "--split-at-gaps", action="store_true", help="make segments where time has gaps, instead of refusing"
    )


def read_records(paths: list[str], arguments: argparse.Namespace, console: Console) -> Record:
    """The records at `paths` as segments of one, with its warnings on stderr."""
    columns = Columns.from_text(arguments.columns) if arguments.columns else Columns()
    record = load_record(
        [Path(path) for path in paths],
        columns,
        jitter=arguments.jitter,
        accept=arguments.accept,
        split_at_gaps=arguments.split_at_gaps,
    )
    for warning in record.warnings:
        console.warn(warning)
    return record


def parse_rows(text: str, samples: int) -> tuple[int, int]:
    """Rows "A:B" of a record, counted from 0, B excluded; either may be empty, as in Python.

    >>> parse_rows("5000:", 7100)
    (5000, 7100)
    """
    first, colon, last = text.partition(":")
    try:
        start, stop = int(first or 0), int(last or samples)
    except ValueError:
        colon = ""
        start = stop = 0
    if not colon or not 0 <= start < stop <= samples:
        raise RecordError(
            f"rows: '{text}' is not a range of the record's {samples} samples; write FIRST:LAST, as 0:5000"
        )
    return start, stop
