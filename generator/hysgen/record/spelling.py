"""The spelling of a text table: the fields of a line, and a number or a time of day in a cell."""

import csv
import re
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from hysgen.record.columns import UNITS, plain_unit

MINUS = str.maketrans(dict.fromkeys("\N{MINUS SIGN}\N{EN DASH}\N{FULLWIDTH HYPHEN-MINUS}", "-"))
"""Signs that spreadsheets and typesetters put for a minus."""

FORTRAN = re.compile(r"(?<=[\d.])(?:[dD]|\*\^)(?=[+-]?\d)")
"""The D of a Fortran exponent, 1.0D+00, and the *^ of Mathematica's, 1.0*^0."""

_BLANKS = "\N{NO-BREAK SPACE}\N{NARROW NO-BREAK SPACE}\N{THIN SPACE} "
_APART = "'\N{RIGHT SINGLE QUOTATION MARK}" + _BLANKS
THOUSANDS = {
    False: re.compile(rf"[+-]?[1-9]\d{{0,2}}(?:(?:,\d{{3}})+|(?:[{_APART}]\d{{3}})+)(?:\.\d*)?"),
    True: re.compile(rf"[+-]?[1-9]\d{{0,2}}(?:(?:\.\d{{3}})+,\d*|(?:[{_APART}]\d{{3}})+(?:,\d*)?)"),
}
"""Numbers with separators between thousands, by whether the decimal sign is a comma: 1,985.5, 1'985.5, 1 985,5."""

_VALUE_AND_UNIT = re.compile(r"(.*[\d.,])\s*([^\d\s.,+-][^\d\s]*)")
CLOCK = re.compile(
    r"(?:\d{4}-\d\d-\d\d|\d\d?\.\d\d?\.\d{4}|\d\d?/\d\d?/\d{4})?[T ]?"
    r"\d\d?:\d\d:\d\d(?:[.,:]\d+)?(?:Z|[+-]\d\d:?\d\d|\s?[AaPp]\.?[Mm]\.?)?"
    r"|\d\d?:\d\d[.,]\d+"
)
"""A date and time of day, a time of day alone, or minutes and seconds with a fraction."""


def number(text: str, comma: bool) -> float | None:
    """The number in `text`, or None. An underscore, which Python's float accepts, is not allowed.

    >>> [number(text, False) for text in ("1.0D+00", "1'985.5", "\N{MINUS SIGN}2", "1,985.5", "1_0")]
    [1.0, 1985.5, -2.0, 1985.5, None]
    """
    if "_" in text:
        return None
    try:
        return float(text.replace(",", ".") if comma else text)
    except ValueError:
        plain = FORTRAN.sub("E", text.translate(MINUS))
        if THOUSANDS[comma].fullmatch(plain):
            plain = re.sub(rf"[{_APART}{'.' if comma else ','}]", "", plain)
        elif plain == text:
            return None
        try:
            return float(plain.replace(",", ".") if comma else plain)
        except ValueError:
            return None


def quantity(text: str, comma: bool) -> tuple[float, str] | None:
    """The number in `text` and its unit, "" if it has none; None if the text is something else.

    >>> [quantity(text, False) for text in ("1.5 V", "20nm", "3", "5 bananas")]
    [(1.5, 'V'), (20.0, 'nm'), (3.0, ''), None]
    """
    value = number(text, comma)
    if value is not None:
        return value, ""
    match = _VALUE_AND_UNIT.fullmatch(text)
    if match is None or not any(plain_unit(match.group(2)) in units for units in UNITS.values()):
        return None
    value = number(match.group(1), comma)
    return None if value is None else (value, plain_unit(match.group(2)))


def in_unit(value: float, unit: str, wanted: str) -> float | None:
    """The value in the unit `wanted`; None if the two units are not of one quantity."""
    if unit == wanted:
        return value
    units = next((units for units in UNITS.values() if unit in units and wanted in units), None)
    if units is None:
        return None
    (multiply, divide), (wanted_multiply, wanted_divide) = units[unit], units[wanted]
    return value * (multiply * wanted_divide) / (divide * wanted_multiply)


