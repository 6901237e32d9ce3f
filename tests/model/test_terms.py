"""Promises of every additive term."""

from __future__ import annotations

import dataclasses
import json
from typing import Any

import numpy as np
import pytest

from hysgen.errors import ModelError
from hysgen.model.terms import Drive, Term, kinds, term_from_json
from hysgen.model.terms.coupling import Coupling
from hysgen.model.terms.creep import Creep
from hysgen.model.terms.drift import Drift
from hysgen.model.terms.memory import Memory
from hysgen.model.terms.periodic import Periodic
from hysgen.model.terms.resonance import Resonance

TS_S = 2e-5
SPAN_V = 100.0
LAST_BIT = 2.0**-24

TERMS: list[Term] = [
    Memory.uniform(10, 40.0),
    Memory.polynomial(5, 3, -75.0, 95.0, past_input=True),
    Creep.log_spaced(3, 1e-3, 10.0),
    Resonance((50.0, 730.0), (0.01, 0.3)),
    Periodic((50.0, 101.7)),
    Coupling(("temperature", "other_V"), (20.0, -1.0), (24.0, 3.0), taps=3),
    Drift(0.01, 0.5),
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
    mirror = term.mirror(over.u_V[:1].astype(np.float32), over.Ts_s)
    assert over.innovation_um is not None
    bias = np.zeros(1, dtype=np.float32)
    rows = []
    for k, u in enumerate(over.u_V.astype(np.float32)):
        mirror.listen({name: values[k : k + 1].astype(np.float32) for name, values in over.aux.items()})
        # The mirror is told y(k) - yhat(k), where yhat holds the bias; Drive carries the error without it.
        if k > 0:
            mirror.correct(over.innovation_um[k : k + 1].astype(np.float32) - bias)
        rows.append(np.concatenate(mirror.regressors()))
        bias = rows[-1][:1] if term.kind == "drift" else bias
        mirror.advance(np.array([u]))
    return np.array(rows)


def test_every_kind_is_in_this_list() -> None:
    assert set(kinds()) == {term.kind for term in TERMS}
    assert all(isinstance(term, Term) for term in TERMS)


@by_kind
def test_regressors_do_not_see_the_present_input(term: Term) -> None:
    over = drive(400)
    moved = over.u_V.copy()
    moved[200] += 50.0
    before, after = term.regressors(over), term.regressors(dataclasses.replace(over, u_V=moved))
    assert before.shape == (400, term.size)
    assert np.array_equal(before[:201], after[:201])
    if term.kind in ("memory", "creep", "resonance"):
        assert not np.array_equal(before[201], after[201])


@by_kind
@pytest.mark.slow
def test_mirror_agrees_with_float64(term: Term) -> None:
    over = drive(20_000)
    truth, single = term.regressors(over), mirrored(term, over)
    # In last bits of each regressor's largest value. A pole rounded to float32 is off by 1/2 bit of its distance from
    # 1, which a mode multiplies by 1/zeta; coupling subtracts a middle 12 times its range; the sine claims 1.9e-7.
    claims = {"resonance": 2 + 1 / 0.01, "periodic": 1.9e-7 / LAST_BIT, "coupling": 13.0}
    error = np.abs(single - truth).max(axis=0) / (LAST_BIT * np.abs(truth).max(axis=0))
    # T_3 multiplies the three roundings of its place by up to 9.
    claims |= {"memory": 20.0} if isinstance(term, Memory) and term.degree > 1 else {}
    assert error.max() < claims.get(term.kind, 3.0)


@by_kind
def test_start_is_rest_under_a_constant_input(term: Term) -> None:
    phi = term.regressors(Drive(np.full(50, 37.5), TS_S, drive(50).aux))
    state = term.start(37.5)
    if term.kind in ("memory", "creep", "resonance"):
        assert np.abs(phi[:, : state.size] - state).max() < 1e-13 * SPAN_V
        assert np.ptp(phi, axis=0).max() < 1e-13 * SPAN_V


@by_kind
def test_a_segment_continues_from_the_state_of_the_one_before(term: Term) -> None:
    over, cut = drive(4000), 2500
    whole = term.regressors(over)
    state = whole[cut]
    if isinstance(term, Coupling):
        taps = whole[cut].reshape(len(term.channels), term.taps)
        state = taps[:, :0:-1].ravel()
    if isinstance(term, Memory):
        state = state[: term.plays]
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


@pytest.mark.parametrize("term", [Creep((1e-4, 2e-3)), Resonance((700.0,), (0.02,)), Drift(2e-3, 0.5)])
def test_linear_states_have_forgotten_their_start_when_they_say_so(term: Term) -> None:
    rest = Drive(np.zeros(20_000), TS_S, innovation_um=np.zeros(20_000))
    start = np.where(np.arange(term.start(0.0).size) % 2 == 0, 0.4, 0.0) if term.kind == "resonance" else 0.4
    started = dataclasses.replace(rest, start={term.kind: start + term.start(0.0)})
    left = np.abs(term.regressors(started)).max(axis=1)
    burn_in = term.burn_in(rest)
    assert left[burn_in:].max() <= 0.01 * left.max() * (1 + 1e-9)
    assert left[burn_in // 2 :].max() > 0.05 * left.max()
    assert term.burn_in(Drive(np.zeros(20), TS_S)) == 20


@by_kind
def test_linear_system_gives_the_same_regressors(term: Term) -> None:
    over = drive(600)
    system = term.linear(TS_S)
    if system is None:
        assert term.kind == "memory"
        return
    x = term.start(float(over.u_V[0])) if system.A.size else np.zeros(0)
    for k, phi in enumerate(term.regressors(over)):
        if system.A.size:
            assert np.abs(system.C @ x - phi).max() < 1e-11 * SPAN_V
        x = system.A @ x + system.B * over.u_V[k]
    assert system.C.shape == (term.size, system.A.shape[0])
    assert np.abs(np.linalg.eigvals(system.A)).max(initial=0.0) < 1.0


@by_kind
def test_gains_bound_the_response_to_any_input(term: Term) -> None:
    gains = np.array(term.gains(TS_S))
    system = term.linear(TS_S)
    rng = np.random.default_rng(3)
    if system is None:
        a, b = (rng.uniform(-SPAN_V, SPAN_V, 3000) for _ in range(2))
        apart = term.regressors(Drive(a, TS_S)) - term.regressors(Drive(b, TS_S))
        assert (np.abs(apart).max(axis=0) <= gains * np.abs(a - b).max()).all()
        return
    # The input that a regressor likes best is the sign of its impulse response, reversed.
    impulse = [system.B]
    for _ in range(20_000 if system.A.size else 0):
        impulse.append(system.A @ impulse[-1])
    reached = np.abs(np.array(impulse) @ system.C.T).sum(axis=0)
    assert (reached <= gains * (1 + 1e-12)).all()
    if term.kind == "resonance":
        # |cos| averages 2/pi, and of the slower mode 0.71 has died away by then.
        assert (reached > 0.4 * gains).all()


@by_kind
def test_json_round_trip_is_exact(term: Term) -> None:
    again = term_from_json(json.loads(json.dumps(term.to_json())))
    assert again == term
    assert json.dumps(again.to_json()) == json.dumps(term.to_json())


@by_kind
def test_shape_parameters_come_back_and_lie_within_their_bounds(term: Term) -> None:
    shape = term.shape()
    again = term.with_shape(shape)
    assert np.allclose(again.shape(), shape, rtol=0, atol=1e-12)
    low, high = term.shape_bounds(drive(20_000))
    assert low.shape == high.shape == shape.shape
    assert (low < high).all()
    for corner in (low, high):
        inside = term.with_shape(np.where(np.arange(shape.size) == 0, corner, shape))
        assert inside.size == term.size


@by_kind
def test_channels_and_description_fit_the_kind(term: Term) -> None:
    assert term.channels == (("temperature", "other_V") if term.kind == "coupling" else ())
    assert "\n" not in term.describe()


@pytest.mark.parametrize(
    ("data", "complaint"),
    [
        ({"kind": "magic"}, "terms: kind 'magic' is unknown; this hysgen knows coupling, creep, drift"),
        ({"kind": "memory", "thresholds_V": [2.0, 1.0]}, "terms: memory: thresholds_V must be rising, from 0 or above"),
        ({"kind": "creep", "tau_s": [], "shared": True}, "terms: creep: tau_s must be positive and rising"),
        ({"kind": "creep", "tau_s": [1.0], "shared": 0}, "terms: creep: shared must be true or false"),
        ({"kind": "creep"}, "terms: creep: 'tau_s'"),
        ({"kind": "resonance", "f_Hz": [50.0], "zeta": [1.5]}, "terms: resonance: zeta must give each mode"),
        ({"kind": "resonance", "f_Hz": [50.0, 60.0], "zeta": [0.1]}, "terms: resonance: zeta must give each mode"),
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


@pytest.mark.parametrize("term", [Resonance((30_000.0,), (0.1,)), Periodic((30_000.0,))], ids=lambda term: term.kind)
def test_frequencies_beyond_half_the_sampling_frequency_are_refused(term: Term) -> None:
    with pytest.raises(ModelError, match="30000 Hz lies beyond half the sampling frequency, 25000 Hz"):
        term.constants(TS_S)
