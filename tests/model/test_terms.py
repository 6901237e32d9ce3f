"""Promises of every additive term."""

from typing import Any

import numpy as np
import pytest

from hysgen.errors import ModelError
from hysgen.model.disturbances import Drive, Term, kinds, term_from_json
from hysgen.model.disturbances.coupling import Coupling, Drives
from hysgen.model.disturbances.drift import Drift
from hysgen.model.disturbances.periodic import Periodic

TS_S = 2e-5
LAST_BIT = 2.0**-24

TERMS: list[Term] = [
    Periodic((50.0, 101.7)),
    Coupling(("temperature", "other_V"), (20.0, -1.0), (24.0, 3.0), taps=3),
    Drift(0.01, 0.5),
    Drives(
        ("temperature", "other_V"),
        (20.0, -1.0),
        (24.0, 3.0),
        f_Hz=(60.0, 730.0),
        zeta=(0.01, 0.3),
        share=(0.1, -0.2, 0.3, 0.1),
        quadrature=(0.0, 0.1, -0.2, 0.0),
    ),
]
by_kind = pytest.mark.parametrize("term", TERMS, ids=lambda term: term.kind)


def drive(samples: int, seed: int = 7) -> Drive:
    """Steps, a sine and noise within +-100 V, with channels and one-step errors, rounded to float32."""
    rng = np.random.default_rng(seed)
    k = np.arange(samples)
    u = 30 * np.sin(2 * np.pi * 60 * TS_S * k) + np.repeat(rng.uniform(-40, 60, samples // 500 + 1), 500)[:samples]
    channels = {"temperature": 22 + 3 * np.sin(1e-3 * k), "other_V": rng.uniform(-1.2, 3.2, samples)}

    def single(x: Any) -> Any:
        return np.asarray(x, dtype=np.float32).astype(np.float64)

    return Drive(
        single(u + rng.normal(0, 0.1, samples)),
        TS_S,
        {name: single(values) for name, values in channels.items()},
        innovation_um=single(0.01 + rng.normal(0, 0.02, samples)),
    )


def mirrored(term: Term, over: Drive) -> np.ndarray[Any, Any]:
    """(n, size) regressors of the float32 mirror over a drive, one lane."""
    mirror = term.mirror(1, over.Ts_s)
    assert over.innovation_um is not None
    bias = np.zeros(1, dtype=np.float32)
    rows = []
    for k in range(over.u_V.size):
        mirror.listen({name: values[k : k + 1].astype(np.float32) for name, values in over.aux.items()})
        # The mirror is told y(k) - yhat(k), where yhat holds the bias; Drive carries the error without it.
        if k > 0:
            mirror.correct(over.innovation_um[k : k + 1].astype(np.float32) - bias)
        rows.append(np.concatenate(mirror.regressors()))
        bias = rows[-1][:1] if term.kind == "drift" else bias
        mirror.advance()
    return np.array(rows)


def test_every_kind_is_in_this_list() -> None:
    assert set(kinds()) == {term.kind for term in TERMS}
    assert all(isinstance(term, Term) for term in TERMS)


@by_kind
@pytest.mark.slow
def test_mirror_agrees_with_float64(term: Term) -> None:
    over = drive(20_000)
    truth, single = term.regressors(over), mirrored(term, over)
    # In last bits of each regressor's largest value. Coupling subtracts a middle 12 times its range; the sine claims
    # 1.9e-7. Drives subtract a middle 12 times its range, too, and a step is the difference of two products.
    claims = {"periodic": 1.9e-7 / LAST_BIT, "coupling": 13.0, "drives": 13.0}
    error = np.abs(single - truth).max(axis=0) / (LAST_BIT * np.abs(truth).max(axis=0))
    assert error.max() < claims.get(term.kind, 3.0)


@by_kind
def test_a_segment_continues_from_the_state_of_the_one_before(term: Term) -> None:
    over, cut = drive(4000), 2500
    whole = term.regressors(over)
    state = whole[cut]
    if isinstance(term, Drives):
        state = term.states(over)[cut].ravel()
    elif isinstance(term, Coupling):
        taps = whole[cut].reshape(len(term.channels), term.taps)
        state = taps[:, :0:-1].ravel()
    assert over.innovation_um is not None
    rest = Drive(
        over.u_V[cut:],
        TS_S,
        {name: values[cut:] for name, values in over.aux.items()},
        first=cut,
        start={term.kind: state},
        innovation_um=over.innovation_um[cut:],
    )
    assert np.abs(term.regressors(rest) - whole[cut:]).max() < 1e-10


@by_kind
def test_only_coupling_and_drives_read_channels(term: Term) -> None:
    assert term.channels == (("temperature", "other_V") if term.kind in ("coupling", "drives") else ())
    assert "\n" not in term.describe()


@pytest.mark.parametrize(
    ("data", "complaint"),
    [
        ({"kind": "magic"}, "terms: kind 'magic' is unknown; this hysgen knows coupling, drift, drives, periodic"),
        ({"kind": "memory"}, "terms: memory: this hysgen has it in the path, ahead of the rules; fit the model again"),
        ({"kind": "drift"}, "terms: drift: 'tau_s'"),
        ({"kind": "periodic", "f_Hz": [float("nan")]}, "terms: periodic: f_Hz must be positive and rising"),
        ({"kind": "coupling", "channels": ["a"], "low": [1.0], "high": [1.0], "taps": 1}, "low must lie below high"),
        ({"kind": "coupling", "channels": ["a"], "low": [0.0], "high": [1.0], "taps": 0}, "taps must be 1 to 64"),
        ({"kind": "drift", "tau_s": 0.0, "limit_um": 1.0}, "terms: drift: tau_s and limit_um must be positive"),
    ],
)
def test_malformed_terms_are_refused_in_one_line(data: dict[str, Any], complaint: str) -> None:
    with pytest.raises(ModelError) as fault:
        term_from_json(data)
    assert complaint in str(fault.value)
    assert "\n" not in str(fault.value)


def test_frequencies_beyond_half_the_sampling_frequency_are_refused() -> None:
    with pytest.raises(ModelError, match="30000 Hz lies beyond half the sampling frequency, 25000 Hz"):
        Periodic((30_000.0,)).constants(TS_S)


def test_the_worst_input_of_a_structure_reaches_its_bound_and_does_not_leave_it() -> None:
    """The bound is 1 % wider than the motion under the channel that answers every sign of the impulse response."""
    f_Hz, zeta, n = (60.0, 730.0), (0.1, 0.3), 20_000
    term = Drives(("v",), (-1.0,), (3.0,), f_Hz=f_Hz, zeta=zeta, share=(0.3, 0.1), quadrature=(0.1, -0.2))
    impulse = term.regressors(Drive(np.zeros(n), TS_S, {"v": np.where(np.arange(n) == 0, 3.0, 1.0)}))
    for column, most in zip(impulse.T, term.box(TS_S).regressors, strict=True):
        worst = {"v": 1.0 + 2.0 * np.sign(column[::-1])}
        moved = np.abs(term.regressors(Drive(np.zeros(n), TS_S, worst))).max(axis=0)
        assert 0.98 * most < moved[list(impulse.T.tolist()).index(column.tolist())] <= most


def test_drives_are_the_modes_of_a_stage_behind_its_lag() -> None:
    """o(k) = sum_m Re c_m(k) by a loop over complex numbers, and what the two weights make of it."""
    term = Drives(
        ("v",), (-1.0,), (1.0,), f_Hz=(60.0, 730.0), zeta=(0.1, 0.3), share=(0.3, 0.1), quadrature=(0.1, -0.2)
    )
    v = np.random.default_rng(3).uniform(-1.0, 1.0, 500)
    w, zeta = 2.0 * np.pi * np.array(term.f_Hz), np.array(term.zeta)
    pole = np.exp((-zeta - 1j * np.sqrt(1.0 - zeta**2)) * w * TS_S)
    gain, c, o = (np.array(term.share) + 1j * np.array(term.quadrature)) * (1.0 - pole), np.zeros(2, complex), []
    for value in v:
        o.append(float(c.real.sum()))
        c = pole * c + gain * value
    phi, a, y = term.regressors(Drive(np.zeros(v.size), TS_S, {"v": v})), 0.7, [0.0]
    for row in phi[:-1]:
        y.append(a * y[-1] + float(row @ (1.0 - a, 1.0)))
    assert phi[:, 0] == pytest.approx(np.array(o), abs=1e-12)
    assert np.array(y) == pytest.approx(np.array(o), abs=1e-12)
