"""The budget of an uncertainty after JCGM 100:2008 (GUM), and the uncertainty of the displacement sensor.

    u_c^2 = sum_i (c_i u_i)^2,    nu_eff = u_c^4 / sum_i (c_i u_i)^4 / nu_i,    U = k u_c,    k = t_p(nu_eff)

Eqs (10), (G.2b) and (G.1d) there; contributions are independent, the measurand is linear in them.
"""

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final, Literal

import numpy as np
from scipy.special import stdtrit

from hysgen.display import decimal
from hysgen.errors import HysgenError

COVERAGE: Final = 0.95
Shape = Literal["normal", "rectangular"]


@dataclass(frozen=True)
class Contribution:
    """One input of the budget.

    standard_um: standard uncertainty u_i in um. evaluation: "A" from observations, "B" from other knowledge.
    freedom: degrees of freedom nu_i. sensitivity: c_i. about: where the value comes from.
    """

    name: str
    standard_um: float
    evaluation: Literal["A", "B"]
    about: str
    freedom: float = math.inf
    sensitivity: float = 1.0
    shape: Shape = "normal"

    @property
    def contribution_um(self) -> float:
        """|c_i| u_i."""
        return abs(self.sensitivity) * self.standard_um


@dataclass(frozen=True)
class Budget:
    """Contributions to one measurand and their combination. coverage: probability of the expanded interval."""

    measurand: str
    contributions: tuple[Contribution, ...]
    coverage: float = COVERAGE

    @property
    def combined_um(self) -> float:
        """u_c."""
        return math.sqrt(math.fsum(c.contribution_um**2 for c in self.contributions))

    @property
    def freedom(self) -> float:
        """Effective degrees of freedom after Welch and Satterthwaite; infinity if no contribution limits them."""
        spread = math.fsum(c.contribution_um**4 / c.freedom for c in self.contributions)
        return self.combined_um**4 / spread if spread > 0.0 else math.inf

    @property
    def factor(self) -> float:
        """Coverage factor k, two-sided, of Student's t with nu_eff truncated to an integer as in G.4.1."""
        freedom = self.freedom
        whole = max(1.0, math.floor(freedom)) if math.isfinite(freedom) else 1e12
        return float(stdtrit(whole, 0.5 + 0.5 * self.coverage))

    @property
    def expanded_um(self) -> float:
        """U = k u_c."""
        return self.factor * self.combined_um

    def rows(self) -> list[list[str]]:
        """Cells: name, evaluation, standard uncertainty [um], degrees of freedom, share of u_c^2, source."""
        total = self.combined_um**2
        return [
            [
                c.name,
                c.evaluation,
                decimal(c.contribution_um, 3),
                "inf" if math.isinf(c.freedom) else f"{c.freedom:.0f}" if c.freedom >= 10.0 else f"{c.freedom:.2g}",
                f"{100.0 * c.contribution_um**2 / total:.1f} %" if total > 0.0 else "",
                c.about,
            ]
            for c in self.contributions
        ]

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values; infinite degrees of freedom are null."""
        return {
            "measurand": self.measurand,
            "contributions": [
                {
                    "name": c.name,
                    "standard_um": c.contribution_um,
                    "evaluation": c.evaluation,
                    "freedom": c.freedom if math.isfinite(c.freedom) else None,
                    "about": c.about,
                }
                for c in self.contributions
            ],
            "combined_um": self.combined_um,
            "freedom": self.freedom if math.isfinite(self.freedom) else None,
            "coverage": self.coverage,
            "k": self.factor,
            "expanded_um": self.expanded_um,
        }


def rectangular(name: str, half_um: float, about: str) -> Contribution:
    """A quantity anywhere within +- half_um with equal probability: u = half / sqrt(3)."""
    return Contribution(name, half_um / math.sqrt(3.0), "B", about, shape="rectangular")


def independent_samples(errors: Sequence[float]) -> float:
    """Number of independent samples in a correlated series: n / (1 + 2 sum rho_j), rho_j up to its first zero."""
    e = np.asarray(errors, dtype=np.float64)
    e = e - e.mean()
    n = e.size
    power = float(e @ e)
    if n < 3 or power <= 0.0:
        return float(max(n, 1))
    spectrum = np.abs(np.fft.rfft(e, 2 * n)) ** 2
    rho = np.fft.irfft(spectrum)[:n] / power
    below = np.flatnonzero(rho <= 0.0)
    last = int(below[0]) if below.size else n
    return float(max(1.0, n / (1.0 + 2.0 * float(rho[1:last].sum()))))


_UNITS_UM = {"m": 1e6, "mm": 1e3, "um": 1.0, "µm": 1.0, "nm": 1e-3, "pm": 1e-6}
_LENGTH = re.compile(r"([0-9.]+(?:[eE][+-]?\d+)?)\s*([a-zµ]+)")


@dataclass(frozen=True)
class SensorUncertainty:
    """Expanded uncertainty U and coverage factor k of the sensor; source: the text."""

    expanded_um: float
    k: float
    source: str

    @property
    def standard_um(self) -> float:
        """u = U / k."""
        return self.expanded_um / self.k


def length_um(text: str) -> float:
    """A length as `5nm` in um.

    >>> length_um("5 nm")
    0.005

    Raises HysgenError for another text.
    """
    match = _LENGTH.fullmatch(text.strip())
    if match is None or match[2] not in _UNITS_UM:
        raise HysgenError(f"'{text}' is not a length; write a number and one of {', '.join(_UNITS_UM)}, as 5nm")
    return float(match[1]) * _UNITS_UM[match[2]]


def sensor_uncertainty(text: str) -> SensorUncertainty:
    """`5nm,k=2`, or `5nm` (a standard uncertainty, k = 1). Raises HysgenError for another text."""
    length, comma, factor = text.partition(",")
    name, equals, value = factor.partition("=")
    if comma and (name.strip() != "k" or not equals):
        raise HysgenError(f"--sensor-uncertainty: '{text}' is not LENGTH,k=FACTOR; write 5nm,k=2")
    try:
        k = float(value) if comma else 1.0
    except ValueError:
        k = math.nan
    if not k > 0.0:
        raise HysgenError(f"--sensor-uncertainty: the coverage factor '{value}' is not a positive number; write k=2")
    return SensorUncertainty(length_um(length), k, f"stated: {text}")
