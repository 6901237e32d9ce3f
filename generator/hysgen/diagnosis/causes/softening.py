"""Softening: the frequency of modes falls with amplitude.

Hysteretic states in the loop of a mode soften and damp it (`model.path.loop`); a short-term amplitude that moves all
modes softens them alone (`model.path.softening`). The record decides which of the two it is.
"""

import dataclasses
import functools
from collections.abc import Mapping

import numpy as np
from scipy.signal import hilbert

from hysgen.diagnosis.causes.base import Cause, Effect, Estimate, Residual, Signature
from hysgen.diagnosis.causes.modes import StructurePart, identified, inputs_of, moving_channels
from hysgen.diagnosis.experiment import Piece
from hysgen.diagnosis.extension import Extension
from hysgen.diagnosis.probe import Chain, Fit, Trace
from hysgen.diagnosis.remedy import Advice, Motion, Seen, voltage_step
from hysgen.fitting.loop import identify_loop
from hysgen.fitting.softening import identify_softening
from hysgen.fitting.structure import ARX_ORDER, ModalForm, structure_parts
from hysgen.model.path.loop import Loop
from hysgen.model.path.modes import Modes
from hysgen.model.path.softening import Softening

NAMED = 3
"""Modes whose fall is told, the strongest ones."""

FALL = 1e-4
"""Share of a frequency whose effect is linear: less than the width of any mode."""


class SofteningCause(Cause):
    name = "softening"
    kind = "loop"
    rank = 62
    experiment = Piece.BAND
    changes = "resonance"

    def present(self, chain: Chain) -> bool:
        part = chain.get(StructurePart)
        return part is not None and part.linear is not None

    def without(self, chain: Chain) -> Chain:
        part = chain.get(StructurePart)
        if part is None or part.linear is None:
            return chain
        return chain.having(dataclasses.replace(part, form=part.linear, linear=None))

    def proposals(self, residual: Residual) -> list[Chain]:
        """The chain whose modes follow an amplitude, or of one drive have states in the loop; every run from rest."""
        chain, scene = residual.fit.chain, residual.scene
        rings = chain.modes or chain.get(StructurePart) is not None
        if not rings or self.present(chain) or not scene.complete:
            return []
        names = moving_channels(scene)
        ranges = tuple(scene.range_of(name) for name in names)
        part = _moving(scene.runs, names, ranges, scene.Ts_s) if names else _looped(scene.runs, scene.Ts_s)
        return [] if part is None else [chain.having(part)]

    def effect(self, residual: Residual) -> Effect:
        """Of modes whose frequencies fall by a share that grows with the amplitude of what the fall moves."""
        chain, seen = residual.fit.chain, residual.predicted
        moved = (seen(_slower(chain)) - seen(chain)) / FALL
        amplitude = np.abs(hilbert(moved))
        return Effect("of the frequency at the largest amplitude", moved * amplitude / amplitude.max(), most=1.0)

    def signature(self, residual: Residual, rival: Fit) -> Signature:
        """Frequencies of the modes for small and for large amplitudes, and the error without what moves them."""
        part = residual.fit.chain.of(StructurePart)
        if part.form.softening is not None and part.linear is not None:
            return _of_amplitude(part.form, part.form.softening, part.linear.rms_um / part.form.rms_um)
        form, loop = _form_of(residual)
        f_Hz, error_Hz, small_Hz = loop.f_Hz, float(form.f_error_Hz[0]), small_Hz_of(form, loop)
        states = len(loop.force)
        text = (
            f"the mode at {small_Hz:.4g} Hz falls to {f_Hz:.4g} +- {error_Hz:.1g} Hz as its amplitude grows: memory "
            f"inside the loop, {states} state{'s' if states > 1 else ''} that the displacement drives; the error is "
            f"{rival.rms_um / residual.fit.rms_um:.3g} times larger without"
        )
        z = abs(small_Hz - f_Hz) / max(error_Hz, 1e-15)
        return Signature(z, text, {"f_Hz": Estimate(f_Hz, error_Hz), "small_f_Hz": Estimate(small_Hz, error_Hz)})

    def advice(self, seen: Seen) -> Advice:
        f_Hz, small_Hz = seen.values["f_Hz"], seen.values["small_f_Hz"]
        return Advice(
            f"the mode at {small_Hz:.4g} Hz is at {f_Hz:.4g} Hz for large motion: a notch of one frequency misses it",
            f"a notch at least {abs(small_Hz - f_Hz):.2g} Hz wide, motion of one amplitude, or joints that do not "
            "slip: tighten clamps and preload",
        )

    def motion(self, values: Mapping[str, float], Ts_s: float) -> Motion:
        return voltage_step(12.0 / values["small_f_Hz"], Ts_s)

    def extension(self, residual: Residual) -> Extension:
        moving = residual.fit.chain.of(StructurePart).form.softening
        if moving is not None:
            return Extension(block=moving, replaces=("modes", "structure", "drives"), lag_s=moving.lag_s)
        form, loop = _form_of(residual)
        block, _ = structure_parts(form, {})
        return Extension(in_place=(block, loop), lag_s=block.lag_s)


