"""How well models simulate stages of five families of hysteresis that share no equation with them.

Run:  python benchmarks/path_families.py [--seeds 4] [--families ...] [--scenarios ...] [--chain found|true] [--jobs 1]
      [--log FILE]

Each stage gives two records after movements that no record shows: 32 000 rows to identify from, and 16 000 rows with
other amplitudes, levels and rates to score in free run from where the input has covered its range. Columns, in nm rms:

    paper       the paper's model, `hysgen.fitting.fit` with default settings
    delivered   the model of `hysgen.diagnosis.diagnose(record, holdout=other)`
    chain       the probe's chain, fitted to the same rows to identify from: the chain that the diagnosis found, or
                (--chain true) the chain of the causes that are there
    ratio       delivered over chain
    moving      the same with each error less its mean, i.e. without the offset that creep from before a record leaves
"""

from __future__ import annotations

import argparse
import itertools
import json
import math
import statistics
import time
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any
from unittest import mock

import hysgen  # noqa: F401  before NumPy, whose BLAS reads once how many threads it may have

# isort: split
import numpy as np
from numpy.typing import NDArray

from hysgen.diagnosis import diagnose, procedure
from hysgen.diagnosis.causes.creep import CreepPart
from hysgen.diagnosis.prepare import Prepared, prepare
from hysgen.diagnosis.probe import Chain, Fit, Mode, Part, Scene, Trace, refine, rms
from hysgen.diagnosis.search import SearchResult, search, thinned
from hysgen.errors import HysgenError
from hysgen.fitting import FitSettings, fit
from hysgen.machine.processes import one_blas_thread
from hysgen.model.disturbances.periodic import Periodic
from hysgen.model.path.delay import Delay
from hysgen.model.path.limits import Saturation
from hysgen.model.path.modes import Modes
from hysgen.model.simulate import free_run
from hysgen.record import Record
from hysgen_lab.stage import CreepEffect, DelayEffect, Effect, PeriodicEffect, ResonanceEffect, SaturationEffect
from hysgen_lab.stage.families import FAMILIES, SCENARIOS, Plant, plant, records

Floats = NDArray[np.float64]
ACCEPTED = ("constant", "saturation")


@dataclass(frozen=True)
class Row:
    """One stage: free-run errors on the scored rows of the other record, and the causes named.

    rms_nm: by "paper", "delivered", "found" (the chain of the diagnosis) and "true" (of the causes that are there).
    moving_nm: standard deviation of the same errors. seconds: of the diagnosis. fault: message of an error, if any.
    """

    family: str
    scenario: str
    seed: int
    rate_Hz: float
    stroke_um: float
    noise_nm: float
    rms_nm: dict[str, float] = field(default_factory=dict)
    moving_nm: dict[str, float] = field(default_factory=dict)
    named: tuple[str, ...] = ()
    seconds: float = math.nan
    fault: str = ""

    def ratio(self, chain: str) -> float:
        """Delivered error over that of the chain "found" or "true"."""
        return self.rms_nm["delivered"] / self.rms_nm[chain]

    def moving(self, chain: str) -> float:
        """The same for the errors less their means."""
        return self.moving_nm["delivered"] / self.moving_nm[chain]

    def cells(self, chain: str) -> list[str]:
        """The row of the table."""
        stage = [self.family, self.scenario, str(self.seed), f"{self.rate_Hz:.0f}", f"{self.stroke_um:.1f}"]
        if self.fault:
            return [*stage, f"{self.noise_nm:.3g}", *[""] * 6, self.fault]
        errors = (self.noise_nm, *(self.rms_nm[name] for name in ("paper", "delivered", chain)))
        numbers = [f"{value:.4g}" for value in errors] + [f"{self.ratio(chain):.2f}", f"{self.moving(chain):.2f}"]
        return [*stage, *numbers, f"{self.seconds:.0f}", ", ".join(self.named) or "no cause"]


