"""The program that Eva analyses for one call of commit: any shadow within its limits, any candidate, any phase."""

from __future__ import annotations

from collections.abc import Mapping

from hysgen.certify.certificates import certify
from hysgen.checking.proof.eva.banks import bank_box
from hysgen.checking.proof.eva.boxes import KEPT
from hysgen.checking.proof.eva.calls import ENTRY
from hysgen.checking.proof.eva.contracts import beyond_contract
from hysgen.checking.proof.eva.frama import Verdict, analyse
from hysgen.checking.proof.eva.learner_box import PARAMETERS, REMAINDERS
from hysgen.checking.proof.eva.splits import Split, case_lines, signs, splits
from hysgen.checking.proof.eva.states import float_word, integer_word
from hysgen.checking.proof.hooked import hooked
from hysgen.codegen.render import render
from hysgen.float32.coefficients import coefficients
from hysgen.float32.commit_numbers import commit_numbers
from hysgen.float32.learner_numbers import learner_numbers
from hysgen.model.intervals import symmetric
from hysgen.model.model import Model


def commit_step(model: Model, texts: Mapping[str, str]) -> tuple[dict[str, str], int]:
    """The C that Eva analyses for one call of commit, and the number of its checks.

    The learner's parameters and its candidate are in their boxes before the call; the checks demand the boxes of both
    banks after it. In the phase of checking, the index of the next check point is below their number.
    """
    name, numbers = model.name, learner_numbers(model, coefficients(model))
    points = commit_numbers(model, coefficients(model), certify(model)).points
    limit, banks = float(numbers.limit_um), bank_box(model)
    boxes = {f"{path}[{j}]": symmetric(limit) for path in (*PARAMETERS, "candidate.theta") for j in range(numbers.size)}
    boxes |= {f"candidate.bank.{path}": box for path, box in banks.items()}
    boxes |= {f"base.{path}": box for path, box in banks.items()}
    boxes |= {
        path: symmetric(REMAINDERS) for path in ("candidate.gain_remainder_um_per_V", "candidate.slope_remainder[0]")
    }
    boxes |= {"candidate.slope_remainder[1]": symmetric(REMAINDERS)}
    known = [float_word("learner", path, box) for path, box in boxes.items()]
    known += [float_word("self", f"bank[{b}].{path}", box) for b in range(2) for path, box in banks.items()]
    known += [integer_word("self", "active", 1), integer_word("learner", "candidate.phase", 3)]
    known += [integer_word("learner", "age")]
    facts = {"name": name, "words": known, "points": points}
    # Checked at the return of commit, where the cases are still separate.
    unfinished = f"/*@ check ensures left: learner->candidate.phase == 1 ==> learner->candidate.point < {points}; */"
    lines = case_lines([*splits(model, KEPT), *_commit_splits(name)]) | {"commit: contract": [unfinished]}
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
