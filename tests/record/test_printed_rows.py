"""Rows as programs print them, rather than as tables: read and said in one line, or refused by their name."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from hysgen.errors import RecordError
from hysgen.record import load_record

K = np.arange(300)
TIME_S = np.round(K * 1e-3, 3)
U_V = np.round(30.0 - 25.0 * np.cos(0.03 * K), 4)
Y_UM = np.round(2.0 - 1.5 * np.cos(0.03 * (K - 5)) + 1e-3 * np.random.default_rng(1).normal(size=K.size), 4)
SAMPLES = list(zip(TIME_S, U_V, Y_UM, strict=True))
NAMES = "time,voltage,position"


def lines(form: str, between: str = "\n") -> str:
    return between.join(form.format(t=t, u=u, y=y) for t, u, y in SAMPLES)


READ: dict[str, tuple[str, str]] = {
    "a list of lists, as Python prints it": (
        f"[[{lines('{t}, {u}, {y}', chr(10).join(['],', ' [']))}]]",
        "the brackets around its rows are left out",
    ),
    "a matrix, as MATLAB writes it": (
        f"data = [\n{lines('{t} {u} {y}')}\n];",
        "the brackets around its rows are left out",
    ),
    "a matrix with semicolons": (f"log=[{lines('{t}, {u}, {y}', ';' + chr(10))}];", "the brackets around its rows"),
    "quotes around whole rows": (
        f'"{NAMES}"\n{lines(chr(34) + "{t},{u},{y}" + chr(34))}',
        "the quotes around its rows",
    ),
    "minutes and seconds of a spreadsheet": (
        f"{NAMES}\n" + lines("00:{t:06.3f},{u},{y}"),
        'read as --columns "time=time',
    ),
}


@pytest.mark.parametrize("kind", READ)
def test_printed_rows_are_read_and_what_was_done_is_said(kind: str, tmp_path: Path) -> None:
    text, said = READ[kind]
    path = tmp_path / "log.txt"
    path.write_text(text, encoding="utf-8")
    record = load_record(path)
    assert record.Ts_s == pytest.approx(1e-3, rel=1e-9)
    np.testing.assert_array_equal(record.u_V, U_V)
    np.testing.assert_array_equal(record.y_um, Y_UM)
    assert [line for line in record.warnings if said in line], record.warnings


REFUSED: dict[str, tuple[Callable[[], str], str]] = {
    "hexadecimal counts": (
        lambda: f"{NAMES}\n" + lines("{t},0x1388,{y}"),
        r"line 2: voltage is '0x1388', a hexadecimal number; write decimal numbers, in the unit of the column",
    ),
    "RTF": (
        lambda: "{\\rtf1\\ansi\n" + lines("{t},{u},{y}\\par") + "}",
        r"is RTF, not plain text; save it as plain text",
    ),
    "XML": (
        lambda: "<log>\n" + lines('<s t="{t}" u="{u}" y="{y}"/>') + "\n</log>",
        r"is XML, not a table; export it as CSV",
    ),
    "tabs written as backslash t": (
        lambda: NAMES.replace(",", "\\t") + "\n" + lines("{t}\\t{u}\\t{y}"),
        r"is what a terminal printed, with tabs written as .* \(time.tvoltage.tposition / 0\.0.t5\.0.t0",
    ),
    "colours of a terminal": (
        lambda: f"{NAMES}\n" + lines("\x1b[32m{t},{u},{y}\x1b[0m"),
        r"is what a terminal printed, with colours, and no table \(time,voltage,position / 0\.0,5\.0,",
    ),
    "a frame around a table": (
        lambda: "+---+---+---+\n| time | voltage | position |\n+---+---+---+\n" + lines("| {t} | {u} | {y} |"),
        r"is what a terminal printed, with frames, and no table \(\| time \| voltage \| position \| / \| 0\.0 \|",
    ),
    "a frame of lines": (
        lambda: "\u250c\u2500\u2510\n\u2502 time \u2502 voltage \u2502\n" + lines("\u2502 {t} \u2502 {u} \u2502"),
        r"is what a terminal printed, with frames, and no table \(\u2502 time \u2502 voltage \u2502 /",
    ),
    "a serial monitor": (
        lambda: lines("12:00:{t:06.3f} -> {u},{y}"),
        r"is what a terminal printed, with times of arrival, and no table \(12:00:00\.000 -> 5\.0,.*; write the values",
    ),
    "one value a row": (
        lambda: "time,channel,value\n" + lines("{t},voltage,{u}\n{t},position,{y}"),
        r"column channel names what each row holds \(position, voltage\); give each its own column",
    ),
}


@pytest.mark.parametrize("kind", REFUSED)
def test_text_that_is_no_table_is_refused_by_its_name(kind: str, tmp_path: Path) -> None:
    text, said = REFUSED[kind]
    path = tmp_path / "log.txt"
    path.write_text(text(), encoding="utf-8")
    with pytest.raises(RecordError, match=rf"^log.txt: {said}"):
        load_record(path)
