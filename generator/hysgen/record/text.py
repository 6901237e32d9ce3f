"""The text of a file as that of a table: its encoding, line ends, zero bytes, and the forms of single programs.

LabVIEW Measurement / ***End_of_Header***             LabVIEW (LVM): parts, each with a header of its own
IGOR / WAVES/D time, drive / BEGIN / ... / END          Igor
X,CH1,CH2,Start,Increment / Sequence,Volt,Volt,0,1e-3   Rigol: a counter, and the period in the second line
Record Length,2500,,-0.001,5.1,                         Tektronix: the settings stand beside the samples
="0.001",="5.1"     '0.001','5.1'                       cells as formulas, and quotes of one stroke
t=0.001, U=5.8 V, y=0.81                                named values, also with ":" and as JSON objects, one a line
[0.001, 5.8, 0.81]                                      lists, as Python and MATLAB write them; data = [ ... ]
"0.001,5.8,0.81"                                        quotes around whole rows

Each becomes a header and rows, which the reader of tables takes; every line keeps its number. What only a terminal
prints is refused.
"""

import contextlib
import io
import itertools
import re
from collections.abc import Callable

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


LOOKED_AT = 20
"""Lines by which a form is recognised."""

_FORMULA = re.compile(r'="([^"]*)"')
_ONE_STROKE = re.compile(r"\s*'[^',;\t]*'\s*(?:[,;\t]\s*'[^',;\t]*'\s*)+")


def as_table(source: str, text: str) -> tuple[str, tuple[str, ...]]:
    """The text as a table, and a remark for each thing that was done; any other text as it is."""
    remarks: tuple[str, ...] = ()
    head = _head(text)
    for recognised, rewritten, what in FORMS:
        if head and recognised(head):
            bare = text.lstrip()
            text = "\n" * text.count("\n", 0, len(text) - len(bare)) + rewritten(bare)
            remarks = (f"{source}: {what}",)
            break
    head = [line.strip() for line in _head(text)]
    if len(head) < FEWEST:
        return text, remarks
    _check_no_terminal(source, head)
    table, what = _unwrapped(text, head)
    return ("\n".join(table), (*remarks, f"{source}: {what}")) if what else (text, remarks)


def _igor(text: str) -> str:
    """The first block of waves; what stands outside it becomes blank lines."""
    made, inside = [], False
    for line in text.split("\n"):
        bare = line.strip()
        if bare.upper().startswith("WAVES") and not inside:
            made.append("\t".join(re.split(r"[,\s]+", re.sub(r"^WAVES\S*\s*", "", bare, flags=re.IGNORECASE))))
        elif bare.upper() == "BEGIN":
            inside = True
            made.append("")
        elif bare.upper() == "END":
            break
        else:
            made.append("\t".join(bare.split()) if inside else "")
    return "\n".join(made)


def _labview(text: str) -> str:
    """The names and rows of each part, with units and period in the lines above; headers become blank lines."""
    comma = "\nSeparator\tComma" in text[:4096] or "\nSeparator,Comma" in text[:4096]
    empty = ("X_Value",) if re.search(r"\nX_Columns[\t,]No", text[:4096]) else ()
    made, head, inside, count = [], dict[str, list[str]](), False, 0
    for line in text.split("\n"):
        cells = [cell.strip() for cell in line.split("," if comma else "\t")]
        if not inside or not any(cells) or cells[0] == "Channels":
            inside = line.startswith("***End_of_Header***") and "Channels" in head
            head = {} if cells[0] == "Channels" else head
            head[cells[0]] = cells[1:]
            made.append("")
        elif "Channels" in head:
            step, unit = (next(iter(filter(None, head.get(label, []))), "") for label in ("Delta_X", "X_Dimension"))
            known, units = unit in ("", "Time") and step, iter(head.get("Y_Unit_Label", []))
            count = len(cells) - (cells[-1] == "Comment")
            above = "\t".join("" if name == "X_Value" else f"[{next(units, '')}]" for name in cells[:count])
            made[-2:] = [f"# Sample Interval: {step}" if known else "", above if re.search(r"\w", above) else ""]
            made.append("\t".join("" if name in empty else name for name in cells[:count]))
            head = {}
        else:
            made.append("\t".join(cells[:count]))
    return "\n".join(made)


