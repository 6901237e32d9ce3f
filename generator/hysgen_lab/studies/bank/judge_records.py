"""A run of the bank: make each record, diagnose it, compare the diagnosis with the hidden effects.

The limits that a run of the bank must meet, and whether it meets them.
"""

import contextlib
import math
import signal
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from hysgen.diagnosis.evaluation import (
    Estimate,
    Extension,
    Naming,
    extended,
    free_run_error,
    name_causes,
    prepare,
)
from hysgen.diagnosis.probe import rms
from hysgen.fitting import PathSize
from hysgen_lab.stage import Preisach, Relays, effect_shares, effects
from hysgen_lab.stage.effects import UNKNOWN, Tolerance
from hysgen_lab.stage.effects.memory import Hysteresis
from hysgen_lab.studies.bank.family_scenario import family_scenario
from hysgen_lab.studies.bank.log import JudgementLog, read_log
from hysgen_lab.studies.bank.result import BankResult, Judgement
from hysgen_lab.studies.bank.scenario import CATEGORIES, OWN, Scenario, error_with_truth_known, memory_only, scenario

RECORDS, QUIET = 200, 100
"""Number of records, and of records with nothing hidden, that the limits of the rates are stated for."""

LEAST_EXACT, LEAST_FOUND = 0.95, 0.98
LEAST_EXACT_IN_FAMILY, FAMILY_RECORDS = 0.90, 42
"""Share of exact sets in each family of hysteresis, and the records it is stated for: 14 categories, 3 seeds."""

ALARMS = 1
"""False alarms that are allowed in QUIET records."""

LEAST_FALL = 7.0
MOST_OVER_TRUTH = 2.0

PARAMETERS: dict[str, float] = {
    key: tolerance.limit
    for kind in effects().values()
    for key, tolerance in kind.tolerances.items()
    if tolerance is not None and tolerance.limit is not None
}
"""Largest error of each parameter, in the measure of its `Tolerance`."""


@dataclass(frozen=True)
class Limit:
    """One limit: the value wanted, the value measured, and whether it holds; None where no record measures it.

    enough: whether the run has the number of records that the limit is stated for. beyond: records that exceed it.
    """

    name: str
    wanted: str
    measured: str
    holds: bool | None
    enough: bool = True
    beyond: tuple[str, ...] = ()

    @property
    def mark(self) -> str:
        """ "met", "MISSED", "met so far" with too few records, or "-"."""
        if self.holds is None:
            return "-"
        return ("met" if self.enough else "met so far") if self.holds else "MISSED"


def limits(result: BankResult) -> tuple[Limit, ...]:
    """Every limit, on the records of a run with a good excitation."""
    judged = result.judged()
    parameters = (_parameter_limit(key, most, judged) for key, most in PARAMETERS.items())
    families = (_family_limit(name, part) for name, part in result.families().items())
    return (*_rate_limits(result), *families, *parameters, _fall_limit(judged), _truth_limit(judged))


def _family_limit(name: str, part: BankResult) -> Limit:
    judged = part.judged()
    return Limit(
        f"exact set, {name or 'own stage'}",
        f">= {100 * LEAST_EXACT_IN_FAMILY:.0f} % of {FAMILY_RECORDS} records",
        f"{100 * part.exact_rate:.1f} % of {len(judged)}",
        part.exact_rate >= LEAST_EXACT_IN_FAMILY if judged else None,
        len(judged) >= FAMILY_RECORDS,
    )


def _rate_limits(result: BankResult) -> list[Limit]:
    judged, quiet = result.judged(), result.quiet()
    alarmed = [judgement for judgement in quiet if judgement.wrong]
    lacking = [judgement for judgement in judged if not set(judgement.required) <= set(judgement.named)]
    required = sum(len(judgement.required) for judgement in judged)
    return [
        Limit(
            "exact set of causes",
            f">= {100 * LEAST_EXACT:.0f} % of {RECORDS} records",
            f"{100 * result.exact_rate:.1f} % of {len(judged)}",
            result.exact_rate >= LEAST_EXACT if judged else None,
            len(judged) >= RECORDS,
            _differences([judgement for judgement in judged if not judgement.exact]),
        ),
        Limit(
            "required causes found",
            f">= {100 * LEAST_FOUND:.0f} %",
            f"{100 * result.found_rate:.1f} % of {required}",
            result.found_rate >= LEAST_FOUND if required else None,
            len(judged) >= RECORDS,
            _differences(lacking),
        ),
        Limit(
            "false alarms",
            f"<= {ALARMS} in {QUIET} quiet records",
            f"{len(alarmed)} in {len(quiet)}",
            len(alarmed) <= ALARMS * max(1.0, len(quiet) / QUIET) if quiet else None,
            len(quiet) >= QUIET,
            _differences(alarmed),
        ),
    ]


