"""Functions that the proof of a learner takes at a contract instead of their text, and the contracts as ACSL.

`beyond` is held against its contract by running it on every float (`contract.py`). What one update does to the shadow
(`project`, `factor`, `clear`, `step`) is analysed once, from any bits the learner may hold, which shows two things:
what a call writes, and that `step` answers 0 only if every parameter that it leaves is finite and inside its limit.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Final

from hysgen.checking.proof.eva.hooked import hook_names
from hysgen.codegen.interface import interface_of
from hysgen.errors import ModelError
from hysgen.float32.learner_words import LearnerWords
from hysgen.model.model import Model

WRITES: Final[Mapping[str, tuple[str, ...]]] = {
    kind: LearnerWords.written_by(kind) for kind in ("project", "factor", "clear", "step")
}
"""Words of the learner that each kind of function of an update writes, and no other."""

_RESULT: Final[Mapping[str, tuple[str, ...]]] = {"project": (), "factor": (), "clear": (), "step": (r"\result",)}

_CLAUSE: Final = "\n    "

LOOKED_AT: Final = "looked_at"
"""Parameter whose cases are distinguished: a number of the analysis, not of the generated C."""


def update_functions(model: Model, texts: Mapping[str, str]) -> dict[str, str]:
    """Name without prefix -> which of WRITES, of every function of an update with a contract, in the text's order."""
    found = [name.removeprefix("contract: ") for name in hook_names(model, texts) if name.startswith("contract: ")]
    return {function: kind for function in found if (kind := function.split("_")[0]) in WRITES}


def update_contracts(model: Model, texts: Mapping[str, str]) -> dict[str, list[str]]:
    """A contract for each of `update_functions`, by hook, for an analysis that takes it on trust."""
    name = model.name
    lines: dict[str, list[str]] = {}
    for function, kind in update_functions(model, texts).items():
        written = [f"self->{_whole(name, texts, word)}" for word in WRITES[kind]]
        clauses = [f"assigns {', '.join([*written, *_RESULT[kind]])} \\from \\nothing;"]
        if kind == "step":
            kept = " && ".join(within(name, f"self->theta[{j}]") for j in range(_parameters(name, texts)))
            clauses += ["ensures self->phase == 0;", rf"ensures \result == 1 || (\result == 0 && {kept});"]
        lines[f"contract: {function}"] = [f"/*@ {_CLAUSE.join(clauses)} */"]
    return lines


def with_checks(name: str, texts: Mapping[str, str], source: str) -> str:
    """`source` with checks of what `update_contracts` promises of `step`, for the parameter that is looked at.

    Raises ModelError if its lines are not found: then the generated text has changed under the proof.
    """
    limit = f"{name.upper()}_LEARN_LIMIT_UM"

    def looked_at(match: re.Match[str]) -> str:
        cases = [
            f"    /*@ ghost if ({LOOKED_AT} == {j}u) {{ /@ split \\is_NaN({x}); @/"
            f" if ({x} < {limit}) {{ if ({x} <= -{limit}) {{ ; }} else {{ ; }} }} else {{ ; }} }} */"
            for j, x in re.findall(r"self->theta\[(\d+)\] = (sum\d+);", match[0])
        ]
        return "\n".join([match[0], *cases])

    start = source.index(f" {name}_step({name}_learner_t *self)\n{{")
    end = source.index("\n}\n", start)
    lines = r"^ +self->theta\[\d+\] = sum\d+;(?:\s+self->theta\[\d+\] = sum\d+;)*$"
    body = re.sub(lines, looked_at, source[start:end], flags=re.MULTILINE)
    ending = re.search(r"\n    return ([^;\n]*);$", body)
    if ending is None or body.count("/*@ ghost") != _parameters(name, texts):
        raise ModelError(
            f"{name}_step: its parameters are not where the proof looks for them; adapt proof/eva/contracts.py"
        )
    answer = ending[1]
    checks = [f"answer: {answer} <= 1", "phase: self->phase == 0"]
    checks += [
        f"kept_{j}: {LOOKED_AT} == {j} && {answer} == 0 ==> {within(name, f'self->theta[{j}]')}"
        for j in range(_parameters(name, texts))
    ]
    asked = "".join(f"\n    //@ check {check};" for check in checks)
    return source[:start] + body[: ending.start()] + asked + ending[0] + source[end:]


def beyond_contract(name: str) -> dict[str, list[str]]:
    """The contract of `beyond`, by hook."""
    kept = within(name, "theta")
    clauses = [
        r"assigns \result \from theta;",
        r"ensures 0 <= \result <= 1;",
        rf"behavior in: assumes {kept}; ensures \result == 0;",
        rf"behavior out: assumes !({kept}); ensures \result == 1;",
    ]
    return {"contract: beyond": [f"/*@ {_CLAUSE.join(clauses)} */"]}


def within(name: str, theta: str) -> str:
    """That a parameter is finite and inside its limit, as ACSL."""
    limit = f"{name.upper()}_LEARN_LIMIT_UM"
    return rf"\is_finite({theta}) && -{limit} < {theta} < {limit}"


def _parameters(name: str, texts: Mapping[str, str]) -> int:
    return sum(word.path.startswith("theta[") for word in interface_of(name, texts).struct(f"{name}_learner_t").words())


def _whole(name: str, texts: Mapping[str, str], field: str) -> str:
    """All words of a field of the learner, as ACSL."""
    paths = [word.path for word in interface_of(name, texts).struct(f"{name}_learner_t").words()]
    return field if field in paths else f"{field}[0..{sum(path.startswith(f'{field}[') for path in paths) - 1}]"