def _rigol(text: str) -> str:
    """The period as a setting above the names, and the unit behind each name."""
    first, second, rest = text.split("\n", 2)
    names, below = ([one.strip() for one in line.split(",")] for line in (first, second))
    count = names.index("Start")
    at = names.index("Increment")
    header = ",".join(
        [names[0], *(f"{name} [{unit}]" for name, unit in zip(names[1:count], below[1:count], strict=True))]
    )
    rows = (",".join(row.split(",")[:count]) for row in rest.split("\n"))
    return "\n".join([f"# Sample Interval: {below[at]}", header, *rows])


def _tektronix(text: str) -> str:
    """Time and value of each channel, without the settings; name and unit of a channel are settings."""
    cells = [line.split(",") for line in text.split("\n")]
    starts = [at for at, one in enumerate(cells[0]) if one == "Record Length"]

    def setting(start: int, label: str) -> str:
        return next((row[start + 1] for row in cells[:LOOKED_AT] if row[start : start + 1] == [label]), "")

    names = [
        f"Time [{setting(at, 'Horizontal Units')}],{setting(at, 'Source')} [{setting(at, 'Vertical Units')}]"
        for at in starts
    ]
    rows = [",".join(cell.strip() for at in starts for cell in row[at + 3 : at + 5]) for row in cells]
    return "\n".join([f"{','.join(names)}\n{rows[0]}", *rows[1:]])


FORMS: tuple[tuple[Callable[[list[str]], bool], Callable[[str], str], str], ...] = (
    (
        lambda head: head[0].startswith("LabVIEW Measurement"),
        _labview,
        "is a measurement file of LabVIEW",
    ),
    (lambda head: head[0].strip() == "IGOR", _igor, "is Igor text; its first block of waves is read"),
    (
        lambda head: len(head) > 1 and {"Start", "Increment"} <= {one.strip() for one in head[0].split(",")}
        and head[1].startswith("Sequence,"),
        _rigol,
        "is a file of a Rigol oscilloscope; the samples are counted, and Increment is their period",
    ),
    (
        lambda head: head[0].startswith("Record Length,") and head[0].count(",") >= 4 and "Analog" not in head[0],
        _tektronix,
        "is a file of a Tektronix oscilloscope; the settings beside its samples are left out; messages count the "
        "names as line 1",
    ),
    (
        lambda head: all(_FORMULA.search(line) for line in head),
        lambda text: _FORMULA.sub(r"\1", text),
        'its cells are formulas (="1.5"); their values are read',
    ),
    (
        lambda head: len(head) > 2 and all(_ONE_STROKE.fullmatch(line) for line in head),
        lambda text: text.replace("'", ""),
        "the quotes around its cells are left out",
    ),
)  # fmt: skip
"""How a form is recognised, rewritten, and named."""

FEWEST = 3
"""Rows below which a file is no record."""

_NAMED = re.compile(
    r"""["']?([^\W\d][^=:,;"']*?)["']?\s*[=:]\s*["']?([^,;="'\s]+(?:\s(?!\w+\s*[=:])[^\W\d]\w*)?)["']?"""
)
_BETWEEN = re.compile(r"[,;\s]*")
_BRACKETS = {"[": "]", "(": ")", "{": "}"}
_MATRIX = re.compile(r"(?:[^\W\d]\w*\s*=\s*)?[\[({]")
"""What stands before the first row of a matrix: data = [."""

