"""The ladder: the Takagi-Sugeno model, extended cause by cause, and the gain of each rung on held-out rows.

    rung 0   the paper's model
    rung i   the model with the extensions of the first i causes, fitted again to the identification part

All rungs are scored in free run on the same rows, cold and by the model's own figure (`left_by`). The gain of a cause
is measured in the second, beside all others by cross-validation: it is the rise of the error if its extension is left
out, on each third of the blocks of the identification part, which in turn is left out of the fit and scored.

The gain of an extension depends on the extensions before it in the ladder: a delay in front of the memory may gain
nothing, and much behind it. Rungs that do not lower the error are therefore taken together with the next that does
(`joint_shares`). Held-out rows choose nothing.

Sources: Kuensch (1989), moving blocks; Politis and Romano (1992), circular blocks.

The form of each extension, such as the size of the hysteresis, chosen inside the identification part.

A cause may offer several forms of its extension (`Cause.forms`). Every form is fitted together with the other
extensions to two thirds of the blocks of the identification part and scored in free run on the remaining third, for
each third in turn. The cheapest form whose rms error is within TOLERATED of the least one is chosen.

Drift and aging are found jointly, and each takes a share of what the other would explain alone. A model that leaves one
of them out is extended by the others as they are without it.
"""

import dataclasses
import functools
import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hysgen.diagnosis.causes import Residual, causes, in_ladder_order, slow_causes, without_causes
from hysgen.diagnosis.extension import Extension, corrected, named_by
from hysgen.diagnosis.prepare import Prepared, predicted_range_um
from hysgen.diagnosis.probe import refine, rms
from hysgen.diagnosis.search import SearchResult, thinned
from hysgen.errors import FitError
from hysgen.fitting import (
    FitSettings,
    PathColumns,
    PathSize,
    fit,
    fit_path,
    known_past,
    path_columns,
    path_model,
    path_task,
)
from hysgen.machine.processes import in_processes
from hysgen.model.learner_settings import LearnerSettings
from hysgen.model.model import Model
from hysgen.model.remaining import Remaining, take_out
from hysgen.model.simulate import free_run
from hysgen.record import Record

Floats = NDArray[np.float64]
Rows = NDArray[np.intp]

CHECK_BLOCKS = 12
MOST_IN_TURN = 20_000
"""Rows above which only one third of the blocks is left out and scored."""

SLOPE_TO_LEARN = 0.995
"""Largest slope of a model with a learner: a commit accepts only parameters with a margin below 1."""


@dataclass(frozen=True, eq=False)
class Rung:
    """A model of the ladder and its free-run error over all rows, (n,)."""

    causes: tuple[str, ...]
    model: Model
    error_um: Floats


def fit_ladder(
    prepared: Prepared,
    extensions: dict[str, Extension],
    names: Sequence[str],
    settings: FitSettings,
    skip: Rows | None = None,
) -> Rung:
    """The model with the extensions of `names`, fitted to the identification part less the rows `skip`."""
    chosen = [extensions[name] for name in in_ladder_order(names)]
    replaced = [kind for e in chosen for kind in e.replaces]
    terms = tuple(e.term for e in chosen if e.term is not None and e.term.kind not in replaced)
    blocks = {e.block.place: e.block for e in chosen if e.block is not None and e.block.kind not in replaced}
    for first, *others in (e.in_place for e in chosen if e.in_place):
        blocks |= {block.place: block for block in (first, *others)} if first.place in blocks else {}
    trust = prepared.trust.copy()
    for extension in chosen:
        if extension.trust is not None:
            trust[: len(extension.trust)] *= extension.trust
    if skip is not None:
        trust[skip] = 0.0
    level = levelled(prepared, chosen)
    part = level if prepared.cut == prepared.record.samples else level.rows(0, prepared.cut)
    if any(extension.learns for extension in chosen):
        settings = dataclasses.replace(settings, slope_limit=min(settings.slope_limit, SLOPE_TO_LEARN))
    extended = dataclasses.replace(
        settings,
        terms=terms,
        blocks=tuple(blocks[place] for place in sorted(blocks)),
        settle=0,
        input_range_V=prepared.record.u_range_V,
        displacement_range_um=_model_range_um(prepared, level),
        past=next((extension.past for extension in chosen if extension.past is not None), None),
    )
    weights = _by_segment(trust, [s.samples for s in part.segments])
    if any(extension.on_path for extension in chosen):
        extended = dataclasses.replace(extended, memory=_size(chosen))
        problem = _path_problem(prepared, chosen, extended, level)
        weights = known_past(part, weights, extended.blocks)
        if skip is None:
            return _rung(names, fit_path(problem, extended, weights), level)
        # A cross-validation compares paths: the rules behind them stay one lag, and the record's own past is known.
        model, crept_um = path_model(problem, weights)
        rung = _rung(names, model, level)
        rung.error_um[: part.samples] += np.concatenate(crept_um)
        return rung
    try:
        model = fit(part, extended, trust=weights)
    except FitError:
        # If the certified fit fails, an uncertified fit still measures the gain of the extension.
        model = fit(part, dataclasses.replace(extended, certified=False), trust=weights)
    return _rung(names, model, level)


