"""The programs that Eva analyses: one call from any state of the box, checks of the state after it.

A call of learn is analysed in two parts. First what an update does to the shadow, from any bits at all: which words it
writes, and that the shadow starts again unless every parameter is finite and inside its limit. Then the whole call with
that as contracts.
"""

import dataclasses
from collections.abc import Mapping, Sequence
from typing import Final

from hysgen.certify.certificates import certify
from hysgen.checking.proof.eva.boxes import (
    PARAMETERS,
    REMAINDERS,
    WILD,
    LearnerBox,
    committed_gain_annotation,
    hexadecimal,
    learner_box,
)
from hysgen.checking.proof.eva.frama import (
    LOOKED_AT,
    WRITES,
    Floats,
    Verdict,
    analyse,
    beyond_contract,
    hooked,
    parameters,
    update_cases,
    update_contracts,
    update_functions,
    within,
)
from hysgen.checking.proof.eva.states import (
    ANY_WORD,
    Join,
    Split,
    assumed,
    bank_words,
    between,
    case_lines,
    displacements,
    float_word,
    instance_words,
    integer_word,
    signs,
    splits,
)
from hysgen.codegen.render import render
from hysgen.codegen.structs import interface_of
from hysgen.float32.coefficients import coefficients, commit_numbers
from hysgen.float32.learner_numbers import bank_box, learner_numbers
from hysgen.model.intervals import ANY, symmetric
from hysgen.model.model import Model

ENTRY: Final = "step.c"

FUNCTIONS: Final = {"init": 2, "predict": 2, "simulate": 1, "limits": 3, "inverse": 2, "correct": 1, "aux": 0}
"""Functions of an instance and the number of their float arguments."""


JOINS: Final = (Join("span"), Join("allowed"))
"""Merges of the cases of a voltage and its limits, of which the interval of the voltage is all that matters later."""

FINITE_CHECKED: Final[Mapping[str, Sequence[str]]] = {
    f"is_finite: {word}": [rf"    //@ check finite: \is_finite({word});"] for word in ("finite", "y", "u_finite")
}
"""A check behind the replacement of non-finite inputs, by hook: the number is finite for every input.

If these checks hold, the proof for finite inputs covers the rest of the call.
"""


def functions(model: Model, texts: Mapping[str, str]) -> tuple[str, ...]:
    """The functions of an instance that the generated header declares."""
    known = interface_of(model.name, texts)
    return tuple(function for function in FUNCTIONS if known.has(function))


def step(model: Model, texts: Mapping[str, str], function: str, inputs: Floats) -> tuple[dict[str, str], int]:
    """The C that Eva analyses for one call, and the number of its checks.

    inputs: every finite float, or any 32 bits. Raises ModelError for a state without a box.
    """
    name, known = model.name, instance_words(model, texts)
    banks = [] if function == "init" else bank_words(model)
    floats = {"finite": between(ANY), "any": f"{name}_float({ANY_WORD})"}
    lines: dict[str, Sequence[str]] = {**case_lines(splits(model), JOINS)}
    if inputs == "any":
        lines |= FINITE_CHECKED
    if function == "inverse" and banks:
        lines |= {"inverse: sums": [committed_gain_annotation(model)]}
    source = hooked(model, texts, lines)
    facts = {
        "name": name,
        "function": function,
        "words": [*banks, *known],
        "inputs": FUNCTIONS[function],
        "channels": len(model.channels) if function == "aux" else 0,
        "input": floats[inputs],
        "result": "float" if function in ("predict", "simulate", "inverse", "correct") else "",
    }
    checks = sum(word.demanded != "" for word in known) + (facts["result"] == "float")
    return {**texts, f"{name}.c": source, ENTRY: render("proof/step.c.j2", facts)}, checks


def prove_call(model: Model, texts: Mapping[str, str], function: str, inputs: Floats) -> tuple[Verdict, int]:
    """Eva's verdict on one call, and the number of checks that a complete analysis reaches."""
    sources, checks = step(model, texts, function, inputs)
    return analyse(sources, ENTRY, inputs), checks


