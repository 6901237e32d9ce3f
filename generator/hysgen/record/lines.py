"""One line of a text table: its fields, and whether it is data, a comment or a ruler."""

from __future__ import annotations

import csv
import re

COMMENT = "#"
COMMENTS = ("#", "%", "//", "!")
CANDIDATES = ("\t", ";", ",", "|", " ")
"""Separators, the surest first."""

RULER = re.compile(r"[\s|+:=,;-]*[-=]{3}[\s|+:=,;-]*|\|(?:\s*:?-+:?\s*\|)+\s*")
"""A line drawn under a header."""


_SPREADSHEET = re.compile(r"#(?:DIV/0!|N/A|REF!|VALUE!|NUM!|NULL!|NAME\?|#+)(?=\s*(?:[,;\t|]|$)| +[-+\d.])")
"""What a spreadsheet puts for a value that it cannot compute or show; it is a cell, and no comment."""


def split(line: str, separator: str) -> list[str]:
    """The fields of one line, without quotes and without a comment at its end.

    A comment needs a blank before it; behind a separator, '#' belongs to the cell.

    >>> split("0.1,5.8,0.8  # knock", ","), split("0.1,5.8, #DIV/0!", ","), split("0.1,5.8,1.#INF", ",")
    (['0.1', '5.8', '0.8'], ['0.1', '5.8', '#DIV/0!'], ['0.1', '5.8', '1.#INF'])
    """
    if "#" in line:
        for mark in re.finditer(r"(?:^|(?<=\s))#", line):
            before = line[: mark.start()].rstrip(" ")
            behind_separator = separator != " " and before.endswith(separator)
            if not behind_separator and not _SPREADSHEET.match(line, mark.start()):
                line = before
                break
    line = line.strip(" \r\n")
    if separator == " ":
        return line.split()
    fields = next(csv.reader([line], delimiter=separator)) if '"' in line else line.split(separator)
    return [one.strip() for one in fields]


def split_header(line: str, separator: str) -> tuple[str, ...]:
    """The names of a header, which may be a comment."""
    return tuple(split(without_comment(line), separator))


def without_comment(line: str) -> str:
    bare = line.strip()
    mark = next((mark for mark in COMMENTS if bare.startswith(mark)), "")
    return bare[len(mark) :].strip(" ") if mark else line.strip(" \r\n")


def is_data(line: str) -> bool:
    """Neither blank, nor a comment, nor a ruler under a header."""
    stripped = line.lstrip()
    comment = stripped.startswith(COMMENTS) and not _SPREADSHEET.match(stripped)
    return bool(stripped.strip(" \t;,")) and not comment and not RULER.fullmatch(stripped)
