"""Excel workbooks: the first sheet that holds a table of numbers, as text with tabs."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import date, datetime, time
from pathlib import Path
from typing import Any

from hysgen.errors import RecordError
from hysgen.record.formats.base import Format, Text, library
from hysgen.record.formats.packed import parts_of
from hysgen.record.header import is_value

FEWEST_ROWS = 3
"""Rows of at least two values that make a sheet a table; sheets of parameters have one value a row."""


def read_excel(path: Path) -> Text:
    openpyxl = library("openpyxl", path, "Excel files")
    book = openpyxl.load_workbook(path, read_only=True, data_only=True)
    filled: list[tuple[str, list[list[str]]]] = []
    try:
        for sheet in book.worksheets:
            rows = [[_cell(value) for value in row] for row in sheet.iter_rows(values_only=True)]
            if sum(any(row) for row in rows) > 1:
                filled.append((str(sheet.title), rows))
                if _is_table(rows):
                    break
    finally:
        book.close()
    if not filled:
        raise RecordError(f"{path.name}: its sheets are empty; save the record in one of them")
    name, rows = filled[-1] if _is_table(filled[-1][1]) else filled[0]
    others = ", ".join(repr(other) for other, _ in filled if other != name)
    remarks = (f"{path.name}: sheet {name!r} is read, not {others}",) if others else ()
    return Text("\n".join(["\t".join(row) for row in rows] + [""]).encode(), remarks)


def _is_table(rows: Sequence[Sequence[str]]) -> bool:
    return sum(sum(map(is_value, row)) >= 2 for row in rows) >= FEWEST_ROWS


def _cell(value: Any) -> str:
    if isinstance(value, bool) or value is None:
        return "" if value is None else str(int(value))
    if isinstance(value, (datetime, time)):
        return value.isoformat().replace("T", " ")
    if isinstance(value, date):
        return value.isoformat()
    return repr(value) if isinstance(value, (int, float)) else str(value).replace("\t", " ").replace("\n", " ")


FORMAT = Format("excel", lambda path, head: "xl/workbook.xml" in parts_of(path, head), read_excel)