def _parameter_limit(key: str, most: float, judged: list[Judgement]) -> Limit:
    """The largest error of "cause.parameter", over the records where the cause was required and named."""
    name = key.split(".")[0]
    seen = [
        judgement
        for judgement in judged
        if key in judgement.errors and name in judgement.required and name in judgement.named
    ]
    errors = [(judgement.name, judgement.errors[key]) for judgement in seen]
    worst = max((abs(error) for _, error in errors), default=math.nan)
    beyond = [named for named in errors if not abs(named[1]) <= most]
    return _limit_of(f"error of {key}", f"<= {most:g}", f"{worst:.3g}, {len(seen)} records", errors, beyond, ".3g")


def _fall_limit(judged: list[Judgement]) -> Limit:
    falls = [(judgement.name, judgement.fall) for judgement in judged if math.isfinite(judgement.fall)]
    beyond = [named for named in falls if named[1] < LEAST_FALL]
    measured = f"{min((fall for _, fall in falls), default=math.nan):.1f} at least, {len(falls)} records"
    return _limit_of("fall by the memory extension", f">= {LEAST_FALL:g} times", measured, falls, beyond, ".1f")


def _truth_limit(judged: list[Judgement]) -> Limit:
    ratios = [(judgement.name, judgement.over_truth) for judgement in judged if math.isfinite(judgement.over_truth)]
    beyond = [named for named in ratios if named[1] > MOST_OVER_TRUTH]
    measured = f"{max((ratio for _, ratio in ratios), default=math.nan):.2f} at most, {len(ratios)} records"
    name = "error over that with the truth known"
    return _limit_of(name, f"<= {MOST_OVER_TRUTH:g}", measured, ratios, beyond, ".2f")


Values = list[tuple[str, float]]
"""Name and value of records."""


def _limit_of(name: str, wanted: str, measured: str, values: Values, beyond: Values, form: str) -> Limit:
    """A limit of the values of records; beyond: those that exceed it."""
    exceeding = tuple(f"{record}: {value:{form}}" for record, value in beyond)
    if not values:
        return Limit(name, wanted, "no record", None)
    return Limit(name, wanted, measured, not beyond, beyond=exceeding)


def limits_table(comparisons: tuple[Limit, ...]) -> str:
    """The limits as text; below each limit the records that exceed it."""
    lines = [f"{'limit':38}{'wanted':26}{'measured':26}"]
    for limit in comparisons:
        lines.append(f"{limit.name:38}{limit.wanted:26}{limit.measured:26}{limit.mark}")
        lines.extend(f"    {record}" for record in limit.beyond)
    return "\n".join(lines)


def _differences(judgements: list[Judgement]) -> tuple[str, ...]:
    return tuple(f"{judgement.name}: {judgement.difference()}" for judgement in judgements)


Floats = NDArray[np.float64]
Progress = Callable[[float, Judgement], None]


def run(
    seeds: Sequence[int],
    categories: Sequence[str] = CATEGORIES,
    families: Sequence[str] = (OWN,),
    jobs: int = 1,
    progress: Progress | None = None,
    log: Path | None = None,
) -> BankResult:
    """Judge every category of every family with every seed, in `jobs` processes.

    families: of `hysgen_lab.stage.families`, or OWN for the bank's own stage.
    progress: called with the fraction done and each judgement. log: file of judgements; the records that it holds
    already are not judged again. After an interrupt the result holds the records judged so far (`complete` is false).
    Raises HysgenError if the log belongs to another state of the package, or cannot be written.
    """
    work = [(family, category, seed) for seed in seeds for category in categories for family in families]
    known = {} if log is None else {(v.family, v.category, v.seed): v for v in read_log(log)}
    done = {key: known[key] for key in work if key in known}
    judgements = JudgementLog(log)
    with contextlib.suppress(KeyboardInterrupt):
        for judgement in _judged([key for key in work if key not in done], jobs):
            judgements.add(judgement)
            done[judgement.family, judgement.category, judgement.seed] = judgement
            if progress is not None:
                progress(len(done) / len(work), judgement)
    return BankResult(tuple(done[key] for key in work if key in done), tuple(seeds), len(work))


def _judged(work: Sequence[tuple[str, str, int]], jobs: int) -> Iterator[Judgement]:
    """The judgements in the order in which they are done; when the loop ends early, waiting records are cancelled."""
    if jobs <= 1 or len(work) <= 1:
        yield from map(_one, work)
        return
    # An interrupt from the keyboard reaches every process of the terminal; the workers ignore it, this one handles it.
    pool = ProcessPoolExecutor(jobs, initializer=signal.signal, initargs=(signal.SIGINT, signal.SIG_IGN))
    try:
        for future in as_completed([pool.submit(_one, key) for key in work]):
            yield future.result()
    finally:
        pool.shutdown(wait=True, cancel_futures=True)