def _size(chosen: Sequence[Extension]) -> PathSize | None:
    """The size of the hysteresis, None for a curve; the model file keeps it, for a fit to another record."""
    # A later cause on the ladder, such as relaxation, may require another size than memory does.
    size = next((extension.size for extension in reversed(chosen) if extension.size is not None), None)
    relaxation = max(extension.relaxation for extension in chosen)
    return size if size is None or not relaxation else dataclasses.replace(size, relaxation=relaxation)


def _path_problem(prepared: Prepared, chosen: Sequence[Extension], settings: FitSettings, level: Record) -> PathColumns:
    """The path with the blocks of the chosen extensions over the identification part; a curve without memory."""
    lags_s = [extension.lag_s for extension in chosen if extension.lag_s is not None]
    part = level if prepared.cut == prepared.record.samples else level.rows(0, prepared.cut)
    task = path_task(part, dataclasses.replace(settings, lag_s=lags_s[0] if lags_s else None), level)
    content = (settings.rising, *(extension.content for extension in chosen))
    trust = _by_segment(prepared.trust, [s.samples for s in part.segments])
    return prepared.paths.get(content, lambda: path_columns(task, known_past(part, trust, settings.blocks)))


def _rung(names: Sequence[str], model: Model, level: Record) -> Rung:
    """The rung of a model, with its free-run error over all rows of the record without slow changes."""
    runs = free_run(model, level)
    error = np.concatenate([run.y_um - s.y_um for run, s in zip(runs, level.segments, strict=True)])
    return Rung(tuple(in_ladder_order(names)), model, error)


def left_by(
    prepared: Prepared,
    extensions: Mapping[str, Extension],
    error_um: Floats,
    beside: Remaining | None = None,
    finer: bool = False,
) -> Remaining:
    """What a model leaves of the held-out rows without what no model can know, as far as its extensions name it.

    error_um: (n,) yhat - y over all rows, of a model with these extensions. beside: as for `take_out`; a model
    that is not finer has nothing more taken out than that one.
    """
    record = levelled(prepared, list(extensions.values()))
    lengths = [segment.samples for segment in record.segments]
    held = np.isin(np.arange(record.samples), prepared.held_rows)
    measured = [segment.y_um for segment in record.segments]
    errors, scored = np.split(error_um, np.cumsum(lengths)[:-1]), np.split(held, np.cumsum(lengths)[:-1])
    named = named_by(extensions)
    if beside is not None and not finer:
        named = named.only({taken.cause for taken in beside.taken})
    return take_out(errors, measured, scored, record.Ts_s, named, beside)


def add_online_parts(model: Model, extensions: Sequence[Extension], span_s: float, noise_um: float) -> Model:
    """The model for operation: with terms that follow slow changes, and a learner if an extension requires one.

    span_s: length of the record. The added terms start at 0 and are constant in a free run, so no score changes.
    """
    corrections = [extension.correction for extension in extensions if extension.correction is not None]
    for term in (correction.online_term(model, span_s) for correction in corrections):
        if term is not None:
            model = dataclasses.replace(model, terms=(*model.terms, term), weights=np.append(model.weights, 1.0))
    if any(extension.learns for extension in extensions):
        settings = LearnerSettings(noise_um=max(noise_um, 1e-9))
        forgetting_s = min((e.forgetting_s for e in extensions if e.forgetting_s is not None), default=None)
        if forgetting_s is not None:
            kept = min(max(1.0 - model.Ts_s / forgetting_s, 0.9), 1.0 - 1e-7)
            settings = dataclasses.replace(settings, forgetting=kept, sliding=kept)
        model = dataclasses.replace(model, learner=settings)
    return model


def levelled(prepared: Prepared, extensions: Sequence[Extension]) -> Record:
    """The record without the slow changes of the displacement; their time counts from the start of each segment."""
    record = prepared.record
    corrections = [extension.correction for extension in extensions if extension.correction is not None]
    if not corrections:
        return record
    level = [corrected(segment, corrections, record.Ts_s) for segment in record.segments]
    return Record.from_segments(level, record.Ts_s, record.source)