_NUMBERS = re.compile(r"[-+\d.,;eE\s]*")
_QUOTED = re.compile(r'"[^"]*[,;\t][^"]*"')
_TERMINAL = {
    "colours": re.compile(r"\x1b\[[0-9;]*[A-Za-z]"),
    "frames": re.compile(r"[\u2500-\u257f]|\s*\+(?:[-=]+\+){2,}\s*"),
    "times of arrival": re.compile(r"\d\d?:\d\d:\d\d[.,]\d+\s*->"),
    "tabs written as a backslash and a t": re.compile(r"[^\t]*\\t[^\t]*\\t"),
}
"""What a terminal, a table printer or a serial monitor puts into a line, and no logger."""


def _unwrapped(text: str, head: list[str]) -> tuple[list[str], str]:
    """The lines of a table whose rows are wrapped, and what was done; "" for any other text."""
    named = [_named_values(line) or [] for line in head]
    names = [name for name, _ in named[0]]
    wrapped = all(_bare(line) != line for line in head)
    if not (wrapped or len(names) > 1 or _MATRIX.match(head[0]) or _QUOTED.fullmatch(head[0])):
        return [], ""
    lines = [line.strip() for line in text.split("\n")]
    if all(_QUOTED.fullmatch(line) for line in head):
        return [line.strip('"') for line in lines], "the quotes around its rows are left out"
    if len(names) > 1 and all([name for name, _ in one] == names for one in named):
        what = f"its rows name their values ({', '.join(names)}); messages count these names as line 1"
        return _table_of_named(lines, names), what
    bare = _matrix(lines)
    if bare is None and wrapped:
        bare = [_bare(line) for line in lines]
    return ([], "") if bare is None else (bare, "the brackets around its rows are left out")


def _head(text: str) -> list[str]:
    return [*itertools.islice((line.rstrip("\n") for line in io.StringIO(text) if line.strip()), LOOKED_AT)]


def _check_no_terminal(source: str, head: list[str]) -> None:
    """Raise RecordError for lines that only a terminal prints, with the first of them."""
    for what, mark in _TERMINAL.items():
        if sum(mark.match(line) is not None for line in head) >= 2:
            bare = (_TERMINAL["colours"].sub("", line) for line in head)
            shown = " / ".join([line[:40] for line in bare if any(map(str.isalnum, line))][:FEWEST])
            raise RecordError(
                f"{source}: is what a terminal printed, with {what}, and no table ({shown}); write the values "
                "themselves, one row for each sample, with commas between them"
            )


def _matrix(lines: list[str]) -> list[str] | None:
    """The rows of one matrix over all lines, each in its line; None if the text is something else."""
    used = [at for at, line in enumerate(lines) if line]
    start = _MATRIX.match(lines[used[0]])
    if start is None or lines[used[-1]].rstrip(",; ")[-1:] not in _BRACKETS.values():
        return None
    made = [lines[used[0]][start.end() :], *lines[used[0] + 1 :]]
    made = [line.strip("[](){},; ") for line in made]
    head = [line for line in made if line][:LOOKED_AT]
    return [""] * used[0] + made if head and all(_NUMBERS.fullmatch(line) for line in head) else None


def _table_of_named(lines: list[str], names: list[str]) -> list[str]:
    """A header and the values; a line with other names stays as it is, for the reader of tables to report."""
    rows = [",".join(f'"{name}"' for name in names)]
    for line in lines:
        values = _named_values(line) or []
        rows.append(",".join(f'"{value}"' for _, value in values) if [name for name, _ in values] == names else line)
    return rows


def _named_values(line: str) -> list[tuple[str, str]] | None:
    """Names and values of a line; None if it contains anything else."""
    rest, found = _bare(line), []
    while rest:
        match = _NAMED.match(rest)
        if match is None:
            return None
        found.append((match.group(1).strip(), match.group(2)))
        after = rest[match.end() :]
        rest = after[_BETWEEN.match(after).end() :]  # type: ignore[union-attr]
        if rest and len(rest) == len(after):
            return None
    return found or None


def _bare(line: str) -> str:
    """The line without brackets around it, and without the comma or semicolon behind them."""
    inner = line.rstrip(",; ")
    return inner[1:-1].strip() if len(inner) > 2 and _BRACKETS.get(inner[0]) == inner[-1] else line
