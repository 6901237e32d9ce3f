"""The text of a file: its encoding, line ends, zero bytes, names broken over lines."""

from __future__ import annotations

import contextlib
import re

from hysgen.errors import RecordError
from hysgen.record.layout import HEAD_LINES

UTF16_MARKS = (b"\xff\xfe", b"\xfe\xff")
HEAD = 65_536
"""Bytes by which binary data are told from text."""

LONGEST_NAME = 80
"""Characters; what stands between two quotes and is longer is no name broken over lines."""


def text_of(source: str, data: bytes) -> tuple[str, tuple[str, ...]]:
    """The text of a file with "\\n" at the line ends, and remarks. Raises RecordError for binary data."""
    if not data.strip():
        raise RecordError(f"{source}: is empty; record some samples")
    remarks: tuple[str, ...] = ()
    head = data[:4096]
    if data[:2] in UTF16_MARKS:
        text = data.decode("utf-16", errors="replace")
    elif len(head) > 20 and head[1::2].count(0) > 0.9 * len(head[1::2]) and 0 not in head[::2]:
        text = data.decode("utf-16-le", errors="replace")
    elif len(head) > 20 and head[::2].count(0) > 0.9 * len(head[::2]) and 0 not in head[1::2]:
        text = data.decode("utf-16-be", errors="replace")
    else:
        # A logger reserves room ahead in the file, as zeros; CP/M's sign for the end of a text lives on, too.
        filled = data.rstrip(b"\0\x1a")
        zeros = data[len(filled) :].count(0)
        if b"\0" in filled or not filled:
            raise RecordError(_with_zeros(source, data))
        if zeros:
            remarks = (f"{source}: {zeros} zero bytes at the end are left out",)
        try:
            text = filled.decode("utf-8-sig")
        except UnicodeDecodeError:
            text = filled.decode(_encoding(filled))
    text = text.replace("\ufeff", "") if "\ufeff" in text else text
    text = text.replace("\r\n", "\n").replace("\r", "\n") if "\r" in text else text
    return _names_in_one_line(text), remarks


def _with_zeros(source: str, data: bytes) -> str:
    """What to say of zero bytes: in a text they are a gap, in anything else the sign of a binary format."""
    if any(byte < 32 and byte not in b"\0\t\n\r\x1a" for byte in data[:HEAD]) or not data.strip(b"\0"):
        return f"{source}: is binary, not text; export it as CSV, or give it the suffix of its format"
    line = data.count(b"\n", 0, data.index(0)) + 1
    return (
        f"{source}: line {line}: holds zero bytes, as a logger leaves that lost its power; rows may be missing there: "
        f"delete them (tr -d '\\0' < {source} > new.csv) and read new.csv with --split-at-gaps"
    )


def _names_in_one_line(text: str) -> str:
    """The text with quoted names that are broken over lines in one line each; the number of lines stays."""
    head = "".join(text[: HEAD_LINES * LONGEST_NAME].splitlines(keepends=True)[:HEAD_LINES])
    broken = [one for one in re.findall(r'"[^"]*"', head) if "\n" in one]
    # A quote too many turns everything after it inside out: then nothing is joined.
    if not broken or head.count('"') % 2 or any(len(one) > LONGEST_NAME for one in broken):
        return text
    lines, joined = head.split("\n"), []
    while lines:
        line, more = lines.pop(0), 0
        while line.count('"') % 2:
            line, more = f"{line} {lines.pop(0)}", more + 1
        joined += [line, *[""] * more]
    return "\n".join(joined) + text[len(head) :]


WORDS_BY_ENCODING = {"cp932": ("時間", "電圧", "変位"), "cp1251": ("время", "напряжение", "перемещение", "положение")}
"""Encodings of Windows in which a header is told by a word; a wrong one gives other letters, and no fault."""


def _encoding(data: bytes) -> str:
    """The encoding in which the header has a word of a role; else GB 18030 (Chinese Windows) if all bytes above 0x7f
    come in pairs, else Latin-1, in which every byte is valid.

    In European headers the bytes of a micro sign or an accent stand alone.
    """
    for encoding, words in WORDS_BY_ENCODING.items():
        if any(word in data[:4096].decode(encoding, errors="ignore").lower() for word in words):
            with contextlib.suppress(UnicodeDecodeError):
                data.decode(encoding)
                return encoding
    runs = re.findall(rb"[\x80-\xff]+", data)
    if all(len(run) % 2 == 0 and min(run) > 0xA0 for run in runs):
        with contextlib.suppress(UnicodeDecodeError):
            data.decode("gb18030")
            return "gb18030"
    return "latin-1"