COLUMNS = (
    "family",
    "scenario",
    "seed",
    "Hz",
    "um",
    "noise",
    "paper",
    "delivered",
    "chain",
    "ratio",
    "moving",
    "s",
    "named",
)
WIDTHS = (15, 16, 5, 6, 6, 7, 8, 10, 8, 7, 7, 5, 0)


def measured(hidden: Plant) -> tuple[Record, Record]:
    """The record to identify from, and the one to score."""
    source = f"{hidden.family}, {hidden.scenario}, {hidden.seed}"
    first, second = (
        Record.from_arrays(u_V, y_um, hidden.Ts_s, source=f"{source}, {use}", accept=ACCEPTED)
        for (u_V, y_um), use in zip(records(hidden), ("identify", "score"), strict=True)
    )
    return first, second


def true_chain(hidden: Plant) -> Chain:
    """The probe's chain with a part for each effect that the stage has, started at the stage's numbers."""
    parts = [_part(effect, hidden.range_V) for effect in hidden.stage.effects if isinstance(effect, PARTS)]
    return Chain(hidden.stage.lag_s, tuple(parts))


PARTS = (CreepEffect, DelayEffect, ResonanceEffect, SaturationEffect, PeriodicEffect)


def _part(effect: Effect, range_V: tuple[float, float]) -> Part:
    match effect:
        case CreepEffect():
            return CreepPart(effect.per_decade, effect.tau_min_s)
        case DelayEffect():
            return Delay(effect.samples)
        case ResonanceEffect():
            return Modes.of((Mode(effect.f_Hz, effect.zeta, effect.share),), 1.0)
        case SaturationEffect():
            low_V, high_V = effect.passes_V(*range_V)
            return Saturation(low_V if low_V > range_V[0] else None, high_V if high_V < range_V[1] else None)
        case PeriodicEffect():
            return Periodic((effect.f_Hz,))
    raise TypeError(f"{effect.name}: the chain has no part for it")


def predicted(found: Fit, prepared: Prepared, other: Record) -> Floats:
    """(n,) the displacement of the other record by a fit of the chain to the rows to identify from.

    The columns of creep from before a record have no part in it: their weights belong to the other record's past.
    """
    known = prepared.scene()
    runs = tuple(Trace(s.u_V, s.y_um, dict(s.aux)) for s in other.segments)
    scene = Scene(runs, other.Ts_s, np.arange(other.samples), known.operator, known.known_ranges)
    weights = found.weights.copy()
    creep = found.chain.get(CreepPart)
    if creep is not None:
        first = scene.column_of(found.chain, CreepPart)
        weights[first : first + creep.added] = 0.0
    return weights @ scene.columns(found.chain)


def judged(key: tuple[str, str, int]) -> Row:
    """The row of one stage; a HysgenError is reported in place of the errors."""
    hidden = plant(*key)
    stage = Row(*key, 1 / hidden.Ts_s, hidden.stroke_um, 1e3 * hidden.noise_um)
    try:
        return _with_errors(stage, hidden)
    except HysgenError as fault:
        return replace(stage, fault=str(fault))


@one_blas_thread()
def _with_errors(stage: Row, hidden: Plant) -> Row:
    record, other = measured(hidden)
    kept: list[SearchResult] = []

    def keeping(*arguments: Any) -> SearchResult:
        kept.append(search(*arguments))
        return kept[-1]

    begun = time.perf_counter()
    # The chain that the diagnosis finds is no part of its answer.
    with mock.patch.object(procedure, "search", keeping):
        diagnosis = diagnose(record, holdout=other)
    seconds = time.perf_counter() - begun
    prepared = prepare(record, other)
    runs = {
        "paper": free_run(fit(record, FitSettings()), other)[0].y_um,
        "delivered": free_run(diagnosis.model, other)[0].y_um,
        "found": predicted(kept[-1].fit, prepared, other),
        "true": predicted(refine(thinned(prepared.scene()), true_chain(hidden), rounds=30), prepared, other),
    }
    scored = prepared.held_rows - record.samples
    errors = {name: 1e3 * (run - other.segments[0].y_um) for name, run in runs.items()}
    errors = {name: without_offset(error, int(scored[0]))[scored] for name, error in errors.items()}
    return replace(
        stage,
        rms_nm={name: rms(error) for name, error in errors.items()},
        moving_nm={name: float(np.std(error)) for name, error in errors.items()},
        named=diagnosis.names,
        seconds=seconds,
    )


