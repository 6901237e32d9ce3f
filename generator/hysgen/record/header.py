"""The lines above a text table: names, a row of units, lines between the header and the rows, and settings.

# NAME0 = Voltage of output chan 1           GCS array of PI
TraceName,Drive,Position                     oscilloscopes: one label, then a value for each column
VUnit,V,um
Name<tab>Drive<tab>Name<tab>Position         TwinCAT: a label before each value; each channel has its own time
Sample Interval,0.001     SampleRate,1000     delta t<tab>0,001     Acquisition rate: 1 kHz
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass

from hysgen.record.columns import UNITS, VOCABULARY, plain_unit
from hysgen.record.names import roles_in
from hysgen.record.spelling import CANDIDATES, has_label, is_data, is_value, number, split, split_header

HEADER_LINES = 12
"""Lines above the table among which the header is looked for."""

LEAST_ROLES = 2
"""Roles among the words of a comment, divided otherwise than the rows are, from which on they are names, not prose."""


@dataclass(frozen=True)
class Start:
    """The first row of numbers: its line, separator, decimal comma and number of fields."""

    at: int
    separator: str
    comma: bool
    fields: int


def header(lines: Sequence[str], above: Sequence[int], start: Start) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """The names above the first row of numbers, and their units from a row of units; () for what is not there.

    The nearest line with as many fields, unless one directly above names more roles, two of them at least. Comments
    that have another number of fields are passed over.
    """
    names: tuple[str, ...] = ()
    units: tuple[str, ...] = ()
    below, prose = None, False
    near = {*above[-HEADER_LINES:]}
    for at in reversed([at for at in above if at in near or has_label(lines[at])]):
        fields, comment = matching(lines[at], start), not is_data(lines[at])
        if not fields or all(re.fullmatch(r"[\d.,+-]*", one) for one in fields):
            if comment:
                continue  # a rule, the number of rows, a remark
            break
        # Behind a blank line the preamble begins.
        if names and (roles_in(names) or not comment) and below is not None and at < below - 1:
            break
        below = at
        if are_units(fields) and (names or at != above[0]):
            units = units or fields
        elif len(roles_in(unique(fields))) > max(1, len(roles_in(names))) or not names:
            names = unique(fields)
            prose = comment and len(split_header(lines[at], start.separator)) != start.fields
    if prose and len(roles_in(names, units_by_name(names, units) if units else {})) < LEAST_ROLES:
        return (), ()
    return names, units


def below_header(lines: Sequence[str], at: int, separator: str) -> int:
    """The last of the lines without any number that follow a header; the header if none does."""
    data = [i for i in range(at + 1, len(lines)) if is_data(lines[i])][: HEADER_LINES + 1]
    first = next((i for i in data if any(is_value(one) for one in split(lines[i], separator))), None)
    return at if first is None or first == data[0] else first - 1


def matching(line: str, start: Start) -> tuple[str, ...]:
    """The fields of a line if they are as many as those of the rows; a trailing field may be missing or empty."""
    free = start.separator == " " or not is_data(line)
    separators = [start.separator, *(one for one in CANDIDATES if one != start.separator and free)]
    for separator in separators:
        fields = split_header(line, separator)
        if len(fields) == start.fields + 1 and (not fields[-1] or fields[-1].lower() == "comment"):
            fields = fields[:-1]
        elif len(fields) == start.fields + 1 and not fields[0]:
            fields = fields[1:]  # behind a semicolon that marks a comment
        if len(fields) == start.fields - 1 and separator == start.separator:
            fields = (*fields, "")
        if len(fields) == start.fields and any(fields):
            return fields
    return ()


def are_units(fields: Sequence[str]) -> bool:
    """Whether the fields are units: all known ones, in brackets, or empty; at least one known."""
    bare = [one.strip("[]() ") for one in fields]
    known = [any(plain_unit(one) in units for units in UNITS.values()) for one in bare]
    bracketed = [one[:1] in "[(" and one[-1:] in "])" for one in fields]
    return any(known) and all(
        is_known or is_bracketed or one in ("", "-", "1")
        for is_known, is_bracketed, one in zip(known, bracketed, bare, strict=True)
    )


def units_by_name(names: Sequence[str], fields: Sequence[str]) -> dict[str, str]:
    """The units of a row of units, without brackets."""
    return {name: unit.strip("[]() ") for name, unit in zip(names, fields, strict=True) if unit}


def unique(names: Sequence[str]) -> tuple[str, ...]:
    """The names, from the second of the same spelling on with its count behind it.

    >>> unique(("Time [s]", "U", "Time [s]", ""))
    ('Time [s]', 'U', 'Time [s].1', '')
    """
    made: list[str] = []
    for at, name in enumerate(names):
        before = list(names[:at]).count(name)
        made.append(f"{name}.{before}" if name and before else name)
    return tuple(made)


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
        names = tuple(
            name or ("time" if plain_unit(unit) in UNITS["time"] else "")
            for name, unit in zip(names, units, strict=True)
        )
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
        found = _PERIOD.match(line) or _RATE.match(line)
        if found is None:
            continue
        bracket, text, behind = found.groups()
        value, unit = number(text, comma="," in text and separator != ",") or 0.0, bracket or behind
        if found.re is _PERIOD:
            multiply, divide = UNITS["time"].get(plain_unit(unit or "s"), (0.0, 1.0))
            period = value * multiply / divide
        else:
            bare = line.lower().startswith("rate") and not unit
            rate = 0.0 if bare else value * RATE_UNITS.get((unit or "Hz").lower(), 0.0)
            period = 1.0 / rate if rate else 0.0
        if period > 0.0:
            return period
    return None
