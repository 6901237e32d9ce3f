"""What the lines above a table say of its columns: names, units, sampling period.

# NAME0 = Voltage of output chan 1           GCS array of PI
TraceName,Drive,Position                     oscilloscopes: one label, then a value for each column
VUnit,V,um
Name<tab>Drive<tab>Name<tab>Position         TwinCAT: a label before each value; each channel has its own time
Sample Interval,0.001     SampleRate,1000     delta t<tab>0,001     Acquisition rate: 1 kHz
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from hysgen.record.columns import UNITS, VOCABULARY, plain_unit
from hysgen.record.spelling import number

LABELS: dict[str, list[str]] = VOCABULARY["labels"]
"""What stands before names, units, the sampling period and the rate."""
RATE_UNITS = {"hz": 1.0, "khz": 1e3, "mhz": 1e6, "s/s": 1.0, "sa/s": 1.0, "ks/s": 1e3, "ksa/s": 1e3, "ms/s": 1e6}

_NUMBER = r"[-+]?\d+(?:[.,]\d+)?(?:[eE][-+]?\d+)?"


def _setting(labels: Sequence[str]) -> re.Pattern[str]:
    """A line with one of these labels, perhaps its unit in brackets, a number and perhaps its unit."""
    words = "|".join(re.escape(one) for one in sorted(labels, key=len, reverse=True))
    return re.compile(
        rf"(?:{words})\s*(?:[\[(]([^\])]*)[\])])?\s*[:=,;\t]\s*(?:\w+:)?\s*({_NUMBER})\s*([^\s,;\d]*)", re.IGNORECASE
    )


_PERIOD, _RATE = _setting(LABELS["period"]), _setting(LABELS["rate"])


@dataclass(frozen=True)
class Preamble:
    """What the lines above a table say. names, units: one for each column, "" where unknown; () if no line has them.
    Ts_s: sampling period in s."""

    names: tuple[str, ...] = ()
    units: tuple[str, ...] = ()
    Ts_s: float | None = None


def preamble_of(lines: Sequence[str], separator: str, fields: int) -> Preamble:
    """The preamble of a table with `fields` columns. lines: those above it, without marks of comments."""
    cells = [[one.strip().strip('"') for one in line.split(separator)] for line in lines]
    names = _labelled(cells, LABELS["name"], fields) or _alternating(cells, "Name", fields) or _numbered(lines, fields)
    units = _labelled(cells, LABELS["unit"], fields)
    horizontal = next((row[1] for row in cells if len(row) > 1 and row[0].lower() in LABELS["horizontal"]), "")
    if units and horizontal and not units[0] and not names:
        units = (horizontal, *units[1:])
    if names and units:
        names = tuple(name or ("time" if _is_time(unit) else "") for name, unit in zip(names, units, strict=True))
    return Preamble(names, units, _period(lines, separator))


def labels_names(row: Sequence[str]) -> bool:
    """Whether a row holds names behind labels: it is no header, for its first cell names nothing."""
    return row[0].lower() in LABELS["name"] or (len(row) >= 4 and all(one == "Name" for one in row[::2]))


def _labelled(cells: Sequence[Sequence[str]], labels: Sequence[str], fields: int) -> tuple[str, ...]:
    """The values behind a label; the label stands in the first column, or before it."""
    for row in cells:
        if row and row[0].lower() in labels and sum(map(bool, row[1:])) >= 2:
            values = row[1:] if len(row) == fields + 1 else ["", *row[1:]]
            if len(values) == fields:
                return tuple(values)
    return ()


def _alternating(cells: Sequence[Sequence[str]], label: str, fields: int) -> tuple[str, ...]:
    """Names of channels that each have a column of times, from a row of the label before each name."""
    for row in cells:
        if len(row) == fields and fields >= 4 and all(one == label for one in row[::2]):
            unit = next((_TIME_UNIT.match(one[0]) for one in cells if one and _TIME_UNIT.match(one[0])), None)
            time = f"time [{unit.group(1)}]" if unit else "time"
            return tuple(one for name in row[1::2] for one in (time, name))
    return ()


_TIME_UNIT = re.compile(r"SampleTime\[(\w+)\]")


_NUMBER_AND_NAME = re.compile(
    r"(?:(?:name|columns?|col|channel|ch|field|signal|var)[.\s]*[\[(#]?(\d+)[\])]?\s*[:=.)-]?"
    r"|[\[(#](\d+)[\])]?\s*[:=.-]?|(\d+)\s*[:=)-])\s*(\S.*)",
    re.IGNORECASE,
)
"""One column a line: NAME0 = Drive, [0] time [s], Column 1: time, 1 = time."""


def _numbered(lines: Sequence[str], fields: int) -> tuple[str, ...]:
    """The names of a table with a line for each column, counted from 0 or 1."""
    names = {}
    for line in lines:
        if found := _NUMBER_AND_NAME.fullmatch(line):
            *numbers, name = found.groups()
            bare, _, unit = name.strip().strip('"').rpartition(",")
            known = bare and any(plain_unit(unit) in units for units in UNITS.values())
            names[int(next(filter(None, numbers)))] = f"{bare} [{unit.strip()}]" if known else name.strip().strip('"')
    counted = sorted(names)
    return tuple(names[key] for key in counted) if counted in ([*range(fields)], [*range(1, fields + 1)]) else ()


def _period(lines: Sequence[str], separator: str) -> float | None:
    """The sampling period in s of the first line that states it or the rate."""
    for line in lines:
        if found := _PERIOD.match(line):
            bracket, text, behind = found.groups()
            value = number(text, comma="," in text and separator != ",")
            unit = plain_unit(bracket or behind or "s")
            if value and value > 0.0 and unit in UNITS["time"]:
                multiply, divide = UNITS["time"][unit]
                return value * multiply / divide
        elif found := _RATE.match(line):
            bracket, text, behind = found.groups()
            value = number(text, comma="," in text and separator != ",")
            bare = line.lower().startswith("rate") and not (bracket or behind)
            factor = RATE_UNITS.get((bracket or behind or "Hz").lower())
            if value and value > 0.0 and factor is not None and not bare:
                return 1.0 / (value * factor)
    return None


def _is_time(unit: str) -> bool:
    return plain_unit(unit) in UNITS["time"]
