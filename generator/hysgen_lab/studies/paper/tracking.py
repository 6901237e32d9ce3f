"""Section 4.3: open-loop tracking of y_d = 2.0 + 0.6 sin(2 pi f t) um by feed-forward through the inverse, Eq. (11).

The inverse runs as generated float32 C compiled on the host, with the bits of the DSP. The reference stays at 2.0 um
before the sine starts. The first period is not scored, because the hysteresis still depends on the identification run.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hysgen.checking.host import Host
from hysgen.codegen import generate
from hysgen.model.model import Model
from hysgen.model.rivals import fit_proportional
from hysgen_lab.stage import signals
from hysgen_lab.studies.paper.bench import IDENTIFICATION_SEED, TRACKING_SEED, TS_S, Variant, identify, measure

Floats = NDArray[np.float64]

REST_S = 0.05
PERIODS = 6


@dataclass(frozen=True)
class PublishedTracking:
    """Errors printed in the paper, with the inverse: e_rms in nm, maximum e_r in percent; proportional: maximum e_r."""

    e_rms_nm: float
    e_r_percent: float
    proportional_percent: float = 18.0


@dataclass(frozen=True)
class Tracking:
    """Tracking at one frequency over the scored samples: reference (n,), reached displacement (n,) by controller."""

    f_Hz: float
    published: PublishedTracking
    t_s: Floats
    reference_um: Floats
    reached_um: Mapping[str, Floats]

    @property
    def e_rms_nm(self) -> dict[str, float]:
        """sqrt(mean (y_d - y)^2) in nm, by controller."""
        return {
            name: 1e3 * float(np.sqrt(np.mean((self.reference_um - y) ** 2))) for name, y in self.reached_um.items()
        }

    @property
    def e_r_percent(self) -> dict[str, float]:
        """max |y_d - y| / max y in percent, by controller."""
        return {
            name: 100.0 * float(np.abs(self.reference_um - y).max() / y.max()) for name, y in self.reached_um.items()
        }

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values."""
        return {
            "f_Hz": self.f_Hz,
            "published": vars(self.published),
            "e_rms_nm": self.e_rms_nm,
            "e_r_percent": self.e_r_percent,
        }


@dataclass(frozen=True)
class TrackingCase:
    """Frequency of the reference, identification signal of the model as in the paper, errors measured in the paper."""

    f_Hz: float
    identification: Callable[[], Floats]
    published: PublishedTracking


CASES = (
    TrackingCase(50.0, lambda: signals.fig8(TS_S, "identification"), PublishedTracking(18.6, 3.14)),
    TrackingCase(100.0, lambda: signals.fig5(TS_S, "identification"), PublishedTracking(15.2, 2.91)),
)


def track_case(case: TrackingCase) -> Tracking:
    """Track one frequency by the proportional law and by the inverses of the paper's, refined and extended models."""
    f_Hz, identification_V = case.f_Hz, case.identification()
    known = measure(identification_V, IDENTIFICATION_SEED, "identification")
    sine_um = signals.tracking_reference(TS_S, f_Hz, PERIODS / f_Hz)
    # One sample more than is scored: the inverse at sample k needs y_d(k+1).
    reference_um = np.concatenate([np.full(round(REST_S / TS_S), sine_um[0]), sine_um])
    drives_V = {"proportional": fit_proportional(known).inverse(reference_um[:-1])}
    variants: dict[Variant, str] = {"paper": "paper's inverse", "refined": "refined inverse", "memory": "with memory"}
    for variant, label in variants.items():
        drives_V[label] = inverse_drive(identify(known, variant), reference_um)
    scored = slice(reference_um.size - sine_um.size + round(1.0 / (f_Hz * TS_S)), reference_um.size - 1)
    reached: dict[str, Floats] = {}
    for name, u_V in drives_V.items():
        tracked = measure(u_V, TRACKING_SEED, "tracking", before_V=identification_V)
        reached[name] = tracked.segments[0].y_um[scored]
    t_s: Floats = TS_S * np.arange(scored.stop - scored.start, dtype=np.float64)
    return Tracking(f_Hz, case.published, t_s, reference_um[scored], reached)


def inverse_drive(model: Model, reference_um: Floats) -> Floats:
    """Voltages (n-1,) of Eq. (11) along a reference (n,), computed by the model's generated C on the host."""
    host = Host(model.name, generate(model))
    bits = reference_um.astype(np.float32).view(np.uint32)
    start_V = 0.5 * (model.u_min_V + model.u_max_V)
    instance = host.instance(float(reference_um[0]), start_V)
    u_bits, _ = host.run("inverse", instance, [bits[:-1], bits[1:]])
    return u_bits.view(np.float32).astype(np.float64)
