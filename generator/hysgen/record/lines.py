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


_LABEL = re.compile(r"(?:columns?|names?|fields?|header|channels?|signals?|labels?|units?)(?:\s+\w+)?\s*[:=]\s*", re.I)
"""What may stand before the names in a comment."""

_WORDS = re.compile(r'(?:"[^"]*"|[^\s"]+)(?:\s*[\[(][^\])]*[\])])?')
"""A name between blanks, in quotes or with its unit in brackets behind it."""


def split_header(line: str, separator: str) -> tuple[str, ...]:
    """The names of a header, which may be a comment with a label before them.

    >>> split_header('# columns: Time (s) "Drive voltage" z', " ")
    ('Time (s)', 'Drive voltage', 'z')
    """
    bare = without_comment(line)
    label = _LABEL.match(bare)
    bare = bare[label.end() :] if label else bare
    if separator == " ":
        return tuple(name.strip('"') for name in _WORDS.findall(bare))
    return tuple(split(bare, separator))


def has_label(line: str) -> bool:
    """Whether a line says that names or units follow in it."""
    return _LABEL.match(without_comment(line)) is not None


def without_comment(line: str) -> str:
    bare = line.strip()
    mark = next((mark for mark in COMMENTS if bare.startswith(mark)), "")
    return bare[len(mark) :].strip(" ") if mark else line.strip(" \r\n")


def is_data(line: str) -> bool:
    """Neither blank, nor a comment, nor a ruler under a header."""
    stripped = line.lstrip()
    comment = stripped.startswith(COMMENTS) and not _SPREADSHEET.match(stripped)
    return bool(stripped.strip(" \t;,")) and not comment and not RULER.fullmatch(stripped)
