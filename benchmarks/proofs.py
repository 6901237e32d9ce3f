"""What `hysgen prove --only equal` says of many models, and of planted faults.

python benchmarks/proofs.py models --random 200   proved or not, time, memory, equalities of the solver, by kind
python benchmarks/proofs.py models --first 100    the same of the random models 100 .. 199 alone, to go on with
python benchmarks/proofs.py kernels               the same of the kernels of the models that are named
python benchmarks/proofs.py faults                every fault planted alone: all are found

A fault is a text that stands in the generated C, in the source of the reference (FAULTS) or in the assembly of the
kernels (tests/fixtures/c674x_kernels.py), and the text in its place.
Every proof has a process of its own, so that time and memory are its own and a changed reference ends with it.
"""

from __future__ import annotations

import argparse
import dataclasses
import importlib.util
import sys
from collections import Counter, defaultdict
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, Final

from own_process import alone

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

EVERY: Final = ()
"""Every function that is generated."""
STATES: Final = 44
"""States of the chain of modes that stands beside the models of the tests: 22 modes of two states."""

LEARNER, PAPER, EXTENDED, CHANNELS = "sized 6", "shipped appendix_a", "shipped extended", "paper small_everything"
FAULTS: Final[Mapping[str, Sequence[tuple[str, str, str, str]]]] = {
    # module below hysgen, "" for the C: model, function, its text, text in its place
    "": (
        (LEARNER, "learn_init", "self->reference[3u * l] = ", "self->reference[3u * l] = 2.0f * "),
        (LEARNER, "commit", "+ candidate->gain_remainder_um_per_V;", ";"),
        (LEARNER, "commit", "(change + remainder)", "change"),
        (LEARNER, "commit", "gain - away <=", "gain - 0.99f * away <="),
        (LEARNER, "commit", "= 1u - self->active;", "= 1u;"),
        (LEARNER, "commit", "(candidate->point >= SMOOTH_2", "(candidate->point + 1u >= SMOOTH_2"),
        (LEARNER, "commit", "learner->reference[j] = learner->trial[j];", "learner->reference[j] = learner->trial[0];"),
        (LEARNER, "commit", "trial_error > learner->trial", "trial_error >= learner->trial"),
        (LEARNER, "commit", "(learner->updates != 0u) ?", "(learner->age != 0u) ?"),
        (LEARNER, "learn", "copy + self->x[j] * self->trial[j]", "copy + self->x[j] * self->theta[j]"),
        (LEARNER, "learn", "_limited(reference, -limit, limit", "_limited(reference, -limit, 2.0f * limit"),
        (
            LEARNER,
            "commit",
            "beyond |= smooth_2_beyond(learner->theta[j]);",
            "beyond |= smooth_2_beyond(learner->theta[0]);",
        ),
        (
            LEARNER,
            "commit",
            "bank->gain[l] = learner->",
            "bank->gain[l] = (l == 1u) ? learner->base.gain[l] : learner->",
        ),
        (LEARNER, "learn", "self->theta_low[j] = carried - (sum - theta);", "self->theta_low[j] = 0.0f;"),
        (LEARNER, "learn", "self->turn = (j + 1u <", "self->turn = (j + 2u <"),
        (LEARNER, "learn", "f[i] = f[i] + self->x[i];", "f[i] = f[i] * 1.0000001f + self->x[i];"),
        (LEARNER, "learn", "1u ^ (y_lost | implausible);", "1u ^ y_lost;"),
        (LEARNER, "learn", "    if (lost != 0u) {", "    if (lost > 1u) {"),
        (
            LEARNER,
            "learn",
            "_FACTORS; ++i) {\n        self->u[i] = 0.0f;",
            "_FACTORS - 1u; ++i) {\n        self->u[i] = 0.0f;",
        ),
        (PAPER, "predict", "(base + u * gain) * per_weight", "base * per_weight + u * gain * per_weight"),
        (PAPER, "predict", "r = r * (2.0f - x * r);\n\n    return", "return"),
        (PAPER, "init", "(appendix_a_bits(high) & lower)", "(appendix_a_bits(x) & lower)"),
        (PAPER, "predict", "(uint32_t)(magnitude >= 0x7f800000u)", "0u"),
        (PAPER, "init", "bits & keep & ~hold", "bits & ~hold"),
        (PAPER, "init", "u_clamped * APPENDIX_A_STATUS_U_CLAMPED", "u_clamped * APPENDIX_A_STATUS_Y_CLAMPED"),
        (PAPER, "inverse", "| (unreachable * APPENDIX_A_STATUS_UNREACHABLE)", ""),
        (PAPER, "predict", "counter + (happened & (uint32_t)(counter < UINT32_MAX))", "counter + happened"),
        (PAPER, "predict", "&self->bank[self->active]", "&self->bank[0]"),
        (PAPER, "predict", "    self->u_V = u;\n", ""),
        (PAPER, "predict", "0.240226477f", "0.240226492f"),
        (EXTENDED, "predict", "self->play[1] = z1;", "self->play[1] = z2;"),
        (EXTENDED, "predict", "self->low[0] = extended_lost(high0, t0);", "self->low[0] = 0.0f;"),
        (
            EXTENDED,
            "predict",
            "extended_apply(self, base, sums.gain, per_weight, w)",
            "extended_apply(self, base, sums.gain, per_weight, u)",
        ),
        (CHANNELS, "aux", "(small_everything_mask(clamped) &", "(small_everything_mask(rejected) &"),
        (CHANNELS, "aux", "inside - small_everything_coupling_middle[c]", "inside - small_everything_coupling_low[c]"),
    ),
    "float32.reference.instance": (
        (
            PAPER,
            "predict",
            "((y_um * sums.slope + sums.offset) + w * sums.gain)",
            "(y_um * sums.slope + (sums.offset + w * sums.gain))",
        ),
        (PAPER, "inverse", "y_next_um * sums.weight - (y_um", "y_next_um * sums.gain - (y_um"),
        (PAPER, "predict", "np.where(magnitude < LEAST_BITS", "np.where(magnitude <= LEAST_BITS"),
        (PAPER, "predict", "magnitude >= np.uint32(INFINITY_BITS)", "magnitude > np.uint32(INFINITY_BITS)"),
        (PAPER, "predict", "below, above = x < low, x > high", "below, above = x < low, x >= high"),
        (
            PAPER,
            "predict",
            "(y_um - numbers.origin_um) * numbers.per_step)",
            "y_um * numbers.per_step - numbers.origin_um * numbers.per_step)",
        ),
        (PAPER, "limits", "limited(high, self.low_V,", "limited(high, numbers.u_min_V,"),
        (PAPER, "simulate", "y, clamped = limited(self.y_um, ", "y, clamped = limited(-self.y_um, "),
        (PAPER, "inverse", "rejected | refused", "rejected & refused"),
        (EXTENDED, "predict", "w = self.inputs.apply(u)\n        return", "w = u\n        return"),
    ),
    "model.path.channels": ((CHANNELS, "aux", "np.where(value > high, high, value)", "value"),),
    "float32.reference.commit": (
        (LEARNER, "commit", "self.point >= self.numbers.points", "self.point > self.numbers.points"),
        (LEARNER, "commit", "gain - away <= numbers.gain_floor", "gain - away < numbers.gain_floor"),
        (LEARNER, "commit", "np.where(worse, np.uint32(Phase.I", "np.where(done, np.uint32(Phase.I"),
        (LEARNER, "commit", "curve + b[2] * u", "curve - b[2] * u"),
    ),
    "float32.reference.learner": (
        (LEARNER, "learn_init", "self._number(i) * self.numbers.scale[i]", "self._number(i)"),
        (LEARNER, "learn", "before = before + f[j] * g[j]", "before = before + f[j] * f[j]"),
        (LEARNER, "learn", "on_grid(column + k[:j] * slope[j], FACTOR_GRID)", "column + k[:j] * slope[j]"),
        (LEARNER, "learn", "e * e > limit * limit * alpha", "e * e >= limit * limit * alpha"),
        (LEARNER, "learn", "magnitude(away) < numbers.rest_V", "magnitude(away) <= numbers.rest_V"),
    ),
}


