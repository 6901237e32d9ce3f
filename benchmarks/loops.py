"""Loops that `hysgen loop` designs, around stages that share no equation with it: chains of masses in springs.

python benchmarks/loops.py          bandwidths and margins, and the worst of a thousand chains after a push
python benchmarks/loops.py track    rms and largest error of tasks by method, on a chain behind an elasto-slide actuator
python benchmarks/loops.py track 0  the same on the virtual laboratory stage
python benchmarks/loops.py track 2  the same on two masses, which showed two faults of the waveform

Behind each error stands the rms of the part that repeats: the error of the stage without noise and drift. `limits` is
the least rms that the amplifier allows: a quadratic programme over every voltage inside range and rate, about the true
stage without noise (`least_within`), which is played and corrected until it no longer falls.
"""

from __future__ import annotations

import math
import sys
from itertools import accumulate

import numpy as np
from numpy.typing import NDArray
from quadratic import quadratic
from scipy import sparse
from scipy.linalg import expm
from scipy.signal import cont2discrete, tf2ss

import hysgen
from hysgen.feedback.certificate import LoopDesign
from hysgen.float32.reference.instance import Instance
from hysgen.machine.kernels.operators import slew_limited
from hysgen.model.model import Grid, Model
from hysgen.model.path import preview
from hysgen.model.path.structure import Structure
from hysgen.model.rivals import fit_proportional
from hysgen.record.segment import Segment
from hysgen_lab.firmware.reference_models import HIGH_V, LOW_V, laboratory
from hysgen_lab.stage import StageState

Floats = NDArray[np.float64]
TS_S = 2e-5
LAG_S = 1e-4
DRAWS = 1000


def chain(masses: Floats, springs: Floats, damping: float) -> tuple[Floats, Floats, Floats]:
    """x' = A x + B force, y = C x: masses in line, (n,), each behind a spring, (n,), the first one at the wall; the
    force moves the first mass, the sensor sees all of them. Damping: the same share of critical in every spring."""
    n = masses.size
    links = np.eye(n) - np.eye(n, k=-1)
    stiff = links.T @ np.diag(springs) @ links
    lossy = links.T @ np.diag(2.0 * damping * np.sqrt(springs * masses)) @ links
    A = np.block([[np.zeros((n, n)), np.eye(n)], [-stiff / masses[:, None], -lossy / masses[:, None]]])
    B = np.concatenate([np.zeros(n), np.eye(n)[0] / masses])
    C = np.concatenate([np.linspace(1.0, 0.3, n), np.zeros(n)])
    return A, B, C / float(C @ np.linalg.solve(-A, B))


def modal(A: Floats, B: Floats, C: Floats) -> Structure:
    """The chain as an identification would find it: frequency, damping and complex share of each mode."""
    poles, V = np.linalg.eig(A)
    shares = -2.0 * (C @ V) * np.linalg.solve(V, B.astype(complex)) / poles
    rows = sorted((abs(p), -p.real / abs(p), q.real, q.imag) for p, q in zip(poles, shares, strict=True) if p.imag < 0)
    w, zeta, share, quadrature = (tuple(map(float, row)) for row in zip(*rows, strict=True))
    return Structure(tuple(np.array(w) / (2.0 * math.pi)), zeta, share, LAG_S, quadrature, TS_S)


def stage(modes: int) -> tuple[Floats, Floats, float]:
    springs = (2.0 * math.pi * 800.0) ** 2 * np.array([1.0, 3.0, 6.0][:modes])
    return np.array([1.0, 0.6, 0.3])[:modes], springs, 0.01


def model_of(modes: int) -> Model:
    keep = math.exp(-TS_S / LAG_S)
    return Model(
        "chain",
        TS_S,
        Grid(-40.0, 140.0, 4),
        np.tile([keep, 1.0 - keep, 0.0], (4, 1)),
        -20.0,
        120.0,
        blocks=(modal(*chain(*stage(modes))),),
    )


