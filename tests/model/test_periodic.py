"""The periodic term: no drift of the phase, and the error bound of its sine."""

from fractions import Fraction

import numpy as np
import pytest
from numpy.polynomial import chebyshev, polynomial

from hysgen.model.disturbances import Drive
from hysgen.model.disturbances.periodic import COSINE, SINE, Periodic, cosine_sine

TS_S = 2e-5
CLAIM = 1.9e-7


@pytest.mark.slow
def test_sine_is_within_its_claim_over_every_significand() -> None:
    worst = 0.0
    # A quarter of a turn: the others repeat it bit for bit. All 2^23 values of the bits that enter there, at both ends
    # of what the lower 7 bits may add, and on either side of the step between two values.
    for start in range(2**22, 2**22 + 2**23, 2**21):
        upper = np.arange(start, start + 2**21, dtype=np.uint32) << np.uint32(7)
        for lower in (0, 63, 64, 127):
            phase = upper + np.uint32(lower)
            cosine, sine = cosine_sine(phase)
            angle = 2 * np.pi / 2**32 * phase.astype(np.float64)
            worst = max(worst, np.abs(cosine - np.cos(angle)).max(), np.abs(sine - np.sin(angle)).max())
    assert 1.5e-7 < worst < CLAIM


def test_sine_and_cosine_are_exact_on_the_axes_and_symmetric() -> None:
    cosine, sine = cosine_sine(np.array([0, 2**30, 2**31, 3 * 2**30], dtype=np.uint32))
    assert cosine.tolist() == [1.0, 0.0, -1.0, 0.0]
    assert sine.tolist() == [0.0, 1.0, 0.0, -1.0]
    phase = np.random.default_rng(1).integers(0, 2**32, 10_000, dtype=np.uint32)
    c, s = cosine_sine(phase)
    for quarter, cosine, sine in ((2**30, -s, c), (2**31, -c, -s), (3 * 2**30, s, -c)):
        turned_c, turned_s = cosine_sine(phase + np.uint32(quarter))
        assert np.array_equal(turned_c, cosine)
        assert np.array_equal(turned_s, sine)


def test_coefficients_are_the_interpolation_they_claim_to_be() -> None:
    def in_z(function: object) -> list[np.float32]:
        # Chebyshev interpolation of degree 3 over z in [0, 1/4], as a polynomial in z = (x + 1)/8.
        series = chebyshev.chebinterpolate(lambda x: function((x + 1) / 8), 3)  # type: ignore[operator]
        result = np.zeros(1)
        for coefficient in chebyshev.cheb2poly(series)[::-1]:
            result = polynomial.polyadd(polynomial.polymul(result, [-1.0, 8.0]), [coefficient])
        return [np.float32(c) for c in result]

    assert in_z(lambda z: np.pi / 2 * np.sinc(np.sqrt(z) / 2)) == list(SINE)
    # 1 - cos(x) = 2 sin(x/2)^2 keeps its digits where z is small.
    assert in_z(lambda z: -(np.pi**2) / 8 * np.sinc(np.sqrt(z) / 4) ** 2) == list(COSINE)


def test_phase_after_1e8_samples_is_the_exact_one() -> None:
    for f_Hz in (50.0, 49.9873, 1 / 3, 24_999.9):
        constants = Periodic((f_Hz,)).constants(TS_S)
        turn = (int(constants["turn_high"][0]) << 32) + int(constants["turn_low"][0])
        off = Fraction(turn, 2**64) - Fraction(f_Hz) * Fraction(TS_S)
        # 1e8 samples at 50 kHz are 33 minutes; a turn is 6.28 rad.
        assert abs(off) * 10**8 < Fraction(1, 10**10)


def test_mirror_counts_the_phase_with_every_carry() -> None:
    term = Periodic((50.0, 12_345.678))
    constants = term.constants(TS_S)
    mirror = term.mirror(3, TS_S)
    for _ in range(5000):
        mirror.advance()
    words = [int(word[2]) for word in mirror.state()]
    for j in range(2):
        turn = (int(constants["turn_high"][j]) << 32) + int(constants["turn_low"][j])
        assert (words[j] << 32) + words[2 + j] == 5000 * turn % 2**64


def test_regressors_keep_their_phase_in_absolute_time() -> None:
    term = Periodic((50.0, 101.7))
    whole = term.regressors(Drive(np.zeros(3000), TS_S))
    late = term.regressors(Drive(np.zeros(1000), TS_S, first=2000))
    assert np.abs(late - whole[2000:]).max() < 1e-12
    n = np.arange(3000)
    assert np.abs(whole[:, 3] - np.sin(2 * np.pi * 101.7 * TS_S * n)).max() < 1e-11
