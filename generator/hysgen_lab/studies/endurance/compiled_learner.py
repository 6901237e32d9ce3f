"""The compiled learner of a model inside the endurance driver, which feeds it and records extremes of its factors.

Before it the excitations: one period of each signal on the virtual stage, and the corruption of samples. Behind it the
recovery test after an endurance run: a second of persistent excitation, compared with fresh fits to that second.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from hysgen.codegen import Options, generate
from hysgen.codegen.manifest import c_files
from hysgen.codegen.render import render
from hysgen.codegen.structs import interface_of
from hysgen.fitting import FitSettings, fit
from hysgen.float32.coefficients import coefficients
from hysgen.float32.learner_numbers import learned_model, learner_numbers
from hysgen.machine.native import Library, Toolchain, build
from hysgen.model.disturbances import Drive
from hysgen.model.model import Model
from hysgen.model.simulate import simulate
from hysgen.record import Record
from hysgen_lab.stage import Stage, run

Floats = NDArray[np.float64]

TS_S: Final = 20e-6
LOW_V: Final = 5.0
HIGH_V: Final = 95.0
SECOND: Final = 50_000
"""Samples of one second."""

SENSOR_NOISE_UM: Final = 0.0005


@dataclass(frozen=True)
class Excitation:
    """One period of displacement and voltage, (n,) each, and the corruption of every repetition.

    noise_um, noise_V: rms of the added noise. burst_every, burst_length: bursts of NaN and infinities, in samples.
    spike_every: single displacements of +-1e30, in samples. 0 turns a corruption off.
    """

    about: str
    y_um: Floats
    u_V: Floats
    noise_um: float = SENSOR_NOISE_UM
    noise_V: float = 0.0
    burst_every: int = 0
    burst_length: int = 0
    spike_every: int = 0


def excitations(stage: Stage) -> Mapping[str, Excitation]:
    """Every excitation by its name in CASES, between LOW_V and HIGH_V."""
    t_s = TS_S * np.arange(2 * SECOND)
    middle, half = 0.5 * (LOW_V + HIGH_V), 0.5 * (HIGH_V - LOW_V)
    sine = middle + 0.9 * half * np.sin(2.0 * np.pi * 100.0 * t_s)
    triangle = middle + 0.9 * half * (2.0 * np.abs(2.0 * ((0.5 * t_s) % 1.0) - 1.0) - 1.0)
    clipped = np.clip(middle + 8.0 * half * np.sin(2.0 * np.pi * 50.0 * t_s), LOW_V, HIGH_V)
    rest = np.full(2 * SECOND, middle)
    moving = _periodic_response(stage, sine)
    level = float(moving[0].mean())
    return {
        "constant": Excitation("constant input", *_periodic_response(stage, rest)),
        "noise": Excitation("pure noise in both signals", np.full(SECOND, level), np.full(SECOND, middle), 0.3, 10.0),
        "sine": Excitation("single sine, 100 Hz", *moving),
        "triangle": Excitation("slow triangle, 0.5 Hz", *_periodic_response(stage, triangle)),
        "bursts": Excitation("sine, bursts of NaN and infinities", *moving, burst_every=1009, burst_length=16),
        "spikes": Excitation("sine, spikes of 1e30", *moving, spike_every=997),
        "saturation": Excitation("alternating saturation, 50 Hz", *_periodic_response(stage, clipped)),
    }


def persistent_excitation(seed: int, seconds: float = 1.0) -> Floats:
    """Persistent excitation in V: periods of 100 Hz from LOW_V upwards, each with another random amplitude."""
    rng = np.random.default_rng(seed)
    amplitudes = 0.5 * (HIGH_V - LOW_V) * rng.uniform(0.15, 1.0, 12)
    amplitudes[[0, -1]] = 0.5 * (HIGH_V - LOW_V)
    k = np.arange(round(seconds * SECOND))
    samples = SECOND // 100
    return np.asarray(LOW_V + amplitudes[(k // samples) % 12] * (1.0 - np.cos(2.0 * np.pi * k / samples)))


def measured(stage: Stage, u_V: Floats, seed: int) -> Floats:
    """The sensor's readings under the input u_V, (n,) in um."""
    return run(stage, u_V, TS_S, seed).displacement_um