def commit_step(model: Model, texts: Mapping[str, str]) -> tuple[dict[str, str], int]:
    """The C that Eva analyses for one call of commit, and the number of its checks.

    The learner's parameters and its candidate are in their boxes before the call; the checks demand the boxes of both
    banks after it. In the phase of checking, the index of the next check point is below their number.
    """
    name, numbers = model.name, learner_numbers(model, coefficients(model))
    points = commit_numbers(model, coefficients(model), certify(model)).points
    limit, banks = float(numbers.limit_um), bank_box(model)
    boxes = {f"{path}[{j}]": symmetric(limit) for path in PARAMETERS for j in range(numbers.size)}
    boxes |= {f"candidate.bank.{path}": box for path, box in banks.items()}
    boxes |= {f"base.{path}": box for path, box in banks.items()}
    boxes |= {
        path: symmetric(REMAINDERS) for path in ("candidate.gain_remainder_um_per_V", "candidate.slope_remainder[0]")
    }
    boxes |= {"candidate.slope_remainder[1]": symmetric(REMAINDERS)}
    known = [float_word("learner", path, box) for path, box in boxes.items()]
    known += [float_word("self", f"bank[{b}].{path}", box) for b in range(2) for path, box in banks.items()]
    known += [integer_word("self", "active", 1), integer_word("learner", "candidate.phase", 4)]
    known += [integer_word("learner", path) for path in ("age", "trying", "updates")]
    levels = [level for level in learner_box(model).levels if level.path.startswith("trial_")]
    known += [float_word("learner", level.path, level.box) for level in levels]
    facts = {"name": name, "words": known, "points": points}
    # Checked at the return of commit, where the cases are still separate.
    unfinished = f"/*@ check ensures left: learner->candidate.phase == 1 ==> learner->candidate.point < {points}; */"
    lines = case_lines([*splits(model), *_commit_splits(name)]) | {"commit: contract": [unfinished]}
    source = hooked(model, texts, lines | beyond_contract(name))
    checks = sum(word.demanded != "" for word in known) + 1
    return {**texts, f"{name}.c": source, ENTRY: render("proof/commit.c.j2", facts)}, checks


def prove_commit(model: Model, texts: Mapping[str, str]) -> tuple[Verdict, int]:
    """Eva's verdict on one call of commit, and the number of checks that a complete analysis reaches."""
    sources, checks = commit_step(model, texts)
    options = ["-eva-use-spec", f"{model.name}_beyond", "-eva-split-return-function", f"{model.name}_snapshot:0"]
    return analyse(sources, ENTRY, "finite", options=options), checks


def _commit_splits(name: str) -> list[Split]:
    return [
        Split("size", signs("x")),
        *(Split(function, signs(x)) for function in ("lesser", "greater") for x in ("a", "b")),
        Split("lesser", ("b < a",)),
        Split("greater", ("b <= a",)),
        Split("commit: point", (f"candidate->point < {name.upper()}_COMMIT_POINTS",)),
    ]


def learn_step(model: Model, texts: Mapping[str, str], function: str) -> tuple[dict[str, str], int]:
    """The C that Eva analyses for one call of learn_init, learn_aux or learn, and the number of its checks.

    Inputs are any 32 bits; learn_init has none, but a model in any state and with any bank that may be committed.
    """
    name, box = model.name, learner_box(model)
    struct = interface_of(name, texts).struct(f"{name}_learner_t")
    found = [
        word
        for word in struct.words()
        if word.path.split("[")[0] not in WILD and not word.path.startswith(("candidate.", "base."))
    ]
    known = assumed("learner", struct.name, found, box.floats, box.integers)
    # The bank that the learner started from: any that may have been committed before learn_init.
    if any(word.path.startswith("base.") for word in struct.words()):
        known += [float_word("learner", f"base.{path}", bank) for path, bank in bank_box(model).items()]
    facts = {
        "name": name,
        "function": function,
        "model_words": [*bank_words(model), *instance_words(model, texts)],
        "words": known,
        "channels": len(model.channels),
        "wild": [member.name for member in struct.members if member.name in WILD and member.sizes],
        "scalars": ["per_alpha"],
        "any": f"{name}_float({ANY_WORD})",
    }
    lines = case_lines([*splits(model), *_learn_splits(model)], _joins(model, box))
    source = hooked(model, texts, {**lines, **FINITE_CHECKED, **update_contracts(model, texts)})
    checks = sum(word.demanded != "" for word in known)
    return {**texts, f"{name}.c": source, ENTRY: render("proof/learn.c.j2", facts)}, checks