def _slower(chain: Chain) -> Chain:
    """The chain whose modes are slower by the share FALL."""
    if (part := chain.get(StructurePart)) is None:
        modes = [dataclasses.replace(mode, f_Hz=(1.0 - FALL) * mode.f_Hz) for mode in chain.modes]
        return chain.having(Modes.of(modes, chain.lag_s))
    poles = part.form.poles * np.exp(-1j * FALL * np.angle(part.form.poles))
    return chain.having(dataclasses.replace(part, form=dataclasses.replace(part.form, poles=poles)))


def _of_amplitude(form: ModalForm, block: Softening, times: float) -> Signature:
    """The strongest modes that fall, at no amplitude and at the largest of the record, with their damping ratios."""
    strength = np.abs(form.gains).max(axis=1) / (1.0 - np.abs(form.poles)) ** 2
    small, large = block.natural(0.0), block.natural(form.amplitude)
    falls = [m for m in np.argsort(-strength, kind="stable").tolist() if large[0][m] < small[0][m]][:NAMED]
    texts, parameters, z = [], {}, 0.0
    for i, m in enumerate(sorted(falls, key=lambda m: float(small[0][m]))):
        suffix, error_Hz = "" if i == 0 else f"_{i + 1}", float(form.f_error_Hz[m])
        (small_Hz, small_zeta), (f_Hz, zeta) = ((float(f[m]), float(d[m])) for f, d in (small, large))
        parameters[f"small_f{suffix}_Hz"] = Estimate(small_Hz, error_Hz)
        parameters[f"f{suffix}_Hz"] = Estimate(f_Hz, error_Hz)
        texts.append(f"{small_Hz:.4g} to {f_Hz:.4g} Hz (damping ratio {small_zeta:.2g} to {zeta:.2g})")
        z = max(z, (small_Hz - f_Hz) / max(error_Hz, 1e-15))
    text = f"modes fall from {', '.join(texts)} as their short-term amplitude grows, {len(form.poles)} modes in all"
    return Signature(z, f"{text}; the error is {times:.3g} times larger if they stand still", parameters)


@functools.lru_cache(maxsize=1)
def _moving(
    runs: tuple[Trace, ...], names: tuple[str, ...], ranges: tuple[tuple[float, float], ...], Ts_s: float
) -> StructurePart | None:
    part = identified(runs, names, Ts_s)
    if part is None:
        return None
    inputs = [inputs_of(run, names) for run in runs]
    channels = dict(zip(names, ranges, strict=True))
    form = identify_softening(inputs, [run.y_um for run in runs], part.form, channels)
    return None if form is None else StructurePart(form, names, part.form)


@functools.lru_cache(maxsize=1)
def _looped(runs: tuple[Trace, ...], Ts_s: float) -> StructurePart | None:
    part = identified(runs, (), Ts_s)
    if part is None:
        return None
    form = identify_loop([run.u_V for run in runs], [run.y_um for run in runs], part.form, 8 * ARX_ORDER)
    return None if form is None else StructurePart(form, linear=part.form)


def _form_of(residual: Residual) -> tuple[ModalForm, Loop]:
    """The form of a chain that has the cause, and its states."""
    form = residual.fit.chain.of(StructurePart).form
    if form.loop is None:
        raise LookupError("the chain has no states in the loop of a mode")
    return form, form.loop


def small_Hz_of(form: ModalForm, loop: Loop) -> float:
    """Frequency of the mode for amplitudes at which every state is a spring, h = zeta = Re x: x <- lam x + e Re x."""
    step = form.poles[0] ** (1.0 / loop.parts)
    turn = np.array([[step.real + sum(loop.force), -step.imag], [step.imag + sum(loop.quadrature), step.real]])
    return float(np.abs(np.log(np.linalg.eigvals(turn).astype(complex))).max() * loop.parts / (2.0 * np.pi * form.Ts_s))