def _periodic_response(stage: Stage, u_V: Floats) -> tuple[Floats, Floats]:
    """The second of two noise-free periods and its input, (n,) each, so that repetitions join without a jump."""
    displacement = run(stage.quiet(), np.concatenate([u_V, u_V]), TS_S).displacement_um
    return displacement[u_V.size :], u_V


Floats32 = NDArray[np.float32]

FASTEST_CLOCK_HZ: Final = 3e9
"""A clock at which every learner fits into its sample period: the host has no cycle budget."""

CHECK_EVERY: Final = 64
"""Samples between two checks of the factors."""
CHUNK: Final = 1 << 20

_DECLARATIONS = """
typedef struct {{
    const float *y_um; const float *u_V; uint64_t period; float noise_um; float noise_V;
    uint64_t burst_every; uint64_t burst_length; uint64_t spike_every;
}} endurance_excitation_t;
typedef struct {{
    uint64_t samples; uint64_t random_state; uint64_t broken_at;
    float least_d; float largest_d; float largest_u; float largest_theta;
}} endurance_extremes_t;
void hysgen_endurance_run({name}_learner_t *learner, const endurance_excitation_t *excitation,
    endurance_extremes_t *extremes, uint64_t samples, uint64_t check_every);
"""


class CompiledLearner:
    """The compiled learner of `model` with the endurance driver of templates/endurance.c.j2.

    instance, learner: the generated structs. extremes: the driver's record of the factors. numbers: its bounds.
    Raises ModelError or CertificateError if no learner can be generated, BuildError if the compiler rejects the C.
    """

    def __init__(self, model: Model, toolchain: Toolchain | None = None) -> None:
        self.model = model
        texts = generate(model, Options(clock_Hz=FASTEST_CLOCK_HZ))
        code = list(c_files(texts).items())
        facts = {"name": model.name, "NAME": model.name.upper()}
        driver = ("endurance.c", render("endurance.c.j2", facts))
        declared = interface_of(model.name, texts).declarations() + _DECLARATIONS.format(name=model.name)
        self._library: Library = build([*code, driver], declared, toolchain)
        self.numbers = learner_numbers(model, coefficients(model))
        ffi = self._library.ffi
        self.instance: Any = ffi.new(f"{model.name}_t *")
        self.learner: Any = ffi.new(f"{model.name}_learner_t *")
        self.extremes: Any = ffi.new("endurance_extremes_t *")

    def start(self, y_um: float, u_V: float) -> None:
        """Initialise instance and learner at rest at y_um under u_V, and the extremes."""
        self._function("init")(self.instance, y_um, u_V)
        self._function("learn_init")(self.learner, self.instance)
        self.extremes.samples, self.extremes.broken_at, self.extremes.random_state = 0, 0, 88172645463325252
        self.extremes.least_d = np.inf
        self.extremes.largest_d = self.extremes.largest_u = self.extremes.largest_theta = 0.0

    def feed(self, excitation: Excitation, samples: int, progress: Callable[[int], None] | None = None) -> None:
        """Feed the next `samples` of the repeated excitation. progress: called with the samples fed so far."""
        ffi = self._library.ffi
        y, u = (np.ascontiguousarray(signal, dtype=np.float32) for signal in (excitation.y_um, excitation.u_V))
        given = ffi.new("endurance_excitation_t *")
        given.y_um, given.u_V, given.period = ffi.from_buffer("float *", y), ffi.from_buffer("float *", u), y.size
        given.noise_um, given.noise_V = excitation.noise_um, excitation.noise_V
        given.burst_every, given.burst_length = excitation.burst_every, excitation.burst_length
        given.spike_every = excitation.spike_every
        done = 0
        while done < samples:
            chunk = min(CHUNK, samples - done)
            self._library.lib.hysgen_endurance_run(self.learner, given, self.extremes, chunk, CHECK_EVERY)
            done += chunk
            if progress is not None:
                progress(done)

    def commit(self) -> int:
        """Call `<name>_commit` until it is no longer BUSY: COMMITTED, TRYING, or the reason of the refusal."""
        while True:
            answer = int(self._function("commit")(self.instance, self.learner))
            if answer:
                return answer

    def shadow(self) -> Model:
        """The model with the learner's shadow parameters, in float64."""
        theta = np.array(list(self.learner.theta)) + np.array(list(self.learner.theta_low))
        return learned_model(self.model, coefficients(self.model), self.numbers, theta)

    def active(self) -> Model:
        """The model with the parameters of the instance's active bank, in float64."""
        bank, strength = self.instance.bank[self.instance.active], coefficients(self.model).fold.astype(np.float64)
        columns = [np.array(list(group)) / strength for group in (bank.slope, bank.gain, bank.offset)]
        weights = np.array(list(bank.weight)) if self.model.terms else np.zeros(0)
        return self.model.with_parameters(np.concatenate([np.column_stack(columns).ravel(), weights]))

    def _function(self, name: str) -> Any:
        return getattr(self._library.lib, f"{self.model.name}_{name}")


