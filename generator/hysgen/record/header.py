"""The header of a text table: names, a row of units, lines between the header and the first row of numbers."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from hysgen.record.columns import UNITS, plain_unit
from hysgen.record.lines import CANDIDATES, has_label, is_data, split, split_header
from hysgen.record.names import roles_in
from hysgen.record.spelling import is_clock, quantity

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
        elif roles_in(unique(fields)) > max(1, roles_in(names)) or not names:
            names = unique(fields)
            prose = comment and len(split_header(lines[at], start.separator)) != start.fields
    if prose and roles_in(names, units_by_name(names, units) if units else {}) < LEAST_ROLES:
        return (), ()
    return names, units


def below_header(source: str, lines: Sequence[str], at: int, separator: str) -> tuple[int, tuple[str, ...]]:
    """The last of the lines without any number that follow a header, and a remark; the header if none does."""
    data = [i for i in range(at + 1, len(lines)) if is_data(lines[i])][: HEADER_LINES + 1]
    first = next((i for i in data if any(is_value(one) for one in split(lines[i], separator))), None)
    if first is None or not data or first == data[0]:
        return at, ()
    return first - 1, (f"{source}: the table begins in line {first + 1}",)


def is_value(text: str) -> bool:
    return quantity(text, False) is not None or quantity(text, True) is not None or is_clock(text)


def matching(line: str, start: Start) -> tuple[str, ...]:
    """The fields of a line if they are as many as those of the rows; a trailing field may be missing or empty."""
    free = start.separator == " " or not is_data(line)
    separators = [start.separator, *(one for one in CANDIDATES if one != start.separator and free)]
    for separator in separators:
        fields = split_header(line, separator)
        if len(fields) == start.fields + 1 and (not fields[-1] or fields[-1].lower() == "comment"):
            fields = fields[:-1]
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
