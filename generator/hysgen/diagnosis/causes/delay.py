"""Delay: the output is late by whole or fractional samples; its phase grows with frequency, its amplitude does not."""

from __future__ import annotations

import dataclasses

from hysgen.diagnosis.causes.base import Cause, Effect, Estimate, Residual, Signature
from hysgen.diagnosis.excitation import Excitation
from hysgen.diagnosis.experiment import Piece
from hysgen.diagnosis.probe import Chain, Fit, standard_errors
from hysgen.model.path.delay import LEAST_FITTED, MOST_FITTED, Delay


class DelayCause(Cause):
    name = "delay"
    rank = 30
    experiment = Piece.RATES
    mistaken_for = ("resonance",)
    part = Delay

    def requirement(self, seen: Excitation) -> tuple[bool, str]:
        wide = seen.highest_Hz > 3.0 * max(seen.lowest_Hz, 1e-12)
        alike = "; lag and delay look alike at one frequency: drive a decade"
        return wide, f"{seen.lowest_Hz:.3g} to {seen.highest_Hz:.3g} Hz" + ("" if wide else alike)

    def proposals(self, residual: Residual) -> list[Chain]:
        chain, Ts_s = residual.fit.chain, residual.scene.Ts_s
        if self.present(chain):
            return []
        # The fitted lag contains the delay; the starting values divide the lag between lag and delay in several ratios.
        candidates = []
        for share in (0.1, 0.4, 0.8):
            late = share * chain.lag_s / Ts_s
            if LEAST_FITTED < late < MOST_FITTED:
                candidates.append(dataclasses.replace(chain.having(Delay(late)), lag_s=(1.0 - share) * chain.lag_s))
        candidates.append(chain.having(Delay(0.5)))
        return candidates

    def effect(self, residual: Residual) -> Effect:
        late = residual.changed_by(residual.fit.chain.having(Delay(1.0)))
        return Effect("samples", late, most=MOST_FITTED)

    def signature(self, residual: Residual, rival: Fit) -> Signature:
        """The delay divided by its standard error; lag, modes and hysteresis are fitted jointly with the delay."""
        late = residual.fit.chain.delay
        error = standard_errors(residual.scene, residual.fit).coordinates["delay.samples"]
        z = late / max(error, 1e-12)
        return Signature(
            z=z,
            text=f"phase grows with frequency at constant gain: {late:.2f} +- {error:.2f} samples late",
            parameters={"delay_samples": Estimate(late, error)},
        )


CAUSE = DelayCause()
