"""What must hold before C is handed out: the certificates of the inverse, and the budget of a sample period."""

from __future__ import annotations

from collections.abc import Mapping

from hysgen.certify.certificates import Certificates, least_stable
from hysgen.codegen.operations.cycles import BESIDES, CLOCK_HZ, STEPS, Cycles, budget, per_sample
from hysgen.errors import BudgetError, CertificateError
from hysgen.model.model import Model


def require_inverse(model: Model, certificates: Certificates) -> None:
    """Raise CertificateError, with place and value, where Eq. (11) of `model` is singular or unstable in its range."""
    cure = "restrict the range (generate --displacement-range), or generate without the inverse"
    if not certificates.gain_holds:
        low, high = certificates.gain_lowest, certificates.gain_highest
        worst = low if abs(low.value) <= abs(high.value) or low.value * high.value < 0.0 else high
        raise CertificateError(
            f"{model.name}: the gain df/du is {worst.value:.4g} um/V at y = {worst.y_um:.4g} um and "
            f"{high.value:.4g} um/V at y = {high.y_um:.4g} um, so the inverse is singular or nearly so; {cure}"
        )
    if not certificates.inverse_holds:
        y_um, gain_um_per_V = least_stable(model, certificates.gain_lowest.value, certificates.gain_highest.value)
        raise CertificateError(
            f"{model.name}: the inverse is not certified stable (zeros within {certificates.zero:.4g}, loop gain of "
            f"its nonlinear terms {certificates.loop:.4g}; both must be below 1), least so at y = {y_um:.4g} um, where "
            f"the gain is {gain_um_per_V:.4g} um/V: past inputs may build up; {cure}"
        )


def require_budget(model: Model, cycles: Mapping[str, Cycles], clock_Hz: float = CLOCK_HZ) -> None:
    """Raise BudgetError, with the numbers, where one sample takes longer than the sample period."""
    allowed, needed = budget(model.Ts_s, clock_Hz), per_sample(cycles)
    if needed.value > allowed:
        parts = ", ".join(f"{name} {cycles[name].value}" for name in (*STEPS, *BESIDES) if name in cycles)
        raise BudgetError(
            f"{model.name}: one sample takes {needed} ({parts}), the period of {1e6 * model.Ts_s:.4g} us has {allowed} "
            f"at {clock_Hz / 1e6:.4g} MHz; fewer parameters, a learner spread over more calls, or a longer period"
        )
