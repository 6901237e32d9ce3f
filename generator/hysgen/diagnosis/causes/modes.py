"""Resonance: a lightly damped mode that oscillates at its own frequency for every input."""

import dataclasses
import functools
import math
from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar, Final

import numpy as np
from numpy.typing import NDArray

from hysgen.diagnosis.causes.base import Cause, Effect, Estimate, Residual, Signature
from hysgen.diagnosis.experiment import Piece
from hysgen.diagnosis.extension import Extension
from hysgen.diagnosis.probe import (
    Chain,
    Extent,
    Fit,
    Mode,
    Part,
    RunSignals,
    Scene,
    Trace,
    TrainingFit,
    standard_errors,
)
from hysgen.diagnosis.remedy import Advice, Motion, Seen, voltage_step
from hysgen.errors import FitError
from hysgen.fitting.structure import ModalForm, identify_structure, structure_parts
from hysgen.model.path.modes import MODE, Modes
from hysgen.model.remaining import LEAST_EVIDENCE

Floats = NDArray[np.float64]

PER_DECADE = 45
"""Grid frequencies per decade; the responses of two modes half a step apart stay alike until they have decayed."""

DAMPINGS = (0.03, 0.12)
APART, MOST_STARTS = 0.25, 6
"""Least distance of two proposed modes of one damping, in ln(f), and their number."""

OTHER_LAGS = (0.3, 3.0, 30.0)
"""Lags in samples from which a first mode starts, beside that of the chain."""

EARLIEST = 0.25
"""Starting value of the time by which modes are seen early, in samples."""

MOST_MODES = 3
KNOWN = 5e-3
"""Largest standard error of a frequency that is named, as a share of it: a fraction of the width of a light mode."""


CERTAIN: Final = math.sqrt(LEAST_EVIDENCE)
"""Least half-width of a mode in standard errors of its frequency, as rare in a Gaussian as a wrong name."""


@dataclass(frozen=True)
class StructurePart(Part):
    """The motion of an identified structure, whose inputs are the command and `channels`, as one column.

    linear: the form whose modes do not move with amplitude, if those of the form do: the part of the cause `softening`.
    """

    cause: ClassVar[str] = "resonance"
    place: ClassVar[int] = 50
    form: ModalForm
    channels: tuple[str, ...] = ()
    linear: ModalForm | None = None

    @property
    def states(self) -> int:
        """Number of the hysteretic states in the loop of a mode."""
        return 0 if self.form.loop is None else len(self.form.loop.force)

    @property
    def names(self) -> tuple[str, ...]:
        return (*super().names, *(f"state {r}" for r in range(self.states)))

    @property
    def added(self) -> int:
        return 1

    @property
    def weight_orders(self) -> float:
        # A pole has a frequency, of order 3. What an amplitude moves was decided by rows that its fit left out.
        form = self.linear if self.form.softening and self.linear else self.form
        return 4.0 * (form.poles.size + self.states) + 2.0 * form.gains.size

    def apart(self, runs: Sequence[RunSignals], Ts_s: float) -> bool:
        return True  # what other drives and many modes move differs from pass to pass

    def columns(self, run: RunSignals, extent: Extent, seen: Callable[[Floats], Floats]) -> list[Floats]:
        return [self.form.simulate(inputs_of(run, self.channels))]

    def columns_depend_on(self, lag_s: float, delay: float) -> Hashable:
        return self.form