def pushed(model: Model, loop: LoopDesign, rng: np.random.Generator, samples: int) -> Floats:
    """(DRAWS, samples) displacement less 50 um after a push of 1 um, by the arithmetic that is emitted.

    Every draw is a chain of its own masses, springs and dampers behind an elasto-slide actuator and a lag.
    """
    masses, springs, damping = stage(len(model.blocks[0].f_Hz))
    n = masses.size
    # A spring of 1 % moves a mode by half of it, so does a mass: within the 1 % of the uncertainty.
    own_masses, own_springs = (x * (1.0 + rng.uniform(-0.009, 0.009, (DRAWS, n))) for x in (masses, springs))
    rates, of = np.zeros((DRAWS, 2 * n + 1, 2 * n + 1)), np.empty((DRAWS, 2 * n))
    for i in range(DRAWS):
        rates[i, :-1, :-1], rates[i, :-1, -1], of[i] = chain(
            own_masses[i], own_springs[i], damping * rng.uniform(0.75, 1.25)
        )
    whole = expm(TS_S * rates)
    step_A, step_B = whole[:, :-1, :-1], whole[:, :-1, -1]
    level = np.full(DRAWS, 50.0, dtype=np.float32)
    inverse = Instance(loop.around(model), level, level)
    keep = math.exp(-TS_S / LAG_S) ** (1.0 / rng.uniform(0.92, 1.08, DRAWS))
    gain, slack = rng.uniform(0.97, 1.03, DRAWS), rng.uniform(0.0, 0.2, DRAWS)
    rest = np.linalg.solve(np.eye(2 * n) - step_A, step_B[..., None])[..., 0]
    x, lagged, slid, late = rest * 50.0, np.full(DRAWS, 50.0), np.zeros(DRAWS), np.full(DRAWS, 50.0)
    asked, y = level, np.empty((DRAWS, samples))
    for k in range(samples):
        y[:, k] = np.einsum("ij,ij->i", of, x) - 50.0 + 1.0
        correction = inverse.correct((-y[:, k]).astype(np.float32))
        # The voltage of the last sample acts now, a sample late; the slider gives way within its friction.
        # From where it was asked last: the model's own y would feed modes back that the inverse leaves out.
        u, late = late, inverse.inverse(asked, level + correction).astype(float)
        asked = level + correction
        slid = np.clip(slid, u - 50.0 - slack, u - 50.0 + slack)
        drive = 50.0 + gain * (0.9 * (u - 50.0) + 0.1 * slid)
        x = np.einsum("ijk,ik->ij", step_A, x) + step_B * lagged[:, None]
        lagged = keep * lagged + (1.0 - keep) * drive
    return y


class Actuator:
    """Masses behind forty elasto-slide elements and a lag, with noise; voltages act a sample late."""

    span_V, middle = (0.0, 100.0), (1.0, 6.0)
    """Its voltages, and amplitude and centre in um of what it follows."""

    def __init__(self, modes: int, draw: int, noisy: bool = True) -> None:
        A, B, self.C = chain(*stage(modes))
        whole = expm(TS_S * np.block([[A, B[:, None]], [np.zeros((1, B.size + 1))]]))
        self.A, self.B = whole[:-1, :-1], whole[:-1, -1]
        rng = np.random.default_rng([modes, draw])
        self.slack_V = 40.0 * np.random.default_rng(modes).weibull(1.5, 40)
        self.rest = np.linalg.solve(np.eye(B.size) - self.A, self.B)
        self.noise = (noisy * NOISE_UM * rng.standard_normal(200_000)).tolist()
        self.slid, self.last_V, self.late_V, self.k = np.zeros(40), 0.0, 0.0, 0
        self.lagged = 0.0
        self.x = self.rest * 0.0
        self.keep = math.exp(-TS_S / LAG_S)

    def read(self) -> float:
        """Displacement in um with noise."""
        self.k += 1
        return float(self.C @ self.x) + self.noise[self.k % 200_000]

    def step(self, u_V: float) -> None:
        """One sample under the voltage of the sample before."""
        u_V, self.late_V = self.late_V, u_V
        self.slid = np.clip(self.slid + (u_V - self.last_V), -self.slack_V, self.slack_V)
        self.last_V = u_V
        self.x = self.A @ self.x + self.B * self.lagged
        drive = 0.12 * (u_V - 0.25 * float(self.slid.mean()))
        self.lagged = self.keep * self.lagged + (1.0 - self.keep) * drive

    def linear(self) -> tuple[Floats, Floats, Floats]:
        """From voltage to displacement with every slider stuck: lag, masses, and the voltage's sample of delay."""
        n = self.B.size
        A, B = np.zeros((n + 2, n + 2)), np.eye(n + 2)[-1]
        A[:n, :n], A[:n, n], A[n, n], A[n, -1] = self.A, self.B, self.keep, 1.0 - self.keep
        return A, B, 0.09 * np.append(self.C, [0.0, 0.0])


