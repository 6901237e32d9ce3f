"""From a record to a model: partition, least squares, certificates, refinement."""

import dataclasses
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hysgen.certify.certificates import certify
from hysgen.errors import FitError, RecordError
from hysgen.fitting.least_squares import (
    CertifiedSet,
    Information,
    Weighting,
    certified_set,
    information,
    least_squares_inside,
    recursive_least_squares,
)
from hysgen.fitting.operator import CURVE
from hysgen.fitting.path import PathColumns, known_past, path_columns, path_model
from hysgen.fitting.path_regressors import PathTask
from hysgen.fitting.refine import Progress, free_run_error, refine
from hysgen.fitting.settings import FitSettings
from hysgen.machine.processes import one_blas_thread
from hysgen.model.model import Grid, Model
from hysgen.model.regression import Starts, Structure, Trust, structure_of
from hysgen.model.simulate import free_run
from hysgen.record import Record
from hysgen.record.excitation import fastest_V_per_s
from hysgen.record.series import turning_rows, white_noise

Floats = NDArray[np.float64]

PER_PARAMETER = 4
"""Least number of steps y(k) to y(k+1) per parameter; typical records have hundreds."""
SEPARATE = 0.03
"""Least rms of y about its regression line on u in a rule's cell, relative to the rms of y there, to separate both."""


@one_blas_thread()
def fit(
    record: Record,
    settings: FitSettings | None = None,
    trust: Trust | None = None,
    starts: Starts | None = None,
    progress: Progress | None = None,
) -> Model:
    """Fit a model to a record with `settings` (default: FitSettings()).

    trust: weight of each sample, one array per segment; 0 excludes a sample (outliers).
    starts: states of the terms before each segment, where they are known.
    progress: called with the fraction done and one line of text after each step.

    The model contains its history (settings, record, outcome of the fit) and its certificates. A constant on which the
    displacement stands (`Record.level_um`) changes no more than the numbers that hold it.
    Raises FitError, ModelError or RecordError with one line.
    """
    chosen, level_um = settings or FitSettings(), record.level_um
    if not level_um:
        return _fit(record, chosen, trust, starts, progress)
    lower = chosen
    if chosen.displacement_range_um is not None:
        low_um, high_um = chosen.displacement_range_um
        lower = dataclasses.replace(chosen, displacement_range_um=(low_um - level_um, high_um - level_um))
    model = _fit(record.raised(-level_um), lower, trust, starts, progress)
    return _with_history(model.raised(level_um), record, chosen, dict(model.history["outcome"]))


def _fit(
    record: Record, chosen: FitSettings, trust: Trust | None, starts: Starts | None, progress: Progress | None
) -> Model:
    """`fit` of a displacement that stands on no constant of its own."""
    if chosen.on_path:
        weights = known_past(record, trust, chosen.blocks)
        path = path_task(record, chosen)
        if not any(record.past_samples):
            return fit_path(path_columns(path, weights), chosen, weights)
        # The path runs through the known past of the record; rows of the past have no weight.
        path = dataclasses.replace(path, record=record.whole(), whole=record.whole())
        weights = [np.pad(part, (past, 0)) for part, past in zip(weights, record.past_samples, strict=True)]
        model = fit_path(path_columns(path, weights), chosen, weights)
        return _with_history(model, record, chosen, dict(model.history["outcome"]))
    structure = structure_for(record, chosen)
    weighting = chosen.weighting(trust, starts)
    if chosen.method == "rls":
        model = _model(record, chosen, structure, recursive_least_squares(record, structure, weighting))
        return _with_history(model, record, chosen, {})
    task = _Task(record, chosen, structure, weighting, information(record, structure, weighting))
    gain = linear_gain(structure, task.one_step)
    allowed = certified_set(structure, gain, chosen.slope_limit) if chosen.certified else None
    model, outcome = _best_inside(task, allowed, progress)
    return _with_history(model, record, chosen, outcome)


CHECKED_BLOCKS = 12
"""Blocks of the record's rows, of which every third is left out to compare the refined rules with one lag."""


LAGS = (0.3, 1.0, 3.0, 10.0, 30.0)
"""Starting values of the lag in samples; the lag is searched between a fifth and five times each."""