class ResonanceCause(Cause):
    name = "resonance"
    kind = "modes"
    rank = 60
    experiment = Piece.BAND
    part = Modes
    starts = 3  # slow misfit can favour a wrong mode; a refinement does not cross the true damping ratio

    def admissible(self, scene: Scene, fit: Fit) -> bool:
        """Whether the motion drives each mode with the power of what rang before the record, and one has a known place.

        The columns of the ringing cost no order: a mode that only rings is a line, which nothing drives. Peaks of which
        none has a place known within its own half-width describe what a lag and the hysteresis miss behind fast moves;
        a share says less, because the lag changes with it.
        """
        chain = fit.chain
        residual, ringing = Residual(scene, fit), scene.added_columns(chain)[chain.first_column(Modes) :]
        for i, fewer in enumerate(self.without_one_part(chain) if chain.modes else ()):
            at = scene.column_of(chain, Modes) + 2 * i
            rung = fit.weights[at : at + 2] @ ringing[2 * i : 2 * i + 2][:, scene.rows]
            driven = residual.changed_by(fewer)[scene.rows]
            if float(driven @ driven) < float(rung @ rung):
                return False
        if not chain.modes:
            return True
        errors = standard_errors(scene, fit).coordinates
        return any(mode.zeta >= CERTAIN * errors[f"resonance.{i}.f_Hz"] for i, mode in enumerate(chain.modes))

    def without_one_part(self, chain: Chain) -> list[Chain]:
        modes = chain.modes
        fewer = [modes[:i] + modes[i + 1 :] for i in range(len(modes))]
        return [chain.having(Modes.of(less, chain.lag_s)) for less in fewer if less] or [self.without(chain)]

    def simpler_forms(self, chain: Chain) -> list[Chain]:
        """Modes that are not seen early."""
        modes = chain.get(Modes)
        if modes is None or modes.early_s is None:
            return []
        return [chain.having(dataclasses.replace(modes, early_s=None))]

    def proposals(self, residual: Residual) -> list[Chain]:
        """The six modes of a grid whose responses explain most of the residual, one at a time, and two at once.

        Of two strong modes, one alone may lower the error too little for a step of the search.
        """
        chain, scene = residual.fit.chain, residual.scene
        if chain.get(StructurePart) is not None:
            return []
        structure = _structure(scene, len(chain.modes))
        whole = [] if structure is None else [chain.having(structure)]
        modes = chain.get(Modes)
        if modes is not None and modes.early_s is None:
            whole.append(chain.having(dataclasses.replace(modes, early_s=EARLIEST * scene.Ts_s)))
        if len(chain.modes) >= MOST_MODES:
            return whole
        exact = [] if structure is None or chain.modes else _light_modes(structure.form)
        grid = [*exact, *(Mode(f_Hz, zeta, 1.0) for zeta in DAMPINGS for f_Hz in _grid_Hz(residual))]
        bare = residual.responses(self.without(chain))
        rings = np.empty((len(grid), len(scene.rows)))
        for i, mode in enumerate(grid):
            single = residual.responses(chain.having(Modes.of([mode], chain.lag_s)))
            ring = [seen - stiff for seen, stiff in zip(single, bare, strict=True)]
            rings[i] = np.concatenate(ring)[scene.rows]
        rings = residual.projector.orthogonal_part(rings)
        error = residual.projector.orthogonal_part(residual.fit.error[scene.rows])
        chosen: list[Mode] = []
        for mode in _by_power(grid, rings, error):
            if all(mode.zeta != one.zeta or abs(math.log(mode.f_Hz / one.f_Hz)) > APART for one in chosen):
                chosen.append(mode)
            if len(chosen) == MOST_STARTS:
                break
        sets: list[tuple[Mode, ...]] = [(mode,) for mode in chosen]
        if len(chain.modes) + 2 <= MOST_MODES:
            first = rings[grid.index(dataclasses.replace(chosen[0], share=1.0))]
            first = first / (np.linalg.norm(first) + 1e-300)
            beside = rings - np.outer(rings @ first, first)
            others = _by_power(grid, beside, error - (error @ first) * first)
            sets.append((chosen[0], next(one for one in others if abs(math.log(one.f_Hz / chosen[0].f_Hz)) > APART)))
        if exact:
            # The modes of the structure alone: it is linear, and may hold what hysteresis behind its modes moves.
            shares = np.linalg.lstsq(rings[: len(exact)].T, error)[0].clip(-1.0, 1.0).tolist()
            sets.append(tuple(dataclasses.replace(m, share=share) for m, share in zip(exact, shares, strict=True)))
        proposed = [chain.having(Modes.of((*chain.modes, *more), chain.lag_s)) for more in sets]
        return whole + (proposed if chain.modes else proposed + _with_other_lags(chain, chosen[0], scene.Ts_s))

    def select_starts(self, candidates: list[TrainingFit]) -> list[TrainingFit]:
        """The best proposals of one more mode, and that of modes that are seen early: it starts from a guess."""
        early = [one for one in candidates if any(mode.early_s for mode in one.chain.modes)]
        return [*early[:1], *(one for one in candidates if one not in early[:1])][: self.starts + len(early[:1])]

    def effect(self, residual: Residual) -> Effect:
        """Of a mode at a twentieth of the sampling rate."""
        f_Hz = 0.05 / residual.scene.Ts_s
        chain = residual.fit.chain
        rings = residual.changed_by(chain.having(Modes((f_Hz,), (0.03,), (1.0,), chain.lag_s)))
        return Effect(f"of the motion, for a mode at {f_Hz:.3g} Hz", rings, most=3.0)

    def signature(self, residual: Residual, rival: Fit) -> Signature:
        """Frequency, damping ratio and share of each mode with standard errors."""
        chain = residual.fit.chain
        part = chain.get(StructurePart)
        if part is not None:
            return _signature_of(part.form, part.channels)
        errors = standard_errors(residual.scene, residual.fit).coordinates
        parameters, texts = {}, []
        for i, mode in enumerate(chain.modes):
            suffix = "" if i == 0 else f"_{i + 1}"
            df, dz, ds = (errors[f"resonance.{i}.{one.field}"] for one in MODE)
            parameters[f"f{suffix}_Hz"] = Estimate(mode.f_Hz, mode.f_Hz * df)
            parameters[f"zeta{suffix}"] = Estimate(mode.zeta, mode.zeta * dz)
            parameters[f"share{suffix}"] = Estimate(mode.share, ds)
            texts.append(f"rings at {mode.f_Hz:.4g} Hz with damping ratio {mode.zeta:.3g}, share {mode.share:.2g}")
        early = chain.of(Modes).early_s
        if early is not None:
            parameters["early_s"] = Estimate(early, errors["resonance.early_s"])
            texts.append(f"the sensor sees it {1e6 * early:.3g} us before the end of the sample")
        z = min(abs(m.share) / max(errors[f"resonance.{i}.share"], 1e-15) for i, m in enumerate(chain.modes))
        return Signature(z, "; ".join(texts), parameters)

    def advice(self, seen: Seen) -> Advice:
        f_Hz, zeta = seen.values["f_Hz"], seen.values["zeta"]
        rings_s = math.log(50.0) / (2.0 * math.pi * zeta * f_Hz)
        return Advice(
            f"a step rings at {f_Hz:.4g} Hz for {1e3 * rings_s:.3g} ms, until 2 % of the ringing is left; at this "
            f"frequency the stage answers {0.5 / zeta:.3g} times as strongly",
            f"no edges shorter than {1e3 / f_Hz:.2g} ms (hysgen waveform), a notch there (hysgen loop), a stiffer "
            f"mount or less load; with a damping ratio of 0.1 it would ring for {1e3 * rings_s * zeta / 0.1:.2g} ms",
        )

    def motion(self, values: Mapping[str, float], Ts_s: float) -> Motion:
        return voltage_step(12.0 / values["f_Hz"], Ts_s)

    def extension(self, residual: Residual) -> Extension:
        part = residual.fit.chain.get(StructurePart)
        if part is None:
            return super().extension(residual)
        block, term = structure_parts(
            part.linear or part.form, {name: residual.scene.range_of(name) for name in part.channels}
        )
        return Extension(block=block, term=term, lag_s=block.lag_s)