@dataclasses.dataclass(frozen=True)
class Judged:
    """What the proof says of a model: answer by function, equalities of the solver by kind and its time, time, MB."""

    answers: dict[str, str]
    solved: Counter[str]
    solver_s: float
    seconds: float
    MB: float


def model_of(name: str) -> tuple[Any, Any]:
    """A model by kind and name, and its C, which no fault has touched; that of a random model may have no inverse."""
    from fixtures import drawn_models, generated_models, learner_bench, proof_models
    from hysgen.codegen import Options, generate
    from hysgen.errors import CertificateError

    kind, _, argument = name.partition(" ")
    if kind == "shipped":
        folder = proof_models.shipped(argument)
        return folder.model, dict(folder.texts)
    makers: dict[str, Callable[[], Any]] = {
        "sized": lambda: learner_bench.sized(int(argument)),
        "random": lambda: drawn_models.random_model(int(argument)),
        "largest": generated_models.path,
        "structure": structure,
    }
    model = makers[kind]() if kind in makers else proof_models.model(argument)
    options = Options(clock_Hz=1e10)  # the proof is of any clock
    try:
        return model, generate(model, options)
    except CertificateError as error:
        if kind != "random":
            raise
        print(f"{name}, without the inverse: {error}")
        return model, generate(model, dataclasses.replace(options, inverse=False))