class UnreadableError(ValueError):
    """A cell that is no number: its row, from 0, and the cure where it is not the usual one. str: what it is."""

    def __init__(self, row: int, what: str, cure: str = "") -> None:
        super().__init__(what)
        self.row, self.cure = row, cure


def values_of(texts: Sequence[str], comma: bool) -> NDArray[np.float64]:
    """The numbers in the cells of a column, (n,): in the unit of the first cell; of times of day, s since the first.

    Raises UnreadableError at the first cell that is none.
    """
    if texts and is_clock(texts[0]):
        for row, text in enumerate(texts):
            if not is_clock(text):
                raise UnreadableError(row, f"'{text}', no time of day as in the first row")
        return clock_seconds(texts)
    unit = ((quantity(texts[0], comma) if texts else None) or (0.0, ""))[1]
    values = np.empty(len(texts))
    for row, text in enumerate(texts):
        value = None if unit else number(text, comma)
        if value is None:
            value = _in_unit_of_first(row, text, comma, unit)
        values[row] = value
    return values


def _in_unit_of_first(row: int, text: str, comma: bool, unit: str) -> float:
    known = quantity(text, comma)
    value = None if known is None else in_unit(*known, unit)
    if value is not None:
        return value
    if known is not None:
        raise UnreadableError(
            row, f"'{text}', the first row is {f'in {unit}' if unit else 'without a unit'}", "correct it"
        )
    if text[:2].lower() == "0x":
        cure = "write decimal numbers, in the unit of the column"
        raise UnreadableError(row, f"'{text}', a hexadecimal number", cure)
    other = _VALUE_AND_UNIT.fullmatch(text)
    if other and number(other.group(1).rstrip(), comma) is not None and re.fullmatch(r"[^\W\d_]+|%", other.group(2)):
        raise UnreadableError(row, f"'{text}', a number in {other.group(2)}, which is no unit of a column")
    raise UnreadableError(row, f"'{text}', not a number" if text else "empty")


def is_value(text: str, *commas: bool) -> bool:
    """Whether `text` is a time of day, or a number, with or without a unit, by one of these decimal signs."""
    return any(quantity(text, comma) is not None for comma in commas or (False, True)) or is_clock(text)


def is_clock(text: str) -> bool:
    """Whether `text` is a time of day, with or without a date."""
    return CLOCK.fullmatch(text) is not None


def clock_seconds(texts: Sequence[str]) -> NDArray[np.float64]:
    """Seconds since the first of these times of day, (n,).

    Of a date with slashes or dots, the first number is the day, unless a second number above 12 shows otherwise.
    """
    split = [_date_and_time(text) for text in texts]
    parts = [re.fullmatch(r"(\d\d?)[./](\d\d?)[./](\d{4})", date) for date, _ in split]
    month = 1 if any(part and int(part.group(2)) > 12 for part in parts) else 2
    stamps = []
    for (date, time), part in zip(split, parts, strict=True):
        if part:
            date = f"{part.group(3)}-{int(part.group(month)):02d}-{int(part.group(3 - month)):02d}"
        stamps.append(f"{date or '2000-01-01'}T{time}")
    array = np.array(stamps, dtype="datetime64[ns]")
    return np.asarray((array - array[0]).astype(np.int64) * 1e-9)


def _date_and_time(text: str) -> tuple[str, str]:
    """The date, "" if there is none, and the time as hh:mm:ss.s of 24 hours."""
    text = re.sub(r"(?<=\d)(?:Z|[+-]\d\d:?\d\d)$", "", text).replace(",", ".")
    half = re.search(r"\s?([ap])\.?m\.?$", text, re.IGNORECASE)
    text = (text[: half.start()] if half else text).replace(" ", "T")
    date, _, time = text.rpartition("T")
    if time.count(":") == 1:
        time = f"0:{time}"
    if time.count(":") == 3:
        whole, _, fraction = time.rpartition(":")
        time = f"{whole}.{fraction}"
    hours, _, rest = time.partition(":")
    count = int(hours)
    if half:
        count = count % 12 + (12 if half.group(1).lower() == "p" else 0)
    return date, f"{count:02d}:{rest}"


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