def path_task(record: Record, settings: FitSettings, whole: Record | None = None) -> PathTask:
    """The path that `settings` define for a record; without memory its hysteresis is a curve.

    whole: record of all commands that are known in advance, by default `record`.
    """
    # The lag of a larger chain, in which a mode may stand for the lag, is one starting value of several.
    lags_s = [lag * record.Ts_s for lag in LAGS] + ([settings.lag_s] if settings.lag_s is not None else [])
    return PathTask(
        record=record,
        whole=whole or record,
        grid=partition(record, settings.rules, settings.margin, settings.displacement_range_um),
        input_range_V=settings.input_range_V or record.u_range_V,
        blocks=settings.blocks,
        terms=settings.terms,
        lags_s=tuple(lags_s),
        size=settings.memory or CURVE,
        past=settings.past,
        rising=settings.rising,
        name=settings.name,
    )


@one_blas_thread()
def fit_path(problem: PathColumns, settings: FitSettings, trust: Trust) -> Model:
    """Fit a physical path and the rules behind it: `path_model`, then the rules by the free-run error.

    The rules are refined from one lag on, without what the motion before the record adds. They stay that lag unless
    refined rules have a smaller error on blocks of rows that were left out. Raises FitError, ModelError or RecordError
    with one line.
    """
    whole = problem.task.record
    model, crept_um = path_model(problem, trust)
    segments = zip(whole.segments, crept_um, strict=True)
    rested = [dataclasses.replace(segment, y_um=segment.y_um - past_um) for segment, past_um in segments]
    record = Record.from_segments(rested, whole.Ts_s, whole.source)
    outcome: dict[str, object] = {"rules": "one lag"}
    if settings.method == "refined":
        weight = np.concatenate(list(trust))
        rows = np.flatnonzero(weight > 0.0)
        checked = rows[np.arange(rows.size) * CHECKED_BLOCKS // max(rows.size, 1) % 3 == 1]
        weight[checked] = 0.0
        parts = np.split(weight, np.cumsum([segment.samples for segment in record.segments])[:-1])
        trial = _refined_rules(record, settings, model, parts)
        before, after = (_rms_on(record, one, checked) for one in (model, trial))
        if after < before:
            model = _refined_rules(record, settings, model, trust)
            outcome = {"rules": "refined"}
        outcome["left_out_rms_um"] = {"one_lag": before, "refined": after}
    return _with_history(model, whole, settings, outcome)


def _refined_rules(record: Record, settings: FitSettings, start: Model, trust: Trust) -> Model:
    """`start` with the linear parameters of least free-run error inside the certified set."""
    structure = structure_of(start)
    one_step = information(record, structure, settings.weighting(trust, None))
    lag, gain = float(start.consequents[0, 0]), float(start.consequents[0, 1])
    # A slow lag sampled fast has a slope next to 1; the rules may use half of what is left.
    limit = max(settings.slope_limit, 0.5 * (1.0 + lag))
    allowed = certified_set(structure, gain, limit)
    error = free_run_error(record, structure, settings.settle, trust).penalised(start, one_step)
    return refine(start, error, allowed, settings.iterations).model


def _rms_on(record: Record, model: Model, rows: NDArray[np.intp]) -> float:
    """rms error of the free run in um on `rows` of the joined segments."""
    runs = free_run(model, record)
    error = np.concatenate([run.y_um - s.y_um for run, s in zip(runs, record.segments, strict=True)])
    return float(np.sqrt(np.mean(error[rows] ** 2)))


@dataclass(frozen=True, eq=False)
class _Task:
    """A fit by least squares; one_step: the square-root information of the record."""

    record: Record
    settings: FitSettings
    structure: Structure
    weighting: Weighting
    one_step: Information


def _best_inside(
    task: _Task, allowed: CertifiedSet | None, progress: Progress | None
) -> tuple[Model, dict[str, object]]:
    """The model of least error in the set `allowed`, and the outcome for its history."""
    one_step, settings = task.one_step, task.settings
    start = one_step.solve()
    if allowed is not None:
        start = least_squares_inside(one_step.R, one_step.d, allowed.violated, np.zeros(start.size)).x
    model = _model(task.record, settings, task.structure, start)
    outcome: dict[str, object] = {}
    if allowed is not None:
        outcome["least_squares_certified"] = allowed.violated(one_step.solve()).floor.size == 0
    if settings.method == "refined":
        trust, starts = task.weighting.trust, task.weighting.starts
        error = free_run_error(task.record, task.structure, settings.settle, trust, starts)
        error = error.penalised(model, one_step)
        before = error.criterion(model)
        refined = refine(model, error, allowed, settings.iterations, progress)
        model = refined.model
        outcome |= {
            "steps": refined.steps,
            "free_run_rms_um": {"least_squares": before.rms_um, "refined": refined.criterion.rms_um},
            "scored_weight": float(sum(weight[1:].sum() for weight in error.trust)),
        }
    return model, outcome


def linear_gain(structure: Structure, one_step: Information) -> float:
    """Gain b of the least-squares model with one rule, y(k+1) = a y(k) + b w(k) + c + theta . phi(k)."""
    rules = structure.grid.rules
    one = np.zeros((structure.size, 3))
    one[: 3 * rules] = np.tile(np.eye(3), (rules, 1))
    phi = np.eye(structure.size)[:, 3 * rules :]
    # Least squares under the constraint q = [one, phi] x.
    return float(np.linalg.lstsq(one_step.R @ np.hstack([one, phi]), one_step.d, rcond=None)[0][1])


def partition(record: Record, rules: int, margin: float = 0.0, at_least_um: tuple[float, float] | None = None) -> Grid:
    """Antecedent, Eqs (6) and (7): L rules, uniform over the range of y in all segments.

    at_least_um: a range that the grid contains in any case. margin: part of the range added at each end.
    Raises ModelError if the displacement is constant or the number of rules is not supported.
    """
    low, high = record.y_range_um
    if at_least_um is not None:
        low, high = min(low, at_least_um[0]), max(high, at_least_um[1])
    wider = margin * (high - low)
    return Grid(low - wider, high + wider, rules)


def structure_for(record: Record, settings: FitSettings) -> Structure:
    """The structure that `settings` define for this record: partition, input range, terms and blocks.

    Raises FitError if the record holds fewer pairs of samples than the structure has parameters.
    """
    u_min_V, u_max_V = settings.input_range_V or record.u_range_V
    grid = partition(record, settings.rules, settings.margin, settings.displacement_range_um)
    structure = Structure(grid, u_min_V, u_max_V, settings.terms, settings.blocks)
    pairs = record.samples - len(record.segments)
    if pairs < structure.size:
        raise FitError(
            f"{record.source}: {pairs} pairs of samples cannot determine {structure.size} parameters; "
            "choose fewer rules or terms, or record longer"
        )
    return structure


def _model(record: Record, settings: FitSettings, structure: Structure, parameters: Floats) -> Model:
    cut = 3 * structure.grid.rules
    return Model(
        name=settings.name,
        Ts_s=record.Ts_s,
        grid=structure.grid,
        consequents=parameters[:cut].reshape(-1, 3).copy(),
        u_min_V=structure.u_min_V,
        u_max_V=structure.u_max_V,
        terms=structure.terms,
        weights=parameters[cut:].copy(),
        blocks=structure.blocks,
        quantities=record.quantities,
    )


def _with_history(model: Model, record: Record, settings: FitSettings, outcome: dict[str, object]) -> Model:
    history = {
        "fit": settings.to_json(),
        "outcome": outcome,
        "record": {
            "source": record.source,
            "digest": record.digest,
            "samples": record.samples,
            "segments": len(record.segments),
            "fastest_V_per_s": fastest_V_per_s(record),
        },
    }
    return dataclasses.replace(model, history=history, certificates=certify(model).to_json())


def check_for_fit(record: Record, rules: int, parameters: int) -> tuple[str, ...]:
    """Refuse a record with too few samples for the model; return warnings, one line each, on poor excitation.

    rules: L of Eq. (1); the cell of a rule is the part of the range of y that is nearest to its centre, Eq. (6).
    parameters: number of all fitted coefficients, 3 L and those of the extensions.

    Warnings: rules with too few samples; coefficients that the record does not determine; equal swings of the voltage.
    Raises RecordError if there are fewer than 4 steps for each parameter.
    """
    if rules < 1 or parameters < 1:
        raise RecordError(f"{record.source}: {rules} rules with {parameters} parameters; choose at least one of each")
    wanted = max(parameters, 3 * rules)
    steps = record.samples - len(record.segments)
    if steps < PER_PARAMETER * wanted:
        raise RecordError(
            f"{record.source}: {record.samples} samples are too few for {rules} rules with {wanted} parameters "
            f"(at least {PER_PARAMETER * wanted + len(record.segments)}); record longer, or choose fewer rules"
        )
    return (*_cells(record, rules), *_alike(record))


def _cells(record: Record, rules: int) -> Iterator[str]:
    """Warnings on rules with few samples, and on rules in whose cell y is a function of u.

    A cell with samples determines the constant of its rule; the slope in y if y varies there; the slope in u if y is no
    function of u there:  rms(y - line in u) > max(0.03 s, min(3 noise, 0.7 s)),  s = rms(y - mean).
    The limit of 3 noise keeps noise from counting; 0.7 s is for fast signals, which the noise estimate takes for noise.
    """
    u = np.concatenate([segment.u_V[:-1] for segment in record.segments])
    y = np.concatenate([segment.y_um[:-1] for segment in record.segments])
    low, high = record.y_range_um
    noise = max(white_noise(segment.y_um) for segment in record.segments)
    step = (high - low) / max(rules - 1, 1) or 1.0
    cell = np.rint((y - low) / step).astype(np.intp) if rules > 1 else np.zeros(y.size, dtype=np.intp)
    count = np.bincount(cell, minlength=rules)

    def mean(values: Floats) -> Floats:
        return np.asarray(np.bincount(cell, values, minlength=rules) / np.maximum(count, 1))

    u = u - mean(u)[cell]
    y = y - mean(y)[cell]
    uu, yy, uy = mean(u * u), mean(y * y), mean(u * y)
    unexplained = yy - np.divide(uy * uy, uu, out=np.zeros(rules), where=uu > 0.0)
    poor = count < 3 * PER_PARAMETER
    moving = ~poor & (yy > 0.0)
    separate = moving & (uu > 0.0) & (unexplained > np.maximum(SEPARATE**2 * yy, np.minimum(9.0 * noise**2, 0.5 * yy)))
    if poor.any():
        shown = _listed(
            [f"{rule + 1} (y near {low + rule * step:.4g} um: {count[rule]})" for rule in np.flatnonzero(poor)]
        )
        yield (
            f"{record.source}: {np.count_nonzero(poor)} of {rules} rules see fewer than {3 * PER_PARAMETER} samples: "
            f"rule {shown}; choose fewer rules, or dwell there"
        )
    determined = int(np.count_nonzero(~poor) + np.count_nonzero(moving) + np.count_nonzero(separate))
    if determined < 3 * rules:
        together = _listed([str(rule + 1) for rule in np.flatnonzero(moving & ~separate)])
        because = f": voltage and displacement move as one in rules {together}" if together else ""
        yield (
            f"{record.source}: excitation tells about {determined} of {3 * rules} rule coefficients apart{because}; "
            "add nested amplitudes and other frequencies, or choose fewer rules"
        )


def _listed(words: list[str]) -> str:
    return ", ".join(words[:5]) + (f" and {len(words) - 5} more" if len(words) > 5 else "")


def _alike(record: Record) -> Iterator[str]:
    """A warning if the voltage has fewer than two full swings, or if all swings have one size and one duration."""
    low, high = record.u_range_V
    sizes: list[float] = []
    durations: list[float] = []
    turns = 0
    for segment in record.segments:
        rows = turning_rows(segment.u_V, 0.02 * (high - low))
        turns += rows.size
        # Swings before the first and after the last turning point are incomplete.
        sizes.extend(np.abs(np.diff(segment.u_V[rows])).tolist())
        durations.extend((np.diff(rows) * record.Ts_s).tolist())
    if len(sizes) < 2:
        yield (
            f"{record.source}: the voltage turns {turns} times; memory cannot be told from lag: "
            "drive several cycles of different size"
        )
    elif max(sizes) < 1.05 * min(sizes) and max(durations) < 1.2 * min(durations):
        yield (
            f"{record.source}: all {len(sizes)} swings of the voltage are alike ({np.median(sizes):.4g} V in "
            f"{np.median(durations):.4g} s); memory, lag and creep cannot be told apart: add other sizes and speeds"
        )
