"""A run of the bank: make each record, diagnose it, compare the diagnosis with the hidden effects."""

from __future__ import annotations

import contextlib
import math
import signal
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from hysgen.diagnosis.evaluation import Estimate, Extension, Naming, free_run_error, name_causes, prepare
from hysgen.diagnosis.probe import rms
from hysgen.fitting import PathSize
from hysgen_lab.stage import Preisach, Relays, effect_shares, effects
from hysgen_lab.stage.effects import UNKNOWN, Tolerance
from hysgen_lab.stage.effects.memory import Hysteresis
from hysgen_lab.studies.bank.family_scenario import family_scenario
from hysgen_lab.studies.bank.log import JudgementLog, read_log
from hysgen_lab.studies.bank.result import BankResult, Judgement
from hysgen_lab.studies.bank.scenario import CATEGORIES, OWN, Scenario, memory_only, scenario
from hysgen_lab.studies.bank.truth import error_with_truth_known

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
