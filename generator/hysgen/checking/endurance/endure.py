"""The compiled learner of a model under a case: fed without end, looked at, and put back to work."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from hysgen.checking.endurance.cases import Case
from hysgen.checking.host import declarations
from hysgen.codegen import Options, generate
from hysgen.codegen.render import render
from hysgen.float32.coefficients import coefficients
from hysgen.float32.learner_numbers import learned_model, learner_numbers
from hysgen.machine.native import Library, Toolchain, build
from hysgen.model.model import Model

Floats = NDArray[np.float64]
Floats32 = NDArray[np.float32]

FASTEST_CLOCK_HZ: Final = 3e9
"""The host is not bound to the DSP's budget."""

LOOK_EVERY: Final = 64
PIECE: Final = 1 << 20

_DECLARATIONS = """
typedef struct {{
    const float *y_um; const float *u_V; uint64_t period; float noise_um; float noise_V;
    uint64_t burst_every; uint64_t burst_length; uint64_t spike_every;
}} endurance_case_t;
typedef struct {{
    uint64_t samples; uint64_t noise; uint64_t broken_at;
    float least_d; float largest_d; float largest_u; float largest_theta;
}} endurance_tally_t;
void endurance_run({name}_learner_t *learner, const endurance_case_t *is, endurance_tally_t *tally, uint64_t samples,
    uint64_t look_every);
"""


class Endurance:
    """The compiled learner of `model`, with an endurance driver around it.

    Raises ModelError or CertificateError if no learner can be generated, BuildError if no compiler takes it.
    """

    def __init__(self, model: Model, toolchain: Toolchain | None = None) -> None:
        self.model = model
        texts = generate(model, Options(clock_Hz=FASTEST_CLOCK_HZ))
        code = [(file, text) for file, text in texts.items() if file.endswith((".c", ".h"))]
        facts = {"name": model.name, "NAME": model.name.upper()}
        driver = ("endurance.c", render("endurance.c.j2", facts))
        told = declarations(texts[f"{model.name}.h"]) + _DECLARATIONS.format(name=model.name)
        self._library: Library = build([*code, driver], told, toolchain)
        self.numbers = learner_numbers(model, coefficients(model))
        ffi = self._library.ffi
        self.instance: Any = ffi.new(f"{model.name}_t *")
        self.learner: Any = ffi.new(f"{model.name}_learner_t *")
        self.tally: Any = ffi.new("endurance_tally_t *")

    def begin(self, y_um: float, u_V: float) -> None:
        """A new learner at rest at y_um under u_V."""
        self._function("init")(self.instance, y_um, u_V)
        self._function("learn_init")(self.learner, self.instance)
        self.tally.samples, self.tally.broken_at, self.tally.noise = 0, 0, 88172645463325252
        self.tally.least_d = np.inf
        self.tally.largest_d = self.tally.largest_u = self.tally.largest_theta = 0.0

    def feed(self, case: Case, samples: int, progress: Callable[[int], None] | None = None) -> None:
        """The next `samples` of `case`; progress is told how many are done, now and then."""
        ffi = self._library.ffi
        y, u = (np.ascontiguousarray(signal, dtype=np.float32) for signal in (case.y_um, case.u_V))
        is_ = ffi.new("endurance_case_t *")
        is_.y_um, is_.u_V, is_.period = ffi.from_buffer("float *", y), ffi.from_buffer("float *", u), y.size
        is_.noise_um, is_.noise_V = case.noise_um, case.noise_V
        is_.burst_every, is_.burst_length, is_.spike_every = case.burst_every, case.burst_length, case.spike_every
        done = 0
        while done < samples:
            piece = min(PIECE, samples - done)
            self._library.lib.endurance_run(self.learner, is_, self.tally, piece, LOOK_EVERY)
            done += piece
            if progress is not None:
                progress(done)

    def commit(self) -> int:
        """Call `_commit` until it answers: COMMITTED, or the reason for its refusal."""
        while True:
            answer = int(self._function("commit")(self.instance, self.learner))
            if answer:
                return answer

    def shadow(self) -> Model:
        """The model with the shadow parameters, in float64."""
        theta = np.array(list(self.learner.theta)) + np.array(list(self.learner.theta_low))
        return learned_model(self.model, coefficients(self.model), self.numbers, theta)

    def active(self) -> Model:
        """The model with the parameters that are active in the instance, in float64."""
        bank, strength = self.instance.bank[self.instance.active], coefficients(self.model).fold.astype(np.float64)
        columns = [np.array(list(group)) / strength for group in (bank.slope, bank.gain, bank.offset)]
        weights = np.array(list(bank.weight)) if self.model.terms else np.zeros(0)
        return self.model.with_parameters(np.concatenate([np.column_stack(columns).ravel(), weights]))

    def _function(self, name: str) -> Any:
        return getattr(self._library.lib, f"{self.model.name}_{name}")