def prove_learn(model: Model, texts: Mapping[str, str], function: str) -> tuple[Verdict, int]:
    """Eva's verdict on a call of learn_init, learn_aux or learn, and the number of checks of a complete analysis."""
    sources, checks = learn_step(model, texts, function)
    name = model.name
    trusted = [f"{name}_{function}" for function in update_functions(model, texts)]
    apart = ",".join(f"{name}_{answers}" for answers in ("update_diagonal:0:2", "update:0", "evaluate_reading:0"))
    options = ("-eva-use-spec", ",".join(trusted), "-eva-split-return-function", apart)
    return analyse(sources, ENTRY, "finite" if function == "learn_init" else "any", options=options), checks


def update_step(model: Model, texts: Mapping[str, str]) -> tuple[dict[str, str], int]:
    """The C that Eva analyses for what one update does to the shadow, and the number of its checks."""
    name = model.name
    functions = update_functions(model, texts)
    source = hooked(model, texts, beyond_contract(name) | update_cases(model))
    kept = [within(name, f"learner.theta[{j}]") for j in range(parameters(name, texts))]
    facts = {
        "name": name,
        "looked_at": LOOKED_AT,
        "functions": [f"{name}_{function}" for function in functions if function != "step"],
        "kept": kept,
    }
    return {**texts, f"{name}.c": source, ENTRY: render("proof/update.c.j2", facts)}, 2 * len(kept)


def prove_update(model: Model, texts: Mapping[str, str]) -> tuple[Verdict, int]:
    """Eva's verdict on an update, and the number of checks that a complete analysis reaches.

    A write of a function to a word of the learner that its contract does not list counts as an alarm.
    """
    name = model.name
    sources, checks = update_step(model, texts)
    options = ("-eva-use-spec", f"{name}_beyond", "-eva-split-return", "full", "-out-external")
    verdict = analyse(sources, ENTRY, "any", options=options)
    alarms = list(verdict.alarms)
    for function in update_functions(model, texts):
        more = sorted(verdict.fields(f"{name}_{function}", "learner") - set(WRITES[function]))
        alarms += [f"{name}_{function}: writes {', '.join(more)}: not in its contract"] if more else []
    return dataclasses.replace(verdict, alarms=tuple(alarms)), checks


def _learn_splits(model: Model) -> list[Split]:
    return [
        Split("learn: y", _plausible(model)),
        Split("store_regressors: y", displacements(coefficients(model))),
        Split("restart_needed", signs("moved")),
        Split("begin: sliding", ("sliding == 0u",)),
        Split("admit: e", signs("e")),
        Split("limited", ("x <= high",)),
    ]


def _joins(model: Model, box: LearnerBox) -> list[Join]:
    """Places where cases are merged; the cases of the mean input and of `usable` stay separate to the end."""
    levels = {level.path: level for level in box.levels}
    low, high = (hexadecimal(end) for end in (model.u_min_V, model.u_max_V))
    return [
        Join("learn: away", kept=(f"self->mean_u_V < {low}", f"self->mean_u_V <= {high}", "usable")),
        Join("learn: update"),
        Join("learn: fresh"),
        *(
            Join(f"restart_needed: {path}", levels[path].borders)
            for path in ("moving_um", "error", "reference_error", "step_error")
        ),
        *(Join(f"try: {path}", levels[path].borders) for path in ("trial_error", "trial_reference_error")),
        Join("restart_needed: return"),
        Join("admit: scale", levels["scale_um"].borders),
        Join("admit: run"),
        Join("store_regressors: x"),
    ]


def _plausible(model: Model) -> tuple[str, ...]:
    upper = model.name.upper()
    return (f"y < {upper}_LEARN_Y_LOW_UM", f"y <= {upper}_LEARN_Y_HIGH_UM")