def _structure(scene: Scene, modes: int) -> StructurePart | None:
    """The structure that the record shows: where other channels move, or MOST_MODES modes are not enough.

    None for an excerpt of a record, whose runs do not begin at rest, and for a record that is too short.
    """
    channels = moving_channels(scene)
    if not scene.complete or not (channels or modes >= MOST_MODES):
        return None
    return identified(scene.runs, channels, scene.Ts_s)


def moving_channels(scene: Scene) -> tuple[str, ...]:
    """The other channels that move in every run."""
    names = scene.runs[0].aux
    return tuple(name for name in names if all(float(np.ptp(run.aux[name])) > 0.0 for run in scene.runs))


def inputs_of(run: RunSignals, channels: Sequence[str]) -> Floats:
    """(M, n) the command, and the channels behind it."""
    return np.stack([run.u_V, *(run.aux[name] for name in channels)])


@functools.lru_cache(maxsize=1)
def identified(runs: tuple[Trace, ...], channels: tuple[str, ...], Ts_s: float) -> StructurePart | None:
    """The structure that command and channels excite; None for runs that are too short."""
    inputs = [inputs_of(run, channels) for run in runs]
    try:
        form = identify_structure(inputs, [run.y_um for run in runs], Ts_s)
    except FitError:
        return None
    return StructurePart(form, channels)


