"""Softening: the frequency of a mode falls with amplitude, because hysteresis sits in its loop."""

from __future__ import annotations

import dataclasses
import functools

import numpy as np

from hysgen.diagnosis.causes.base import Cause, Estimate, Residual, Signature
from hysgen.diagnosis.causes.resonance import StructurePart, identified, moving_channels
from hysgen.diagnosis.experiment import Piece
from hysgen.diagnosis.extension import Extension
from hysgen.diagnosis.probe import Chain, Fit, Trace
from hysgen.fitting.loop import identify_loop
from hysgen.fitting.structure import ARX_ORDER, ModalForm, structure_parts
from hysgen.model.path.loop import Loop


class SofteningCause(Cause):
    name = "softening"
    kind = "loop"
    rank = 62
    experiment = Piece.BAND

    def present(self, chain: Chain) -> bool:
        part = chain.get(StructurePart)
        return part is not None and part.states > 0

    def without(self, chain: Chain) -> Chain:
        part = chain.get(StructurePart)
        if part is None or part.linear is None:
            return chain
        return chain.having(dataclasses.replace(part, form=part.linear, linear=None))

    def proposals(self, residual: Residual) -> list[Chain]:
        """The chain whose resonance has states in its loop, from rest; of the command alone, for what it drives."""
        chain, scene = residual.fit.chain, residual.scene
        rings = chain.modes or chain.get(StructurePart) is not None
        if not rings or self.present(chain) or not scene.complete or moving_channels(scene):
            return []
        part = _looped(scene.runs, scene.Ts_s)
        return [] if part is None else [chain.having(part)]

    def signature(self, residual: Residual, rival: Fit) -> Signature:
        """Both frequencies of the mode, for small and for large amplitudes, and the error without the states."""
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

    def extension(self, residual: Residual) -> Extension:
        form, loop = _form_of(residual)
        block, _ = structure_parts(form, {})
        return Extension(in_place=(block, loop), lag_s=block.lag_s)


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


CAUSE = SofteningCause()