def judge(hidden: Scenario) -> Judgement:
    """Measure a scenario, diagnose its record, and compare the causes named with the causes planted."""
    measured = hidden.measure()
    record = hidden.record(measured)
    memory_rms_um = memory_model_rms(hidden)
    begun = time.perf_counter()
    naming = name_causes(record)
    seconds = time.perf_counter() - begun
    delivered = extended(naming)
    fall, over_truth = _error_ratios(hidden, naming, measured.truth.outlier[hidden.past :])
    # An effect that the fitted rows do not contain, such as a level that only later rows exceed, cannot be found.
    shares_um = effect_shares(measured, hidden.past + naming.prepared.scene().rows)
    compared = compare_parameters(hidden, naming.estimates)
    shares = {effects()[name].cause(): share_um for name, share_um in shares_um.items()}
    return Judgement(
        category=hidden.category,
        seed=hidden.seed,
        rate_Hz=1.0 / hidden.Ts_s,
        excitation=hidden.excitation,
        planted=hidden.planted,
        required=tuple(name for name in hidden.planted if shares[name] > memory_rms_um),
        named=naming.names,
        relative={name: shares[name] / memory_rms_um for name in hidden.planted},
        errors={key: both.error for key, both in compared.items()},
        ranks={key: both.rank for key, both in compared.items() if math.isfinite(both.rank)},
        seconds=seconds,
        experiment=naming.next_experiment,
        fall=fall,
        over_truth=over_truth,
        family=hidden.family,
        allowed=hidden.allowed,
        confidence=naming.confidence,
        over_probe=delivered.remaining.rms_um / delivered.remaining.probe_rms_um,
        gain=delivered.base_own_um / delivered.remaining.rms_um,
    )


def _error_ratios(hidden: Scenario, naming: Naming, corrupted: NDArray[np.bool_]) -> tuple[float, float]:
    """Two ratios of free-run errors: of the paper's model over the extended one, and of the extended model over the
    model with the truth known. Each is nan where `Judgement` says so, and for stages of other families.
    """
    prepared, agreed = naming.prepared, naming.agreed
    held = prepared.held_rows[~corrupted[prepared.held_rows]]
    if hidden.family != OWN or hidden.excitation != "good" or not hidden.planted:
        return math.nan, math.nan
    if set(naming.names) != set(hidden.planted):
        return math.nan, math.nan
    extended = rms(free_run_error(prepared, naming.extensions, agreed, forms=True)[held])
    fall = math.nan
    if hidden.planted == (Hysteresis.name,) and isinstance(hidden.stage.memory, Preisach | Relays):
        fall = rms(free_run_error(prepared, {})[held]) / extended
    return fall, math.nan if UNKNOWN in hidden.planted else extended / error_with_truth_known(hidden)


def memory_model_rms(hidden: Scenario) -> float:
    """Free-run rms in um of the model with the usual memory extension, on the stage without effects but hysteresis."""
    bare = memory_only(hidden)
    prepared = prepare(bare.record(bare.measure()))
    extension = Extension(size=PathSize(), lag_s=prepared.record.Ts_s)
    error_um = free_run_error(prepared, {Hysteresis.name: extension}, [Hysteresis.name])
    return rms(error_um[prepared.held_rows])


class Compared(NamedTuple):
    """A parameter that was found beside the true one.

    error: signed, in the measure of its `Tolerance`. rank: of the truth in the distribution that the estimate states,
    Phi((truth - value) / standard error), uniform over records where that is right; nan without a standard error.
    """

    error: float
    rank: float


def compare_parameters(hidden: Scenario, estimates: Mapping[str, Estimate]) -> dict[str, Compared]:
    """The parameters found, by "cause.parameter", beside the true ones. Of effects of one kind the first is compared.

    Source of the ranks: Talts et al., Validating Bayesian inference with simulation-based calibration (2018).
    """
    compared: dict[str, Compared] = {}
    range_V = float(np.ptp(hidden.u_V))
    for effect in hidden.stage.effects:
        for key, truth in effect.true_parameters().items():
            tolerance = effect.tolerances.get(key, Tolerance())
            if tolerance is not None and key in estimates and key not in compared and math.isfinite(truth):
                value, error = estimates[key].value, estimates[key].standard_error
                rank = float(ndtr((truth - value) / error)) if error > 0.0 else math.nan
                compared[key] = Compared(tolerance.error(value, truth, range_V), rank)
    return compared


def _one(work: tuple[str, str, int]) -> Judgement:
    family, category, seed = work
    return judge(family_scenario(family, category, seed) if family else scenario(category, seed))
