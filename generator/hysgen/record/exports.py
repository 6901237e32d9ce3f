"""Text in a form of one program's own, as a header and rows for the reader of tables; every line keeps its number.

IGOR / WAVES/D time, drive / BEGIN / ... / END          Igor
X,CH1,CH2,Start,Increment / Sequence,Volt,Volt,0,1e-3   Rigol: a counter, and the period in the second line
Record Length,2500,,-0.001,5.1,                         Tektronix: the settings stand beside the samples
="0.001",="5.1"                                         cells as formulas, for a spreadsheet
'0.001','5.1'                                           quotes of one stroke
"""

from __future__ import annotations

import re
from collections.abc import Callable

LOOKED_AT = 20
"""Lines by which a form is recognised."""

_FORMULA = re.compile(r'="([^"]*)"')
_ONE_STROKE = re.compile(r"\s*'[^',;\t]*'\s*(?:[,;\t]\s*'[^',;\t]*'\s*)+")


def as_table(source: str, text: str) -> tuple[str, tuple[str, ...]]:
    """The text as a table, and a remark that names the form; any other text as it is."""
    head = [line for line in text[: 4096 * LOOKED_AT].split("\n") if line.strip()][:LOOKED_AT]
    for recognised, rewritten, what in FORMS:
        if head and recognised(head):
            return rewritten(text), (f"{source}: {what}",)
    return text, ()


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


def _formulas(text: str) -> str:
    return _FORMULA.sub(r"\1", text)


def _strokes(text: str) -> str:
    return text.replace("'", "")


FORMS: tuple[tuple[Callable[[list[str]], bool], Callable[[str], str], str], ...] = (
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
        _formulas,
        'its cells are formulas (="1.5"); their values are read',
    ),
    (
        lambda head: len(head) > 2 and all(_ONE_STROKE.fullmatch(line) for line in head),
        _strokes,
        "the quotes around its cells are left out",
    ),
)  # fmt: skip
"""How a form is recognised, rewritten, and named."""