def structure() -> Any:
    """Two rules behind a chain of STATES / 2 modes."""
    import numpy as np

    from fixtures.generated_models import smooth
    from hysgen.model.path.structure import Structure

    modes = STATES // 2
    f_Hz = tuple(np.linspace(150.0, 2100.0, modes).tolist())
    shares = tuple((0.4 / modes * (-1.0) ** np.arange(modes)).tolist())
    block = Structure(f_Hz, (0.02,) * modes, shares, 4e-4, (0.0,) * modes, 2e-5)
    return dataclasses.replace(smooth(2), name="structure_44", blocks=(block,))


def scheduled(name: str, fault: tuple[str, str] | None = None, place: float = 0.0) -> Any:
    """A task for `alone`: the proof of the kernels of a model, with an instruction changed in their assembly."""
    from fixtures.c674x_kernels import changed
    from hysgen.codegen import Options, generate
    from hysgen_c674x.schedule.folder import assembly_file, kernels, with_kernels
    from hysgen_c674x.schedule.proof import kernel_proofs

    model, _ = model_of(name)
    texts = generate(model, Options(clock_Hz=1e10, aligned=True))
    texts = with_kernels(model.name, texts, kernels(model.name, texts))
    if fault is not None:
        texts[assembly_file(model.name)] = changed(texts[assembly_file(model.name)], fault, place)
    return lambda: said(kernel_proofs(model, texts))


def said(result: Any) -> tuple[dict[str, str], Counter[str], float]:
    """The answers by function, the equalities that the solver decided, by kind, and in how many seconds."""
    proofs = result.functions
    answers = {proof.function: "proved" if proof.holds else proof.line() for proof in proofs}
    solved = sum((Counter(proof.by_kind) for proof in proofs), Counter[str]())
    return answers, solved, sum(proof.solver_s for proof in proofs)


def prepared(name: str, functions: Sequence[str], change: tuple[str, str] = ("", ""), module: str = "") -> Any:
    """A task for `alone`: the proof of a model, with a text changed in its C or in a module of the reference."""
    if module:
        _reference_with(f"hysgen.{module}", change)
    from hysgen.checking.proof.translation import translation

    model, texts = model_of(name)
    if change[0] and not module:
        source = f"{model.name}.c"
        assert change[0] in texts[source], f"the fault has nothing to bite on: {change[0]}"
        texts[source] = texts[source].replace(*change)

    return lambda: said(translation(model, texts, calls=functions))


def _reference_with(name: str, change: tuple[str, str]) -> None:
    """Put a changed module of the reference in the place of the module, before anything has imported it."""
    spec = importlib.util.find_spec(name)
    assert spec is not None
    assert spec.origin is not None
    text = Path(spec.origin).read_text(encoding="utf-8")
    assert change[0] in text, f"the fault has nothing to bite on: {change[0]}"
    assert name not in sys.modules
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    exec(compile(text.replace(change[0], change[1], 1), spec.origin, "exec"), module.__dict__)