class Laboratory:
    """The laboratory stage: hysteresis, lag, mode, creep, drift, hum, amplifier, sensor; voltages act a sample late."""

    span_V, middle = (LOW_V, HIGH_V), (0.6, 2.0)

    def __init__(self, draw: int, noisy: bool = True) -> None:
        stage = laboratory() if noisy else laboratory().with_effects(drift=None).quiet()
        self.state, self.late_V = StageState(stage, TS_S, draw), LOW_V

    def read(self) -> float:
        """Displacement in um as the sensor gives it."""
        return float(self.state.advance(np.array([self.late_V]), np.zeros((1, 0))).reading_um[0])

    def step(self, u_V: float) -> None:
        """One sample under the voltage of the sample before."""
        self.state.step(self.late_V, [])
        self.late_V = u_V

    def linear(self) -> tuple[Floats, Floats, Floats]:
        """From voltage to displacement: lag, mode, amplifier, the gain of the stroke, and a sample that it is late."""
        w, lags = 2.0 * math.pi * 780.0, np.polymul([1e-3, 1.0], [1.0 / (2.0 * math.pi * 10e3), 1.0])
        ring = np.array([1.0 / w**2, 0.06 / w, 1.0])
        A, B, C, _, _ = cont2discrete(tf2ss(0.75 * ring + [0.0, 0.0, 0.25], np.polymul(lags, ring)), TS_S)
        n = len(A)
        late = np.block([[A, B], [np.zeros((1, n + 1))]])
        return late, np.eye(n + 1)[-1], 0.06 * np.append(C[0], 0.0)


Plant = Actuator | Laboratory


def plant(modes: int, draw: int, noisy: bool = True) -> Plant:
    """A chain of masses behind its actuator, or, of 0 modes, the laboratory stage; without what does not repeat."""
    return Actuator(modes, draw, noisy) if modes else Laboratory(draw, noisy)


def played(stage: Plant, u_V: Floats) -> Floats:
    """(n,) readings, from the range's low end, up, down, and a while at the first voltage on."""
    low, high = stage.span_V
    fill = np.concatenate([np.linspace(low, high, 4000), np.linspace(high, low, 4000), np.full(3000, u_V[0])])
    fill[8000:8500] = np.linspace(low, u_V[0], 500)
    for u in fill:
        stage.step(float(u))
    out = np.empty(u_V.size)
    for k, u in enumerate(u_V):
        out[k] = stage.read()
        stage.step(float(u))
    return out


TASKS = (("sine", 50.0), ("sine", 100.0), ("triangle", 1000.0), ("scan", 50.0), ("steps", 20.0))
"""Form and frequency in Hz of each task: two sines, a fast triangle, a raster with flyback, a staircase."""

RATE_V = {0: 2.0}
"""Largest change of the voltage in a sample by number of modes: the amplifier of the laboratory stage. The record does
not show it; its data sheet does, so waveforms are made for it (`--slew`)."""

NOISE_UM, REPEATS = 5e-4, 10


def record_of(modes: int, draw: int = 99) -> hysgen.Record:
    """0.8 s of slow loops, steps and a chirp, by which a model is identified."""
    rng = np.random.default_rng([modes, draw])
    t, stage = TS_S * np.arange(40_000), plant(modes, draw)
    half_V, middle_V = 0.5 * np.ptp(stage.span_V), 0.5 * sum(stage.span_V)
    share = 0.9 * np.interp(t, np.linspace(0.0, 0.8, 33), rng.uniform(-1.0, 1.0, 33))
    share += 0.08 * np.sin(2.0 * np.pi * (100.0 * t + 3000.0 * t**2))
    u_V = middle_V + half_V * np.clip(share, -1.0, 1.0)
    return hysgen.Record.from_arrays(u_V, played(stage, u_V), TS_S, source="stage")


ROUNDS, AHEAD, WEIGHT = 30, 400, 10.0
"""Rounds of `least_within`, samples before the reference whose voltage is free, and the first weight, in squares of the
noise over V^2, of what a round changes from sample to sample (Levenberg and Marquardt)."""


