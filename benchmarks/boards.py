"""Measured boards and benchmarks: what a diagnosis names and leaves, beside rivals on the same rows.

    mirror   fine-steering mirror, 3 drives, one model for each axis and amplitude: realisations 1 to 5 identify, the
             sixth is scored; mean of the three axes
    bouc-wen multisine of the Bouc-Wen benchmark: the first 65 % of train.csv identify, the rest is scored
    dbo      ramps of a micromanipulator: rows 0 to 5000 identify, the rest is scored
    bundled  the record of `hysgen demo`

All errors are rms of free runs in um over rows that no fit saw, after the first tenth of them. Cold: nothing of these
rows is known. Own: without the state before them, the phase of lines, the course of slow changes, jumps, gain steps and
wrong readings (`hysgen.model.remaining`), for every model by what the diagnosis names.

Run:  HYSGEN_DATA=/folder/of/the/records python benchmarks/boards.py [mirror-100 mirror-300 bouc-wen dbo bundled]
"""

from __future__ import annotations

import os
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import hysgen  # noqa: F401  before NumPy, whose BLAS reads once how many threads it may have

# isort: split
import numpy as np
from numpy.typing import NDArray

from hysgen.diagnosis import diagnose
from hysgen.display import table
from hysgen.errors import HysgenError
from hysgen.fitting.structure import identify_structure
from hysgen.model.remaining import Named, take_out
from hysgen.model.rivals import fit_arx, fit_prandtl_ishlinskii
from hysgen.record import Record, Segment, load_record
from hysgen.record.read import IDENTIFICATION_ROWS, bundled_csv

Floats = NDArray[np.float64]
DATA = Path(os.environ.get("HYSGEN_DATA", "."))
MIRROR_HZ, BOUC_WEN_HZ = 6400.0, 750.0
UNSCORED = 0.1
ARX_ORDERS = (2, 4, 8, 16, 32)


@dataclass(frozen=True, eq=False)
class Board:
    """Rows to identify and rows to score, of one axis; published: best of others on official tests, um."""

    known: Record
    fresh: Record
    published: str


def mirror(amplitude_mV: int, published: str) -> Iterator[Board]:
    """Each axis with its own drive as input and the other two as channels; two periods of each realisation."""
    with np.load(DATA / "fsm" / "fsm_train.npz") as file:
        u, y = (file[f"{name}_{amplitude_mV}mV_train"].transpose(2, 1, 3, 0).astype(float) for name in "uy")
    u, y = (x.reshape(*x.shape[:2], -1) for x in (u, y))  # (realisations, axes, rows of two periods)
    for axis in range(3):
        others = [other for other in range(3) if other != axis]
        segments = [
            Segment(str(r), v[axis], x[axis], {f"drive_{other}": v[other] for other in others})
            for r, (v, x) in enumerate(zip(u, y, strict=True))
        ]
        source = f"mirror, {amplitude_mV} mV, axis {axis}"
        records = (Record.from_segments(part, 1.0 / MIRROR_HZ, source) for part in (segments[:5], segments[5:]))
        yield Board(*records, published)


def bouc_wen() -> Iterator[Board]:
    """Force in N as the voltage, displacement in um."""
    rows = np.loadtxt(DATA / "boucwen" / "train.csv", delimiter=",", skiprows=1)
    record = Record.from_arrays(rows[:, 1], 1e6 * rows[:, 2], fs_Hz=BOUC_WEN_HZ, source="bouc-wen")
    yield Board(*record.split_at(round(0.65 * record.samples)), "7.2")


def dbo() -> Iterator[Board]:
    """Rows 0 to 5000 of the ramps."""
    yield Board(*load_record(DATA / "dbo" / "ramps.csv").split_at(5000), "")