def without_offset(error_nm: Floats, count: int) -> Floats:
    """The error without the offset that its first `count` rows show: their mean, shrunk by their scatter."""
    shown = error_nm[count // 3 : count]
    mean, deviation = float(np.mean(shown)), float(np.std(shown))
    return error_nm - mean * mean**2 / (mean**2 + deviation**2)


def rows(keys: Sequence[tuple[str, str, int]], jobs: int) -> Iterator[Row]:
    """The rows in the order in which they are done."""
    if jobs <= 1:
        yield from map(judged, keys)
        return
    with ProcessPoolExecutor(jobs) as pool:
        for future in as_completed([pool.submit(judged, key) for key in keys]):
            yield future.result()


def line(cells: Iterable[str]) -> str:
    """One line of the table: text to the left, numbers to the right."""
    placed = [
        cell.ljust(width) if name in ("family", "scenario", "named") else cell.rjust(width)
        for name, width, cell in zip(COLUMNS, WIDTHS, cells, strict=True)
    ]
    return " ".join(placed).rstrip()


def summary(done: Sequence[Row], chain: str) -> list[str]:
    """Median and worst ratio, and the number of delivered models above the paper's: of all, by scenario, by family."""
    judged = [row for row in done if not row.fault]
    groups = {"all": judged}
    groups |= {name: [row for row in judged if row.scenario == name] for name in SCENARIOS}
    groups |= {name: [row for row in judged if row.family == name] for name in FAMILIES}
    lines = [
        f"{'delivered / chain':18}{'stages':>8}{'median':>9}{'worst':>9}{'moving':>9}{'worst':>9}{'above paper':>13}"
    ]
    for name, members in groups.items():
        if members:
            values = [[row.ratio(chain) for row in members], [row.moving(chain) for row in members]]
            cells = "".join(f"{figure(ratios):9.2f}" for ratios in values for figure in (statistics.median, max))
            above = sum(row.rms_nm["delivered"] > row.rms_nm["paper"] for row in members)
            lines.append(f"{name:18}{len(members):8}{cells}{above:13}")
    faults = len(done) - len(judged)
    return lines + ([f"{faults} stages ended in an error"] if faults else [])


def main() -> None:
    """Print one line for each stage as it is done, then the summary."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=4, help="stages of each family and scenario")
    parser.add_argument("--first", type=int, default=0, help="first seed")
    parser.add_argument("--families", nargs="+", choices=tuple(FAMILIES), default=list(FAMILIES), metavar="FAMILY")
    parser.add_argument("--scenarios", nargs="+", choices=tuple(SCENARIOS), default=list(SCENARIOS), metavar="SCENARIO")
    parser.add_argument("--chain", choices=("found", "true"), default="found", help="causes in the probe's chain")
    parser.add_argument("--jobs", type=int, default=1, help="processes")
    parser.add_argument("--log", type=Path, help="file of JSON lines, one for each stage")
    asked = parser.parse_args()
    seeds = range(asked.first, asked.first + asked.seeds)
    keys = [
        (family, scenario, seed) for seed, scenario, family in itertools.product(seeds, asked.scenarios, asked.families)
    ]
    print("rms in nm, free run on the other record")
    print(line(COLUMNS), flush=True)
    done = []
    if asked.log is not None:
        asked.log.write_text("", encoding="utf-8")
    for row in rows(keys, asked.jobs):
        done.append(row)
        print(line(row.cells(asked.chain)), flush=True)
        if asked.log is not None:
            with asked.log.open("a", encoding="utf-8") as log:
                log.write(json.dumps(asdict(row)) + "\n")
    print("\n".join(["", *summary(done, asked.chain)]))


if __name__ == "__main__":
    main()