def least_within(modes: int, wanted: Floats, u_V: Floats) -> Floats:
    """The errors, (m,), that are least in the mean square over every voltage inside the limits, from u, (n,), on.

    Round by round the programme about the last voltage u and the true error e of the stage without noise

        minimise |e + P (v - u)|^2 + weight |change of v - u|^2   such that  low <= v <= high, |v(k) - v(k-1)| <= rate

    with P the linear part of the true stage; v is played, and the best of all rounds stays.
    """
    stage, rate_V = plant(modes, 0, noisy=False), RATE_V.get(modes, math.inf)
    (A, B, C), (low, high), m = stage.linear(), stage.span_V, wanted.size
    n, order = m + AHEAD, B.size
    # States of about 1: their largest values behind a step of 1 V.
    size = np.abs(list(accumulate(range(n), lambda x, _: A @ x + B, initial=0.0 * B))).max(axis=0)
    A, B, C = A * size / size[:, None], B / size, C * size
    # Unknowns are v - u and the states, sample by sample: s(k+1) = A s(k) + B v(k).
    late, unit = sparse.eye_array(n, k=-1), sparse.eye_array(n)
    E = sparse.hstack([-sparse.kron(late, B[:, None]), sparse.kron(unit, np.eye(order)) - sparse.kron(late, A)])
    of_v = sparse.hstack([unit, sparse.csr_array((n, n * order))])
    change = sparse.hstack([unit - late, sparse.csr_array((n, n * order))])
    G = sparse.vstack([of_v, -of_v, *([change, -change] if rate_V < math.inf else [])], format="csr")
    see = sparse.hstack([sparse.csr_array((m, n)), sparse.kron(sparse.eye_array(m, n, k=AHEAD), C[None, :])]) / NOISE_UM
    k = np.arange(float(n))
    at = np.argsort(np.concatenate([k, *[np.repeat(k, order) + 0.3] * 2]), kind="stable")
    before, u_V = u_V[:-n], u_V[-n:]

    def judged(v: Floats) -> tuple[float, Floats, Floats]:
        v = slew_limited(np.clip(v, low, high), rate_V, rate_V, float(before[-1]))
        e = played(plant(modes, 0, noisy=False), np.append(before, v))[-m:] - wanted
        return float(np.mean(e**2)), v, e

    best, weight = judged(u_V), WEIGHT
    for _ in range(ROUNDS):
        _, u_V, e = best
        moved = np.diff(np.append(before[-1:], u_V))
        sides = [high - u_V, u_V - low, *([rate_V - moved, rate_V + moved] if rate_V < math.inf else [])]
        H, q = see.T @ see + weight * change.T @ change, see.T @ e / NOISE_UM
        step = quadratic(H, q, E.tocsr(), G, np.concatenate(sides), at)[:n]
        last = judged(u_V + step)
        weight *= 0.2 if last[0] < best[0] else 10.0
        best = min(best, last, key=lambda row: row[0])
        if best[0] < (0.1 * NOISE_UM) ** 2:
            break
    return best[2]


def followed(model: Model, actuator: Plant, wanted: Floats, slew_V_s: float | None) -> Floats:
    """(n,) readings along a reference, by the emitted inverse and a loop around it; the loop closes at rest, before.

    Its residual is that from what can be reached: what the limits leave is no error of the stage.
    """
    ahead = preview(model.blocks) + 1
    held = np.concatenate([np.full(3000, wanted[0]), wanted, np.full(ahead, wanted[-1])])
    plan = hysgen.waveform(model, held, slew_V_s=slew_V_s)
    course = np.concatenate([np.full(plan.lead, wanted[0]), plan.y_um])
    asked_um, first_V = plan.asked_um.astype(np.float32), plan.u_V[:1].astype(np.float32)
    played(actuator, np.full(10, first_V[0]))
    inverse = Instance(model, asked_um[:1], first_V)
    asked = asked_um[:1]
    out = np.empty(course.size - ahead)
    for k in range(out.size):
        out[k] = actuator.read()
        correction = inverse.correct((course[k : k + 1] - out[k]).astype(np.float32))
        aim = asked_um[k + ahead : k + ahead + 1] + correction
        actuator.step(float(inverse.inverse(asked, aim)[0]))
        asked = aim
    return out[plan.lead + 3000 :]


def track(modes: int) -> None:
    """The table of a stage that one record identifies."""
    record = record_of(modes)
    model = hysgen.diagnose(record).model
    print(model, sep="\n")
    free_run_um = hysgen.score(model, record_of(modes, 98)).free_run.e_rms_um
    print(
        f"noise {1e3 * NOISE_UM:.2f} nm; free run {1e3 * free_run_um:.4g} nm; rms (largest) error; of what repeats, nm"
    )
    table(modes, record, model)