def bundled() -> Iterator[Board]:
    """The rows that the demo identifies from, and those that it scores."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "record.csv"
        file.write_text(bundled_csv(), encoding="utf-8")
        yield Board(*load_record(file).split_at(IDENTIFICATION_ROWS), "")


BOARDS: dict[str, Callable[[], Iterator[Board]]] = {
    "mirror-100": lambda: mirror(100, "0.087"),
    "mirror-300": lambda: mirror(300, "0.169"),
    "bouc-wen": bouc_wen,
    "dbo": dbo,
    "bundled": bundled,
}


def scored(fresh: Record, runs: list[Floats], named: Named) -> tuple[float, float]:
    """rms error in um, cold and own, of the rows after the first tenth of each segment."""
    errors = [run - s.y_um for run, s in zip(runs, fresh.segments, strict=True)]
    rows = [np.arange(s.samples) >= int(UNSCORED * s.samples) for s in fresh.segments]
    cold = np.concatenate([error[counted] for error, counted in zip(errors, rows, strict=True)])
    own = take_out(errors, [s.y_um for s in fresh.segments], rows, fresh.Ts_s, named)
    return float(np.sqrt(np.mean(cold**2))), own.rms_um


Run = tuple[list[Floats], str]
"""The free run of a model over the segments of the fresh rows, (n,) each, and its size or what it names."""


def linear(board: Board) -> Run:
    """The identified modes alone, without hysteresis or rules; simulated through the known past."""
    form = identify_structure(*_signals(board.known), board.known.Ts_s)
    inputs, _ = _signals(board.fresh.whole())
    runs = [form.simulate(v)[past:] for v, past in zip(inputs, board.fresh.past_samples, strict=True)]
    return runs, f"{len(form.poles)} modes"


def arx(board: Board) -> Run:
    """ARX of the own input, its order the best of ARX_ORDERS in free run on the last third of the rows to identify."""
    cut = round(2 / 3 * board.known.samples)
    fit_rows, check_rows = board.known.rows(0, cut), board.known.rows(cut, board.known.samples)
    order = min(ARX_ORDERS, key=lambda n: _or_infinite(_rms(check_rows, fit_arx(fit_rows, n, n).free_run(check_rows))))
    return fit_arx(board.known, order, order).free_run(board.fresh), f"order {order}"


def prandtl_ishlinskii(board: Board) -> Run:
    """Static plays of the own input."""
    return fit_prandtl_ishlinskii(board.known).free_run(board.fresh), "20 plays"


def diagnosed(board: Board) -> tuple[Run, Named]:
    """The free run of what `hysgen diagnose` delivers with default options, and the causes that it names."""
    found = diagnose(board.known, board.fresh)
    ends = np.cumsum([s.samples for s in board.fresh.segments])[:-1]
    errors = np.split(found.errors_um[-1][1][-board.fresh.samples :], ends)
    runs = [error + s.y_um for error, s in zip(errors, board.fresh.segments, strict=True)]
    return (runs, ", ".join(found.names) or "nothing"), Named.of(found.model)


RIVALS = {"modes alone": linear, "ARX": arx, "Prandtl-Ishlinskii": prandtl_ishlinskii}


def _rms(record: Record, runs: list[Floats]) -> float:
    """rms error in um of the rows after the first tenth of each segment."""
    errors = [(run - s.y_um)[int(UNSCORED * s.samples) :] for run, s in zip(runs, record.segments, strict=True)]
    return float(np.sqrt(np.mean(np.concatenate(errors) ** 2)))


def _or_infinite(value: float) -> float:
    return value if np.isfinite(value) else float("inf")


def _signals(record: Record) -> tuple[list[Floats], list[Floats]]:
    inputs = [np.stack([s.u_V, *(s.aux[name] for name in record.aux_names)]) for s in record.segments]
    return inputs, [s.y_um for s in record.segments]


def main() -> None:
    """Print one table in um rms."""
    rows = []
    for name in sys.argv[1:] or BOARDS:
        boards = list(BOARDS[name]())
        begun = time.perf_counter()
        of_boards = [diagnosed(board) for board in boards]
        named = [what for _, what in of_boards]
        for label in ("hysgen diagnose", *RIVALS):
            errors, words = [], []
            for board, (own, _), what in zip(boards, of_boards, named, strict=True):
                try:
                    runs, word = RIVALS[label](board) if label in RIVALS else own
                    errors.append(scored(board.fresh, runs, what))
                except HysgenError as fault:
                    errors.append((float("nan"), float("nan")))
                    word = str(fault)
                words.append(word)
            seconds, begun = (time.perf_counter() - begun) / len(boards), time.perf_counter()
            cold_um, own_um = np.mean(errors, axis=0)
            said = " | ".join(dict.fromkeys(words))
            rows.append([name, label, f"{cold_um:.4g}", f"{own_um:.4g}", f"{seconds:.1f}", boards[0].published, said])
            print(" ".join(rows[-1]), file=sys.stderr)
    print(table(["board", "model", "cold um", "own um", "s", "published", "named, or size"], rows))


if __name__ == "__main__":
    main()