def _light_modes(form: ModalForm) -> list[Mode]:
    """At most MOST_MODES of the known modes, the lightest first."""
    lightest = _known(form, form.zeta)[:MOST_MODES]
    return [Mode(float(form.f_Hz[m]), float(form.zeta[m]), 1.0) for m in lightest]


def _known(form: ModalForm, by: Floats) -> list[int]:
    """The modes whose frequency is known to KNOWN of it, in rising order of one of their numbers."""
    known = np.flatnonzero(form.f_error_Hz < KNOWN * form.f_Hz)
    order: list[int] = known[np.argsort(by[known], kind="stable")].tolist()
    return order


def _signature_of(form: ModalForm, channels: Sequence[str]) -> Signature:
    """Each mode of a structure whose frequency is known to KNOWN of it, in rising order."""
    order = _known(form, form.f_Hz)
    parameters, texts = {}, []
    for i, m in enumerate(order):
        suffix = "" if i == 0 else f"_{i + 1}"
        parameters[f"f{suffix}_Hz"] = Estimate(float(form.f_Hz[m]), float(form.f_error_Hz[m]))
        parameters[f"zeta{suffix}"] = Estimate(float(form.zeta[m]), float(form.zeta_error[m]))
        texts.append(f"{form.f_Hz[m]:.4g} +- {form.f_error_Hz[m]:.1g} Hz (damping ratio {form.zeta[m]:.3g})")
    broad = len(form.poles) - len(order)
    drives = f", driven by the command and by {', '.join(channels)}" if channels else ""
    text = f"rings at {', '.join(texts)}{drives}" + (f"; {broad} broad or slow states beside them" if broad else "")
    z = min((float(form.f_Hz[m] / max(form.f_error_Hz[m], 1e-15)) for m in order), default=0.0)
    return Signature(z, text, parameters)


def _with_other_lags(chain: Chain, mode: Mode, Ts_s: float) -> list[Chain]:
    """Chains with a mode that carries half of the motion or all of it, behind the OTHER_LAGS.

    Beside a mode that rings as large as the motion, the lag of the chain without it is far off, and so is the share.
    """
    return [
        dataclasses.replace(chain.having(Modes((mode.f_Hz,), (mode.zeta,), (share,), chain.lag_s)), lag_s=lag * Ts_s)
        for lag in OTHER_LAGS
        for share in (0.5, 1.0)
    ]


def _grid_Hz(residual: Residual) -> list[float]:
    """Frequencies of the modes that are proposed."""
    scene = residual.scene
    low_Hz, high_Hz = 6.0 / scene.span_s, 0.45 / scene.Ts_s
    # From a fiftieth of the corner frequency of the lag on; without the mode that rings, a fit may take the lag away.
    lag_s = max(residual.fit.chain.lag_s, scene.Ts_s)
    low_Hz = max(low_Hz, 0.02 / (2 * math.pi * lag_s), 1e-3 * high_Hz)
    count = max(20, int(PER_DECADE * math.log10(high_Hz / low_Hz)))
    frequencies: list[float] = np.geomspace(low_Hz, high_Hz, count).tolist()
    return frequencies


def _by_power(grid: Sequence[Mode], rings: Floats, error: Floats) -> list[Mode]:
    """The modes with their shares, those first that explain most of `error`, (n,); rings: (len(grid), n) responses."""
    powers = np.einsum("ij,ij->i", rings, rings) + 1e-300
    shares = rings @ error / powers
    order = np.argsort(-(shares**2) * powers, kind="stable")
    return [dataclasses.replace(grid[i], share=float(np.clip(shares[i], -1.0, 1.0))) for i in order.tolist()]
