"""The structs of the generated C as data: rendered into its header, copied word by word, declared to cffi and Eva."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from hysgen.errors import HysgenError
from hysgen.float32.coefficients import Coefficients
from hysgen.float32.instance_words import InstanceWords
from hysgen.float32.learner_numbers import learner_numbers
from hysgen.float32.learner_words import LearnerWords
from hysgen.float32.struct_words import Holds, StructWords
from hysgen.float32.update_schedule import factors
from hysgen.model.model import Model
from hysgen.model.structs import Member, Struct


def bank_struct(model: Model, numbers: Coefficients) -> Struct:
    """`<name>_bank_t`: the parameters as the sums over the rules need them."""
    upper = model.name.upper()
    groups = {"slope": "q1 [um/um]", "offset": "q3 [um]", "gain": "q2 [um/V]"}
    members = [
        Member(group, "float", meaning, (numbers.bank_rules,), (f"{upper}_BANK_RULES",))
        for group, meaning in groups.items()
    ]
    if model.terms:
        weights = sum(term.size for term in model.terms)
        meaning = "theta_j of the terms, in their order"
        members.append(Member("weight", "float", meaning, (weights,), (f"{upper}_WEIGHTS",)))
    return Struct(f"{model.name}_bank_t", tuple(members))


def instance_struct(model: Model, numbers: Coefficients) -> Struct:
    """`<name>_t`: one instance of the model."""
    active = Member("active", "uint32_t", "index of the bank in use, 0 or 1")
    banks = Member("bank", bank_struct(model, numbers), "active and idle parameters", (2,))
    return Struct(f"{model.name}_t", (active, *_members(InstanceWords, model), banks))


def candidate_struct(model: Model, numbers: Coefficients) -> Struct:
    """`<name>_candidate_t`: a shadow on its way to become active."""
    learned = learner_numbers(model, numbers).size
    return Struct(
        f"{model.name}_candidate_t",
        (
            Member("phase", "uint32_t", "0: none, 1: being checked, 2: to be written, 3: to be made active"),
            Member("point", "uint32_t", "check point that comes next"),
            Member("gain_rest_um_per_V", "float", "bound of the gain's Taylor remainder near a check point [um/V]"),
            Member("slope_rest", "float", "the same of |df/dy|, at the least and the largest input", (2,)),
            Member(
                "theta", "float", "the shadow when it was taken [um]", (learned,), (f"{model.name.upper()}_LEARNED",)
            ),
            Member("bank", bank_struct(model, numbers), "the same as a bank"),
        ),
    )


def learner_struct(model: Model, numbers: Coefficients) -> Struct:
    """`<name>_learner_t`: a learner with its shadow parameters."""
    learned = learner_numbers(model, numbers).size
    base = Member("base", bank_struct(model, numbers), "the parameters that are not learned")
    candidate = Member("candidate", candidate_struct(model, numbers), "the shadow that is being committed")
    return Struct(f"{model.name}_learner_t", (*_members(LearnerWords, model, learned), base, candidate))


def _members(words: type[StructWords], model: Model, learned: int = 0) -> list[Member]:
    """The members that the attributes of a mirror stand for, without those that the model does not need."""
    upper = model.name.upper()
    found = []
    for member in words.described():
        meaning = member.meaning.format(NAME=upper)
        match member.holds:
            case Holds.VECTOR:
                found.append(Member(member.name, member.type, meaning, (learned,), (f"{upper}_LEARNED",)))
            case Holds.MATRIX if factors(learned):
                found.append(Member(member.name, member.type, meaning, (factors(learned),), (f"{upper}_FACTORS",)))
            case Holds.NUMBER | Holds.INTEGER | Holds.FLAG:
                found.append(Member(member.name, member.type, meaning))
            case Holds.COUNTERS:
                found += [Member(name, "uint32_t", counter.meaning) for name, counter in words.COUNTERS.items()]
            case Holds.INPUTS if model.blocks:
                found.append(Member(member.name, Struct(f"{model.name}_inputs_t", ()), meaning))
            case Holds.TERMS if model.terms:
                found.append(Member(member.name, Struct(f"{model.name}_terms_t", ()), meaning))
    return found


def rows(members: Sequence[Member]) -> list[str]:
    """Members as C: declarations, and their comments in a column."""
    declared = [f"{member.declaration()};" for member in members]
    wide = max(len(text) for text in declared)
    return [f"{text:<{wide}}  /**< {member.meaning} */" for text, member in zip(declared, members, strict=True)]


# parser
_COMMENT: Final = re.compile(r"/\*.*?\*/", re.DOTALL)
_MEMBER: Final = re.compile(r"(?:float|uint32_t) (\w+)((?:\[\d+\]){0,2})$")


@dataclass(frozen=True)
class Declared:
    """A scalar, or an array of one or two `sizes`."""

    name: str
    sizes: tuple[int, ...]


def members(declaration: str) -> list[Declared]:
    """The members of the struct that `declaration` declares, in its order.

    >>> members("typedef struct {\\n    float play[3];  /**< [V] */\\n    uint32_t newest;\\n} plays_t;")
    [Declared(name='play', sizes=(3,)), Declared(name='newest', sizes=())]

    Raises HysgenError for a member of another type, of more than two sizes, or of a size that is not a number.
    """
    _, _, rest = _COMMENT.sub("", declaration).partition("{")
    lines = [line.strip() for line in rest.partition("}")[0].split(";")]
    return [_member(line) for line in lines if line]


def _member(text: str) -> Declared:
    found = _MEMBER.match(text)
    if found is None:
        raise HysgenError(f"state of a term or block: {text}: write float or uint32_t, a name, and sizes as numbers")
    return Declared(found[1], tuple(int(size) for size in re.findall(r"\d+", found[2])))