FIT_SEED, RECOVERY_SEED, VALIDATION_SEED = 3, 1, 2
VALIDATION_S: Final = 0.4


def bench_model(stage: Stage, rules: int = 6) -> Model:
    """The model of the tested learner, fitted to one second of persistent excitation of the stage."""
    u_V = persistent_excitation(FIT_SEED)
    return _fitted(measured(stage, u_V, FIT_SEED), u_V, rules)


class Recovery:
    """One second of persistent excitation of a stage, and a shorter validation record of another seed.

    The reference fits minimise the one-step error, as the learner does, in float64: one with the learner's forgetting,
    one with equal weights.
    """

    def __init__(self, stage: Stage, rules: int) -> None:
        u_V = persistent_excitation(RECOVERY_SEED)
        self._excitation = Excitation("persistent excitation", measured(stage, u_V, RECOVERY_SEED), u_V, noise_um=0.0)
        self._validation_V = persistent_excitation(VALIDATION_SEED, VALIDATION_S)
        self._validation_um = measured(stage, self._validation_V, VALIDATION_SEED)
        self._rules = rules
        self._fit_rms_um = lru_cache(maxsize=None)(self._compute_fit_rms_um)

    def ratios(self, learner: CompiledLearner, forgetting: float) -> tuple[float, float]:
        """Feed the second; the learner's free-run rms divided by that of each fit, infinite if a factor is broken."""
        learner.feed(self._excitation, SECOND)
        if learner.extremes.broken_at:
            return np.inf, np.inf
        learned = self._free_run_rms_um(learner.shadow())
        return learned / self._fit_rms_um(forgetting), learned / self._fit_rms_um(1.0)

    def _compute_fit_rms_um(self, forgetting: float) -> float:
        return self._free_run_rms_um(_fitted(self._excitation.y_um, self._excitation.u_V, self._rules, forgetting))

    def _free_run_rms_um(self, model: Model) -> float:
        """rms error of the free run over the validation record; infinite if the run is not finite."""
        with np.errstate(all="ignore"):
            run = simulate(model, Drive(self._validation_V, TS_S), float(self._validation_um[0]))
            rms = float(np.sqrt(np.mean((run.y_um - self._validation_um) ** 2)))
        return rms if np.isfinite(rms) else np.inf


def _fitted(y_um: Floats, u_V: Floats, rules: int, forgetting: float = 1.0) -> Model:
    """Batch least squares over y_um and u_V, (n,) each; the grid extends the range by 1 % at each end."""
    record = Record.from_arrays(u_V, y_um, TS_S, source="endurance")
    settings = FitSettings(name="bench", rules=rules, method="batch", margin=0.01, forgetting=forgetting)
    return fit(record, settings)
