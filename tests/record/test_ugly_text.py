"""Text as loggers and spreadsheets leave it: read and said in one line, or refused with the row and a remedy."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from hysgen.errors import RecordError
from hysgen.record import load_record

N = 300
K = np.arange(N)
TIME_S = np.round(K * 1e-3, 3)
U_V = np.round(30.0 - 25.0 * np.cos(0.03 * K), 4)
Y_UM = np.round(2.0 - 1.5 * np.cos(0.03 * (K - 5)) + 1e-3 * np.random.default_rng(1).normal(size=N), 4)
CELL = f"{U_V[52]:.4f} V"
"""In line 54."""

HEADER = "time_s,voltage_V,displacement_um"
ROWS = [f"{t:.3f},{u:.4f},{y:.4f}" for t, u, y in zip(TIME_S, U_V, Y_UM, strict=True)]
HALF_DAYS = [
    f"11/23/2026 {'11:59:59' if k < 150 else '12:00:00'}.{(850 + k) % 1000:03d} {'AM' if k < 150 else 'PM'}" for k in K
]
BACKWARDS = [",".join(row.split(",")[::-1]) for row in ROWS]
NUMBERED = [f"{k},{row}" for k, row in zip(K, ROWS, strict=True)]
ANEW = [f"{t:.3f},{u:.4f},{y:.4f}" for t, u, y in zip(TIME_S, U_V[150:], Y_UM[150:], strict=False)]


def made(header: str, row: str, time: float = 1.0, voltage: float = 1.0, stroke: float = 1.0) -> str:
    """A table whose rows are `row` formatted with t, u, y, multiplied by these factors."""
    cells = zip(time * TIME_S, voltage * U_V, stroke * Y_UM, strict=True)
    return "\n".join([header, *(row.format(t=t, u=u, y=y) for t, u, y in cells), ""])


def fortran(text: str) -> str:
    return text.replace("E+", "D+").replace("E-", "D-")


def apart(text: str, mark: str) -> str:
    return text.replace(",", mark)


READ: dict[str, tuple[str | bytes, str]] = {
    "Fortran exponents": (fortran(made("TIME  VOLT  POS", " {t:.8E}  {u:.8E}  {y:.8E}")), "time=TIME,voltage=VOLT"),
    "Swiss thousands": (
        apart(made("Zeit [s];Spannung [mV];Weg [nm]", "{t:.3f};{u:,.1f};{y:,.1f}", voltage=1e3, stroke=1e3), "'"),
        "voltage=Spannung [mV]",
    ),
    "thousands by an apostrophe of print": (
        apart(made("Zeit [s];U [mV];Weg [nm]", "{t:.3f};{u:,.1f};{y:,.1f}", voltage=1e3, stroke=1e3), "\u2019"),
        "voltage=U [mV]",
    ),
    "French thousands and decimal commas": (
        apart(
            made("Temps (s);Tension (mV);Position (nm)", "{t:.3f};{u:,.1f};{y:,.1f}", voltage=1e3, stroke=1e3), "\u202f"
        ).replace(".", ","),
        "voltage=Tension (mV)",
    ),
    "units in the cells": (
        made("time,voltage,displacement", "{t:.1f} ms,{u:.4f} V,{y:.1f}nm", time=1e3, stroke=1e3),
        "displacement is read in nm, as its cells say",
    ),
    "several units in one column": (
        made("time,voltage,displacement", "{t:.3f} s,{u:.4f} V,{y:.4f} um").replace(CELL, f"{1e3 * U_V[52]:.1f} mV"),
        "voltage is read in V, as its cells say",
    ),
    "header again, time goes on": (
        "\n".join([HEADER, *ROWS[:150], HEADER, *ROWS[150:]]),
        "the header is repeated in line 152",
    ),
    "footer of statistics": (
        "\n".join([HEADER, *ROWS, "", ",Voltage,Position", "Max,55.0,3.5", "Std. Dev.,17.6,1.0", ""]),
        "line 303 and what follows is no row of numbers and is left out (',Voltage,Position')",
    ),
    "footer of words": ("\n".join([HEADER, *ROWS, "End of measurement"]), "line 302 and what follows"),
    "zero bytes at the end": ("\n".join([HEADER, *ROWS, ""]).encode() + bytes(4096), "4096 zero bytes at the end"),
    "the end of a text in CP/M": ("\n".join([HEADER, *ROWS, "\x1a"]), ""),
    "half days": (
        "\n".join(
            [
                "Timestamp,Voltage (V),Position (um)",
                *(f"{stamp},{u},{y}" for stamp, u, y in zip(HALF_DAYS, U_V, Y_UM, strict=True)),
            ]
        ),
        "time=Timestamp",
    ),
    "quoted decimal commas between commas": (
        made('"Zeit","Spannung","Weg"\n"[s]","[V]","[um]"', '"{t:.3f}","{u:.4f}","{y:.4f}"').replace(".", ","),
        "time=Zeit,voltage=Spannung",
    ),
    "ruler under the header": (
        made("| time_s | voltage_V | displacement_um |\n|---|---|---|", "| {t:.3f} | {u:.4f} | {y:.4f} |"),
        "",
    ),
    "names broken over lines": (
        "\n".join(
            ['"displacement\n(um)","voltage\n(V)","time\n(s)"', *(",".join(row.split(",")[::-1]) for row in ROWS)]
        ),
        "time=time (s),voltage=voltage (V),displacement=displacement (um)",
    ),
    "named values": (made("", "t={t:.3f}, U={u:.4f} V, y={y:.4f} um").lstrip(), "its rows name their values (t, U, y)"),
    "named values between blanks": (
        made("", "time: {t:.3f} voltage: {u:.4f} displacement: {y:.4f}").lstrip(),
        "its rows name their values (time, voltage, displacement)",
    ),
    "a JSON object in each line": (
        made("", '{{"time_s": {t}, "voltage_V": {u}, "displacement_um": {y}}}').lstrip(),
        "its rows name their values (time_s, voltage_V, displacement_um)",
    ),
    "lists": (made("", "[{t:.3f}, {u:.4f}, {y:.4f}],").lstrip(), "the brackets around its rows are left out"),
    "tuples without commas": (made("", "({t:.3f} {u:.4f} {y:.4f})").lstrip(), "the brackets around its rows"),
    "row numbers and units in brackets": (
        "\n".join(
            ["Index,Time,Drive,Sensor", "#,[s],[V],[um]", *(f"{k},{row}" for k, row in zip(K, ROWS, strict=True))]
        ),
        "time=Time,voltage=Drive,displacement=Sensor",
    ),
}


@pytest.mark.parametrize("kind", READ)
def test_ugly_text_gives_the_record_and_says_how(kind: str, tmp_path: Path) -> None:
    text, said = READ[kind]
    path = tmp_path / "log.csv"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    record = load_record(path)
    (segment,) = record.segments
    assert record.Ts_s == pytest.approx(1e-3, rel=1e-9)
    np.testing.assert_allclose(segment.u_V, U_V, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(segment.y_um, Y_UM, rtol=1e-9, atol=1e-12)
    assert any(said in line for line in record.warnings) or (said == "" and record.warnings == ()), record.warnings


def test_a_minus_of_print_is_a_minus(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_text(
        "\n".join([HEADER, *(f"{t:.3f},{u - 30:.4f},{y}" for t, u, y in zip(TIME_S, U_V, Y_UM, strict=True))])
    )
    expected = load_record(path)
    path.write_text(path.read_text().replace("-", "\N{MINUS SIGN}"))
    assert load_record(path).digest == expected.digest


def test_logs_put_together_are_segments(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_text("\n".join([HEADER, *ROWS[:150], "Max,55,3.5", "stage 3, run 2", HEADER, *ANEW]))
    first, second = load_record(path).segments
    np.testing.assert_array_equal(first.u_V, U_V[:150])
    np.testing.assert_array_equal(second.u_V, U_V[150:])


REFUSED: dict[str, tuple[str | bytes, tuple[str, ...]]] = {
    "overload": (
        "\n".join([HEADER, *ROWS[:150], "0.150,OVLD,OVLD", *ROWS[151:]]),
        ("line 152: voltage_V is 'OVLD', not a number", "delete the row and read the rest with --split-at-gaps"),
    ),
    "words between rows": (
        "\n".join([HEADER, *ROWS[:150], "amplifier off", *ROWS[150:]]),
        ("line 152: has 1 fields", "complete the row"),
    ),
    "zero bytes between rows": (
        "\n".join([HEADER, *ROWS[:150], ""]).encode() + bytes(512) + "\n".join(ROWS[150:]).encode(),
        ("line 152: holds zero bytes", "tr -d", "--split-at-gaps"),
    ),
    "a cell of another quantity": (
        made("time,voltage,displacement", "{t:.3f} s,{u:.4f} V,{y:.4f} um").replace(CELL, "30.0 um"),
        ("line 54: voltage is '30.0 um', the first row is in V", "correct it"),
    ),
    "a unit in some cells": (
        made("time,voltage,displacement", "{t:.3f},{u:.4f} V,{y:.4f}").replace(CELL, "30.0"),
        ("line 54: voltage is '30.0', the first row is in V", "correct it"),
    ),
    "cells against the name": (
        made("time,voltage [mV],displacement", "{t:.3f},{u:.4f} V,{y:.4f}"),
        ("voltage [mV] is in mV by its name and in V by its cells", "correct one of the two"),
    ),
    "commas for both": (
        made("time_s;voltage_V;displacement_um", "{t:.3f};{u:.4f};{y:.4f}").replace(".", ",").replace(";", ","),
        ("line 2: has 6 fields, the header has 3", "semicolons"),
    ),
    "a table on its side": (
        "\n".join(",".join(row) for row in zip(HEADER.split(","), *(row.split(",") for row in ROWS), strict=True)),
        ("line 1: has 301 fields, and there are 3 lines", "transpose the table"),
    ),
    "sentences": (
        "\n".join(f"[INFO] daq: U={u} V x={y} um" for u, y in zip(U_V, Y_UM, strict=True)),
        ("line 1: holds no columns ('[INFO] daq", "save time, voltage and displacement as columns"),
    ),
}


@pytest.mark.parametrize("kind", REFUSED)
def test_text_that_cannot_be_guessed_is_refused_with_its_row_and_a_remedy(kind: str, tmp_path: Path) -> None:
    text, said = REFUSED[kind]
    path = tmp_path / "log.csv"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    with pytest.raises(RecordError) as caught:
        load_record(path)
    assert "\n" not in str(caught.value)
    for part in said:
        assert part in str(caught.value)


NO_NUMBERS = (
    "1.#INF",
    "-1.#INF",
    "1.#IND",
    "-1.#IND",
    "1.#QNAN",
    "1.#SNAN",
    "1,#INF",
    "45%",
    "45 %",
    "#DIV/0!",
    "#N/A",
)


@pytest.mark.parametrize("separator", [",", ";", "\t", " "])
@pytest.mark.parametrize("place", [0, 1, 2])
@pytest.mark.parametrize("word", NO_NUMBERS)
def test_a_word_for_no_number_is_refused_in_every_column_with_its_line(
    word: str, place: int, separator: str, tmp_path: Path
) -> None:
    rows = [[f"{k}e-3", f"{k % 37}", f"{0.1 * (k % 37):.4f}"] for k in range(300)]
    rows[70][place] = word
    path = tmp_path / "log.csv"
    names = separator.join(["time_s", "voltage_V", "displacement_um"])
    path.write_text("\n".join([names, *map(separator.join, rows)]))
    with pytest.raises(RecordError, match=r"log\.csv: line 72: ") as fault:
        load_record(path)
    assert word in str(fault.value) or "fields" in str(fault.value)
