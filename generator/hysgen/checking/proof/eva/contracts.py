"""Functions that the proof of a learner takes at a contract instead of their text, and the contracts as ACSL.

`check_contract` runs `beyond` on every float. What one update does to the shadow (`project`, `factor`, `clear`, `step`)
is analysed once, from any bits the learner may hold, which shows two things: what a call writes, and that `step`
answers 0 only if every parameter that it leaves is finite and inside its limit.
"""

from __future__ import annotations

import subprocess
import time
from collections.abc import Mapping
from typing import Final

from hysgen.checking.proof.eva.frama import Verdict
from hysgen.checking.proof.hooked import hook_names
from hysgen.checking.proof.sources import folder_of
from hysgen.codegen.interface import interface_of
from hysgen.codegen.render import render
from hysgen.errors import BuildError
from hysgen.float32.learner_words import LearnerWords
from hysgen.model.model import Model

WRITES: Final[Mapping[str, tuple[str, ...]]] = {
    function: LearnerWords.written_by(function) for function in ("project", "factor", "clear", "step")
}
"""Words of the learner that each function of an update writes, and no other."""

_RESULT: Final[Mapping[str, tuple[str, ...]]] = {"project": (), "factor": (), "clear": (), "step": (r"\result",)}

_CLAUSE: Final = "\n    "
_STORED: Final = "step: theta"
"""Name of the hook behind the line that stores parameter j."""

LOOKED_AT: Final = "looked_at"
"""Parameter whose cases are distinguished: a number of the analysis, not of the generated C."""


def update_functions(model: Model, texts: Mapping[str, str]) -> list[str]:
    """The functions of WRITES that the generated C has, without prefix; a learner of one parameter has no `clear`."""
    hooks = hook_names(model, texts)
    return [function for function in WRITES if f"contract: {function}" in hooks]


def update_contracts(model: Model, texts: Mapping[str, str]) -> dict[str, list[str]]:
    """A contract for each of `update_functions`, by hook, for an analysis that takes it on trust."""
    name = model.name
    lines: dict[str, list[str]] = {}
    for function in update_functions(model, texts):
        written = [f"self->{_whole(name, texts, word)}" for word in WRITES[function]]
        clauses = [f"assigns {', '.join([*written, *_RESULT[function]])} \\from \\nothing;"]
        if function == "step":
            kept = " && ".join(within(name, f"self->theta[{j}]") for j in range(parameters(name, texts)))
            clauses += [rf"ensures \result == 1 || (\result == 0 && {kept});"]
        lines[f"contract: {function}"] = [f"/*@ {_CLAUSE.join(clauses)} */"]
    return lines


def update_cases(model: Model) -> dict[str, list[str]]:
    """Cases of the parameter LOOKED_AT in `step`, by hook: not a number, below its limits, above them, inside."""
    limit = f"{model.name.upper()}_LEARN_LIMIT_UM"
    return {
        _STORED: [
            f"    /*@ ghost if ({LOOKED_AT} == j) {{ /@ split \\is_NaN(sum); @/"
            f" if (sum < {limit}) {{ if (sum <= -{limit}) {{ ; }} else {{ ; }} }} else {{ ; }} }} */"
        ]
    }


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


def check_contract(name: str, texts: Mapping[str, str]) -> Verdict:
    """Whether `<name>_beyond` keeps its contract, by running it on all 2^32 floats.

    Raises BuildError if gcc is not installed or refuses the C.
    """
    started = time.monotonic()
    program = render("proof/contract.c.j2", {"name": name, "NAME": name.upper()})
    with folder_of({**texts, "contract.c": program}) as scratch:
        call = ["gcc", "-std=c99", "-O2", "-ffp-contract=off", "-o", "contract", "contract.c"]
        try:
            built = subprocess.run(call, cwd=scratch, capture_output=True, text=True, check=False)
        except FileNotFoundError as fault:
            raise BuildError("gcc: not installed; apt-get install gcc") from fault
        if built.returncode != 0:
            raise BuildError(f"gcc: contract.c: {(built.stderr.strip().splitlines() or ['refused'])[0]}")
        run = subprocess.run([str(scratch / "contract")], capture_output=True, text=True, check=False)
    alarms = () if run.returncode == 0 else (f"contract does not hold: {run.stdout.strip() or run.returncode}",)
    return Verdict(alarms, 1 - len(alarms), 1, time.monotonic() - started)


def within(name: str, theta: str) -> str:
    """Condition, in ACSL, that a parameter is finite and inside its limit."""
    limit = f"{name.upper()}_LEARN_LIMIT_UM"
    return rf"\is_finite({theta}) && -{limit} < {theta} < {limit}"


def parameters(name: str, texts: Mapping[str, str]) -> int:
    """Number of parameters that the learner of model `name` has."""
    return sum(word.path.startswith("theta[") for word in interface_of(name, texts).struct(f"{name}_learner_t").words())


def _whole(name: str, texts: Mapping[str, str], field: str) -> str:
    """All words of a field of the learner, as ACSL."""
    paths = [word.path for word in interface_of(name, texts).struct(f"{name}_learner_t").words()]
    return field if field in paths else f"{field}[0..{sum(path.startswith(f'{field}[') for path in paths) - 1}]"