def table(modes: int, record: hysgen.Record, model: Model) -> None:
    """Rms and largest error in nm of every task by every method, and the rms of the part that repeats."""
    paper, straight, loop = hysgen.fit(record), fit_proportional(record), hysgen.design_loop(model)
    print(loop)
    slew_V_s = RATE_V[modes] / TS_S if modes in RATE_V else None
    by_hand = 2.0 * math.pi * loop.certificate.without_inverse_Hz * TS_S
    for form, f_Hz in TASKS:
        amplitude_um, centre_um = plant(modes, 0).middle
        amplitude_um *= 1.0 if f_Hz < 500.0 else 0.05
        shape = hysgen.Form(amplitude_um, centre_um, f_Hz, max(2.0, round(0.04 * f_Hz)))
        plan = hysgen.waveform(model, form, shape, loop=True, slew_V_s=slew_V_s)
        wanted, row = plan.reference.values, dict[str, tuple[Floats, ...]]()

        def play(u_V: Floats, repeat: int = 0, noisy: bool = True) -> Floats:
            return played(plant(modes, 1 + repeat, noisy), u_V)

        def errors(u_V: Floats, lead: int = 0, course: Floats = wanted) -> tuple[Floats, ...]:
            return tuple(play(u_V, noisy=noisy)[lead:] - course for noisy in (True, False))

        ratio = np.append(straight.inverse(wanted), 0.0)[: wanted.size]
        ratio[-1] = ratio[-2]
        row["proportional"] = errors(ratio)
        other = hysgen.waveform(paper, form, shape, slew_V_s=slew_V_s)
        row["paper's inverse"] = errors(other.u_V, other.lead)
        row["by hand"] = tuple(by_hand_errors(plant(modes, 1, quiet), ratio, wanted, by_hand / 0.1) for quiet in (1, 0))
        plays = []
        for repeat in range(REPEATS + 1):
            if repeat in (0, 1, 3, 5, REPEATS):
                row[f"learnt {repeat}" if repeat else "feed-forward"] = errors(plan.u_V, plan.lead)
            segment = Segment("0", plan.u_V, play(plan.u_V, repeat), {}, plan.start_s)
            plays.append(hysgen.Record.from_segments([segment], TS_S, "played"))
            plan = hysgen.waveform(model, form, shape, loop=True, slew_V_s=slew_V_s, plays=plays)
        looped = loop.around(model)
        row["designed loop"] = tuple(
            followed(looped, plant(modes, 1, noisy), wanted, slew_V_s) - wanted for noisy in (True, False)
        )
        row["limits"] = (least_within(modes, wanted, plan.u_V),) * 2
        texts = (
            f"{name} {rms_nm(e):.4g} ({1e3 * np.abs(e).max():.4g}; {rms_nm(own):.3g})" for name, (e, own) in row.items()
        )
        print(f"{form} {f_Hz:g} Hz:", "; ".join(texts), flush=True)


def rms_nm(e_um: Floats) -> float:
    return 1e3 * float(np.sqrt(np.mean(e_um**2)))


def by_hand_errors(actuator: Plant, ratio_V: Floats, wanted: Floats, gain_V: float) -> Floats:
    """(n,) errors of proportional feed-forward and an integral, in V per um and sample, as tuned by hand."""
    played(actuator, np.full(10, ratio_V[0]))
    sum_V, error = 0.0, np.empty(wanted.size + 3000)
    for k in range(error.size):
        at = max(k - 3000, 0)
        error[k] = actuator.read() - wanted[at]
        sum_V -= gain_V * error[k]
        actuator.step(float(np.clip(ratio_V[at] + sum_V, *actuator.span_V)))
    return error[3000:]


def main() -> None:
    """Print one of the tables."""
    if sys.argv[1:2] == ["track"]:
        for modes in map(int, sys.argv[2:] or ("1",)):
            track(modes)
        return
    for modes in (1, 2, 3):
        model = model_of(modes)
        loop = hysgen.design_loop(model)
        samples = math.ceil(20.0 / (2.0 * math.pi * loop.certificate.bandwidth_Hz * TS_S))
        y = np.abs(pushed(model, loop, np.random.default_rng(modes), 2 * samples))
        print(
            loop, f"{DRAWS} chains: largest {y.max():.3g} of a push of 1, {y[:, -50:].max():.3g} at the end", sep="\n"
        )


if __name__ == "__main__":
    main()
