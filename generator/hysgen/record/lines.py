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


def split(line: str, separator: str) -> list[str]:
    """The fields of one line, without quotes and without a comment at its end."""
    hash_at = re.search(r"(?:^|\s)#", line)
    line = (line[: hash_at.start()] if hash_at else line).strip(" \r\n")
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
    return bool(stripped.strip(" \t;,")) and not stripped.startswith(COMMENTS) and not RULER.fullmatch(stripped)