def _model_range_um(prepared: Prepared, level: Record) -> tuple[float, float]:
    """Range of the grid: the union of the displacement ranges with and without the slow changes.

    The fit uses the levelled record; in operation, the model runs on the stage with its slow changes.
    """
    ranges = [prepared.predicted_range_um]
    if level is not prepared.record:
        ranges.append(predicted_range_um(level, prepared.training_rows, prepared.lag))
    return min(low for low, _ in ranges), max(high for _, high in ranges)


def left_out(prepared: Prepared) -> list[Rows]:
    """Thirds of 12 blocks of the identification part, each left out of one fit; one third of a long record."""
    rows = prepared.training_rows
    block = np.arange(len(rows)) * CHECK_BLOCKS // len(rows)
    thirds = [rows[block % 3 == third] for third in (1, 0, 2)]
    return thirds if len(rows) <= MOST_IN_TURN else thirds[:1]


def checked_errors(
    prepared: Prepared, models: Sequence[tuple[dict[str, Extension], Sequence[str]]], settings: FitSettings
) -> list[tuple[Rows, Floats]]:
    """Of each model, with the extensions of its names: rows of the identification part in order, and errors on them.

    The error of a row is that of the free run by a fit that left the row's block out. Computed once for `prepared`.
    """
    keys = [
        (tuple((name, extensions[name].content) for name in in_ladder_order(names)), settings)
        for extensions, names in models
    ]
    new = {key: model for key, model in zip(keys, models, strict=True) if key not in prepared.checked}
    found = in_processes(functools.partial(_checked, prepared, settings), new.values())
    of_new = dict(zip(new, found, strict=True))
    return [prepared.checked.get(key, functools.partial(of_new.__getitem__, key)) for key in keys]


def _checked(
    prepared: Prepared, settings: FitSettings, model: tuple[dict[str, Extension], Sequence[str]]
) -> tuple[Rows, Floats]:
    extensions, names = model
    parts = [
        (rows, fit_ladder(prepared, extensions, names, settings, rows).error_um[rows]) for rows in left_out(prepared)
    ]
    rows, errors = np.concatenate([rows for rows, _ in parts]), np.concatenate([error for _, error in parts])
    order = np.argsort(rows)
    return rows[order], errors[order]


def _by_segment(values: Floats, lengths: list[int]) -> list[Floats]:
    return np.split(values[: sum(lengths)], np.cumsum(lengths)[:-1])


BLOCKS = 24
DRAWS = 400

LEEWAY = 0.25
"""Largest excess of the confidence by the rms over the confidence by the geometric mean that is accepted."""


@dataclass(frozen=True)
class Gain:
    """Fall of the free-run rms from `before_um` to `after_um`.

    low_um, high_um: 95 % interval of the fall. confidence: share of bootstrap draws in which the rms falls.
    """

    before_um: float
    after_um: float
    low_um: float
    high_um: float
    confidence: float

    @property
    def fall_um(self) -> float:
        """Fall of the rms, negative if the rms rises."""
        return self.before_um - self.after_um