def judged(*arguments: Any, task: Callable[..., Any] = prepared) -> Judged:
    """The answer of `prepared`, or of `scheduled`, in a process of its own."""
    done = alone(task, *arguments)
    return Judged(*done.value, done.seconds, done.MB)


LISTED: Final = (
    "shipped appendix_a",
    "paper appendix_b",
    "shipped extended",
    "largest path",
    "structure 44",
    "sized 18",
    "sized 24",
)


def models(first: int, random: int, of_kernels: bool = False) -> None:
    """Print a row for each model, and the sums of each kind."""
    drawn = [f"random {seed}" for seed in range(first, random)]
    kinds: dict[str, list[Judged]] = defaultdict(list)
    for name in LISTED if of_kernels else [*(LISTED if first == 0 else ()), *drawn]:
        result = judged(name, task=scheduled) if of_kernels else judged(name, EVERY)
        open_words = [line for line in result.answers.values() if line != "proved"]
        kinds[name if name in LISTED else "random"].append(result)
        print(
            f"{name}: {len(result.answers) - len(open_words)} of {len(result.answers)} functions proved, "
            f"{result.solved.total()} equalities by the solver in {result.solver_s:.1f} s {dict(result.solved)}, "
            f"{result.seconds:.1f} s, {result.MB:.0f} MB",
            *open_words,
            sep="\n  ",
            flush=True,
        )
    print(f"{'kind':20} models whole functions proved  s_mean  s_most MB_most solved solver_s")
    for kind, results in kinds.items():
        answers = [answer for result in results for answer in result.answers.values()]
        whole = sum(set(result.answers.values()) == {"proved"} for result in results)
        seconds = [result.seconds for result in results]
        print(
            f"{kind:20} {len(results):6} {whole:5} {len(answers):9} {answers.count('proved'):6} "
            f"{sum(seconds) / len(seconds):7.1f} {max(seconds):7.1f} {max(result.MB for result in results):7.0f} "
            f"{sum(result.solved.total() for result in results):6} {sum(result.solver_s for result in results):8.1f}"
        )


def faults() -> int:
    """Print what becomes of each fault; returns how many were not seen."""
    planted = [(fault[0], fault[1], fault[2:], module) for module, found in FAULTS.items() for fault in found]
    from fixtures.c674x_kernels import WRONG

    missed = 0
    for name, function, change, module in planted:
        answer = judged(name, (function,), change, module).answers[function]
        missed += answer == "proved"
        seen = "MISSED" if answer == "proved" else "seen"
        print(f"{seen} in {module or 'the C'}, {name}: {change[0].strip()!r}: {answer}", flush=True)
    wrong = [(fault, place) for fault in WRONG for place in (0.2, 0.7)]
    for fault, place in wrong:
        answers = judged(LEARNER, fault, place, task=scheduled).answers.values()
        missed += set(answers) == {"proved"}
        seen = "MISSED" if set(answers) == {"proved"} else "seen"
        print(f"{seen} in the kernels: {fault[0]}: {[answer for answer in answers if answer != 'proved']}", flush=True)
    places = f"{len(FAULTS[''])} of the C, {len(planted) - len(FAULTS[''])} of the reference, {len(wrong)} of kernels"
    print(f"{len(planted) + len(wrong) - missed} of {len(planted) + len(wrong)} faults found: {places}")
    return missed


def main() -> None:
    """Print the proofs of models, or what becomes of the faults."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("what", choices=["models", "kernels", "faults"])
    parser.add_argument("--random", type=int, default=200, help="number of random models")
    parser.add_argument("--first", type=int, default=0, help="the first of them; with it, no other model is proved")
    arguments = parser.parse_args()
    if arguments.what == "faults":
        sys.exit(min(faults(), 1))
    models(arguments.first, arguments.random, arguments.what == "kernels")


if __name__ == "__main__":
    main()
