"""Proofs by Frama-C Eva of every call of a model, for every input and every state inside its certified box."""

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

from hysgen.checking.proof.eva.calls import functions, prove_call, prove_commit, prove_learn, prove_update
from hysgen.checking.proof.eva.frama import Floats, Verdict, check_contract, version
from hysgen.codegen.structs import interface_of
from hysgen.display import table
from hysgen.errors import ModelError
from hysgen.model.model import Model

LEARNER: Final[Mapping[str, Floats]] = {
    "beyond": "any",
    "update": "any",
    "learn_init": "finite",
    "learn_aux": "any",
    "learn": "any",
    "commit": "finite",
}
"""Inputs of the learner's calls. learn_init and commit have none; the other proofs use those of beyond and update."""


@dataclass(frozen=True)
class Proof:
    """Eva's result of one call; expected: number of checks that an analysis of the whole call reaches.

    operations: places of its C where an operation may be undefined (`Verdict`).
    """

    function: str
    inputs: Floats
    alarms: tuple[str, ...]
    held: int
    checks: int
    expected: int
    seconds: float
    operations: int

    @property
    def holds(self) -> bool:
        return not self.alarms and self.held == self.checks >= self.expected


@dataclass(frozen=True)
class Proofs:
    """The proofs of the calls of a model by the version `tool` of Frama-C."""

    model: str
    tool: str
    proofs: tuple[Proof, ...]

    @property
    def holds(self) -> bool:
        """Whether there are proofs and each holds."""
        return bool(self.proofs) and all(p.holds for p in self.proofs)

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values."""
        return dataclasses.asdict(self) | {"holds": self.holds}

    def lines(self) -> list[str]:
        """The report as text."""
        rows = [
            [p.function, p.inputs, str(p.operations), str(len(p.alarms)), f"{p.held} of {p.checks}", f"{p.seconds:.1f}"]
            for p in self.proofs
        ]
        text = [self.tool, table(["call", "inputs", "operations", "alarms", "checks hold", "s"], rows, left=2)]
        alarms, operations = (
            sum(each) for each in zip(*((len(p.alarms), p.operations) for p in self.proofs), strict=True)
        )
        held, checks = sum(p.held for p in self.proofs), sum(p.checks for p in self.proofs)
        text += [
            f"{len(self.proofs)} analyses: {alarms} alarms at {operations} operations that might be undefined; "
            f"{held} of {checks} checks hold"
        ]
        text += [f"ALARM: {p.function}, {p.inputs} inputs: {alarm}" for p in self.proofs for alarm in p.alarms]
        return [*text, f"{self.model}: {'proved' if self.holds else 'NOT PROVED'}"]


def prove(
    model: Model,
    texts: Mapping[str, str],
    *,
    calls: Sequence[str] = (),
    progress: Callable[[float, str], None] | None = None,
) -> Proofs:
    """Prove every call of a model's generated C, for every finite input and for any 32 bits.

    calls: functions to prove instead of all.
    Raises BuildError if Frama-C is not installed or fails, ModelError if the model holds what the proof does not know
    or has no such call.
    """
    tool = version()
    tasks: list[tuple[str, Floats]] = []
    known = (*functions(model, texts), *learner_functions(model, texts))
    for function in calls or known:
        if function not in known:
            raise ModelError(f"{model.name}: no call {function} to prove; choose among {', '.join(known)}")
        both: tuple[Floats, ...] = ("finite", "any")
        tasks += [(function, inputs) for inputs in ([LEARNER[function]] if function in LEARNER else both)]
    proofs: list[Proof] = []
    for place, (function, inputs) in enumerate(tasks):
        if progress is not None:
            progress(place / len(tasks), f"proving {model.name}_{function}, {inputs} inputs")
        verdict, expected = proved(model, texts, function, inputs)
        held = verdict.held, verdict.checks, expected
        proofs.append(Proof(function, inputs, verdict.alarms, *held, verdict.seconds, verdict.operations))
    return Proofs(model.name, tool, tuple(proofs))


def proved(model: Model, texts: Mapping[str, str], function: str, inputs: Floats) -> tuple[Verdict, int]:
    """The verdict on one call and the number of checks of a complete analysis; `beyond` is run on every float."""
    if function == "beyond":
        return check_contract(model.name, texts), 1
    if function == "update":
        return prove_update(model, texts)
    if function in ("learn_init", "learn_aux", "learn"):
        return prove_learn(model, texts, function)
    if function == "commit":
        return prove_commit(model, texts)
    return prove_call(model, texts, function, inputs)


def learner_functions(model: Model, texts: Mapping[str, str]) -> tuple[str, ...]:
    """The calls of LEARNER that the generated header has; empty without a learner."""
    known = interface_of(model.name, texts)
    return tuple(f for f in LEARNER if known.has("learn") and (f != "learn_aux" or known.has(f)))