def gain(before_um: Floats, after_um: Floats, by: float = 0.0) -> Gain:
    """The gain between two errors, (n,) each, of the same consecutive samples.

    Its confidence is the share of draws in which the rms falls by more than the share `by`. A draw is 24 blocks of n/24
    samples, the same for both errors; the seed of the 400 draws is fixed.
    """
    n = len(before_um)
    length = max(1, n // BLOCKS)
    squares = [_block_means(error * error, length) for error in (before_um, after_um)]
    chosen = np.random.default_rng(1).integers(0, n, size=(DRAWS, BLOCKS))
    before, after = (np.sqrt(side[chosen].mean(axis=1)) for side in squares)
    falls = before - after
    low, high = np.quantile(falls, [0.025, 0.975])
    root = [float(np.sqrt(np.mean(error * error))) for error in (before_um, after_um)]
    return Gain(root[0], root[1], float(low), float(high), float(np.mean(falls > by * before)))


def blockwise_confidence(before_um: Floats, after_um: Floats, by: float = 0.0) -> float:
    """Share of 400 draws in which the geometric mean of the rms over 24 blocks falls by more than the share `by`.

    In contrast to the rms over all samples, the geometric mean is not dominated by one block with a large error, such
    as a block whose stroke is wider than every stroke that the model was fitted to.
    """
    parts = [np.array_split(error, BLOCKS) for error in (before_um, after_um)]
    levels = [np.log([float(np.mean(part * part)) + 1e-300 for part in side]) for side in parts]
    chosen = np.random.default_rng(1).integers(0, BLOCKS, size=(DRAWS, BLOCKS))
    return float(np.mean((levels[0] - levels[1])[chosen].mean(axis=1) > -2.0 * np.log1p(-by)))


def combined_confidence(before_um: Floats, after_um: Floats, by: float = 0.0) -> float:
    """Confidence that the error falls by more than the share `by`: max(g, min(r, g + LEEWAY)).

    g: `blockwise_confidence`. r: `Gain.confidence`. The geometric mean limits the weight of a block with a large error,
    but gives a block with a negligible error the same weight; the rms does the opposite.
    """
    blocks, power = blockwise_confidence(before_um, after_um, by), gain(before_um, after_um, by).confidence
    return max(blocks, min(power, blocks + LEEWAY))


def _block_means(values: Floats, length: int) -> Floats:
    """(n,) mean of the `length` values from each sample on; the series continues at its start."""
    sums = np.concatenate([[0.0], np.cumsum(np.concatenate([values, values[: length - 1]]))])
    return np.asarray((sums[length:] - sums[:-length]) / length)


def joint_shares(powers: Sequence[float], floor: float, alone: Sequence[float]) -> tuple[list[float], float]:
    """The share of each of m extensions in the first of m + 1 powers, and what is left of it; they add up to 1.

    Powers count by what they are above the floor, P_0 .. P_m; all shares are 0 if P_0 is not above it. With L_i =
    min(P_0, max of P_i .. P_m), a rung lowers the power by L_(i-1) - L_i. A rung that lowers nothing is taken together
    with the next that does, or with those before it at the end of the ladder: their fall is split in proportion to what
    each removes beside all others, alone: (m,).
    """
    above = np.maximum(np.asarray(powers) - floor, 0.0)
    if above[0] == 0.0:
        return [0.0] * len(alone), 0.0
    levels = np.minimum(1.0, np.maximum.accumulate(above[::-1])[::-1] / above[0])
    falls = -np.diff(levels)
    ends = np.flatnonzero(falls > 0.0) + 1
    found = np.zeros(len(alone))
    for first, end in itertools.pairwise([0, *ends.tolist()[:-1], len(alone)] if ends.size else [0]):
        weights = np.maximum(alone[first:end], 0.0) + 1e-300
        found[first:end] = falls[first:end].sum() * weights / weights.sum()
    return [float(part) for part in found], float(levels[-1])


TOLERATED = 1.1
"""Largest error of the chosen form, as a multiple of the least error of all forms: the next larger size of a hysteresis
costs about 1.5 times the cycles, and 10 % on left-out blocks is not worth that."""


def with_best_forms(
    prepared: Prepared, extensions: dict[str, Extension], names: Sequence[str], settings: FitSettings
) -> dict[str, Extension]:
    """The extensions, those of `names` in the form chosen by cross-validation. Forms are offered in rising cost."""
    best = dict(extensions)
    for name in in_ladder_order(names):
        forms = causes()[name].forms(best[name])
        if len(forms) < 2:
            continue
        trials = [{**best, name: form} for form in forms]
        checked = checked_errors(prepared, [(trial, names) for trial in trials], settings)
        levels_um = [rms(error_um[_trusted(best, names, rows)]) for rows, error_um in checked]
        best = next(t for t, level in zip(trials, levels_um, strict=True) if level <= TOLERATED * min(levels_um))
    return best


def _trusted(extensions: dict[str, Extension], names: Sequence[str], rows: Rows) -> NDArray[np.bool_]:
    """Which of the rows count: not those that the extension of a cause takes out of the fit as corrupted."""
    kept = np.ones(len(rows), dtype=bool)
    for trust in (extensions[name].trust for name in names):
        if trust is not None:
            kept &= trust[rows] > 0.0
    return kept


def extensions_for(
    found: SearchResult, extensions: Mapping[str, Extension], names: Sequence[str]
) -> dict[str, Extension]:
    """The extensions of a model with those of `names`; found: the search that they come from."""
    left = [name for name in slow_causes() if name in extensions and name not in names]
    slow = [name for name in slow_causes() if name in names and extensions[name].correction is not None]
    if not left or not slow:
        return dict(extensions)
    if len(left) == 1 and left[0] in found.rivals:
        fit = found.rivals[left[0]]
    else:
        fit = refine(thinned(found.scene), without_causes(found.fit.chain, left))
    without = Residual(found.scene, fit)
    return {**extensions, **{name: causes()[name].extension(without) for name in slow}}
