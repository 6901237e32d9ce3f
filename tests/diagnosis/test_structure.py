"""Modes that several drives excite are named with their frequencies, and the model that is delivered has them."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import cont2discrete, lfilter

from hysgen.codegen import generate
from hysgen.diagnosis import diagnose
from hysgen.record import Record, Segment

TS_S = 1.0 / 6400.0
F_HZ, ZETA = (641.0, 814.0, 1325.0, 2133.0), (0.010, 0.012, 0.008, 0.011)
SHAPES = ((0.6, -0.8), (-0.7, 0.9), (0.6, 0.6), (0.2, -0.5))


def segment(seed: int, samples: int) -> Segment:
    """Displacement of four modes under two held noises, and 0.01 um of noise."""
    rng = np.random.default_rng(seed)
    v = np.repeat(rng.uniform(-1.0, 1.0, (2, samples // 3 + 1)), 3, axis=1)[:, :samples]
    y = 0.01 * rng.standard_normal(samples)
    for f_Hz, zeta, shapes in zip(F_HZ, ZETA, SHAPES, strict=True):
        w = 2.0 * np.pi * f_Hz
        b, a, _ = cont2discrete(([w * w], [1.0, 2.0 * zeta * w, w * w]), TS_S)
        for drive, shape in zip(v, shapes, strict=True):
            y += shape * lfilter(np.ravel(b), a, drive)
    return Segment(str(seed), v[0], y, {"other_V": v[1]})


@pytest.mark.slow
def test_modes_of_two_drives_are_named_and_delivered() -> None:
    known, fresh = (Record.from_segments([segment(seed, n)], TS_S) for seed, n in ((1, 9000), (2, 4000)))
    found = diagnose(known, fresh)
    assert found.names == ("resonance",)
    [named] = found.causes
    frequencies = sorted(e.value for key, e in named.parameters.items() if key.startswith("f"))
    assert frequencies == pytest.approx(list(F_HZ), rel=1e-3)
    assert [block.kind for block in found.model.blocks] == ["hysteresis", "structure"]
    assert [term.kind for term in found.model.terms] == ["drives"]
    # 0.01 um of noise, and as much of what 9000 rows leave open.
    assert found.extended_rms_um < 0.02 < 0.02 * found.base_rms_um
    assert any(name.endswith(".c") for name in generate(found.model))
