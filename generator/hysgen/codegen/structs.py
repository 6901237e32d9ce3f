"""The structs of the generated C as data: rendered into its header, copied word by word, declared to cffi and Eva."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from hysgen.float32.coefficients import Coefficients, coefficients
from hysgen.float32.instance_words import InstanceWords
from hysgen.float32.learner_numbers import factors, learner_numbers
from hysgen.float32.learner_words import LearnerWords
from hysgen.float32.struct_words import Holds, StructWords
from hysgen.model.disturbances import Term
from hysgen.model.model import Model
from hysgen.model.path import InputBlock
from hysgen.model.structs import INPUT_UNIT, Axis, Member, Quantity, Struct


def structs(model: Model) -> tuple[Struct, ...]:
    """Every struct of the generated header in the order of its definitions: a member's struct precedes its owner."""
    numbers = coefficients(model)
    declared = [part_struct(model, block) for block in model.blocks if block.members()]
    declared += [inputs_struct(model)] if model.blocks else []
    declared += [part_struct(model, term) for term in model.terms]
    declared += [terms_struct(model)] if model.terms else []
    declared += [bank_struct(model, numbers), instance_struct(model, numbers)]
    declared += [candidate_struct(model, numbers), learner_struct(model, numbers)] if model.learner else []
    return tuple(declared)


ALIGNMENT: Final = 8
"""Bytes to which the learner is aligned where kernels load and store 64 bits at a time."""


@dataclass(frozen=True)
class Alignment:
    """The learner `struct`, aligned to `multiple` bytes: its size in bytes and 32-bit words, and with padding."""

    struct: str
    bytes: int
    multiple: int = ALIGNMENT

    @property
    def words(self) -> int:
        """32-bit words without padding."""
        return self.bytes // 4

    @property
    def padded(self) -> int:
        """Bytes of the aligned struct: a multiple of its alignment."""
        return -(-self.bytes // self.multiple) * self.multiple


def alignment(model: Model) -> Alignment | None:
    """How the learner of `model` is laid out for kernels; None for a model without."""
    if model.learner is None:
        return None
    learner = learner_struct(model, coefficients(model))
    return Alignment(learner.name, learner.bytes)


def part_struct(model: Model, part: Term | InputBlock) -> Struct:
    """`<name>_<kind>_t`: the state of a term or of an input block."""
    units = {INPUT_UNIT: _input_unit(model, part)}
    members = (replace(member, unit=units.get(member.unit, member.unit)) for member in part.members())
    return Struct(f"{model.name}_{part.kind}_t", tuple(members))


def _input_unit(model: Model, part: Term | InputBlock) -> str:
    """Unit of the input of a block: that of the last block before it that has a unit, by default V."""
    before = itertools.takewhile(lambda block: block != part, model.blocks)
    return next((block.unit for block in reversed(list(before)) if block.unit), "V")


def rule_axis(model: Model, pad: int = 0) -> Axis:
    """The centres of the rules as the axis of a table, with `pad` phantoms at either end."""
    grid = model.grid
    around = np.arange(1, pad + 1) * grid.step_um
    centres = np.concatenate([grid.centres_um[0] - around[::-1], grid.centres_um, grid.centres_um[-1] + around])
    return Axis("displacement", "um", tuple(centres.tolist()))


def inputs_struct(model: Model) -> Struct:
    """`<name>_inputs_t`: the state of all input blocks."""
    stateful = [block for block in model.blocks if block.members()]
    members = [
        Member(block.kind, part_struct(model, block), f"state of the block `{block.kind}`") for block in stateful
    ]
    return Struct(f"{model.name}_inputs_t", (Member("v_V", "float", "last input of the stage", unit="V"), *members))


def terms_struct(model: Model) -> Struct:
    """`<name>_terms_t`: the state of all terms."""
    return Struct(
        f"{model.name}_terms_t",
        tuple(Member(term.kind, part_struct(model, term), f"state of the term `{term.kind}`") for term in model.terms),
    )


def bank_struct(model: Model, numbers: Coefficients) -> Struct:
    """`<name>_bank_t`: the parameters, multiplied by the rules' strengths (`hysgen.float32.coefficients`)."""
    upper = model.name.upper()
    axis = rule_axis(model, numbers.pad)
    members = [
        Member(group, "float", about.meaning, (numbers.bank_rules,), (f"{upper}_BANK_RULES",), about.unit, axis=axis)
        for group, about in consequents(model.w_unit).items()
    ]
    if model.terms:
        weights = sum(term.size for term in model.terms)
        meaning = "weights theta_j of the terms, in their order"
        members.append(Member("weight", "float", meaning, (weights,), (f"{upper}_WEIGHTS",)))
    return Struct(f"{model.name}_bank_t", tuple(members))


def consequents(w_unit: str) -> dict[str, Quantity]:
    """The coefficients of Eq. (4) by their group in a bank; w_unit: unit of the input of the rules."""
    return {
        "slope": Quantity("consequents q1 times the strengths of the rules", "um/um"),
        "offset": Quantity("consequents q3 times the strengths of the rules", "um"),
        "gain": Quantity("consequents q2 times the strengths of the rules", f"um/{w_unit}"),
    }


def instance_struct(model: Model, numbers: Coefficients) -> Struct:
    """`<name>_t`: one instance of the model."""
    active = Member("active", "uint32_t", "index of the active bank, 0 or 1")
    banks = Member("bank", bank_struct(model, numbers), "both banks of parameters, of which one is active", (2,))
    return Struct(f"{model.name}_t", (active, *_members(InstanceWords, model), banks))


def candidate_struct(model: Model, numbers: Coefficients) -> Struct:
    """`<name>_candidate_t`: the copy of the shadow parameters that a commit checks."""
    learned = learner_numbers(model, numbers).size
    return Struct(
        f"{model.name}_candidate_t",
        (
            Member("phase", "uint32_t", f"phase of the commit, a value of {model.name}_phase_t"),
            Member("point", "uint32_t", "index of the check point that the next call examines first"),
            Member(
                "gain_remainder_um_per_V",
                "float",
                "bound of the Taylor remainder of the gain between check points",
                unit="um/V",
            ),
            Member(
                "slope_remainder",
                "float",
                "bounds of the Taylor remainder of df/dy at the lowest and the highest input of the rules",
                (2,),
            ),
            Member(
                "theta",
                "float",
                "copy of the shadow's parameters, scaled",
                (learned,),
                (f"{model.name.upper()}_LEARNED",),
                "um",
            ),
            Member("bank", bank_struct(model, numbers), "the parameters theta as a bank"),
        ),
    )


def learner_struct(model: Model, numbers: Coefficients) -> Struct:
    """`<name>_learner_t`: the state of a learner, the parameters that it does not learn, and a commit's candidate."""
    learned = learner_numbers(model, numbers).size
    base = Member(
        "base",
        bank_struct(model, numbers),
        "bank of the model when learning began; its parameters that are not learned are in use",
    )
    candidate = Member("candidate", candidate_struct(model, numbers), "copy of the shadow that a commit checks")
    return Struct(f"{model.name}_learner_t", (*_members(LearnerWords, model, learned), base, candidate))


def _members(words: type[StructWords], model: Model, learned: int = 0) -> list[Member]:
    """The C members of the attributes of `words`; input blocks, terms and U are omitted if the model has none."""
    upper = model.name.upper()
    members = []
    for member in words.described():
        meaning, unit, remark = member.meaning.format(NAME=upper), member.unit, member.remark
        match member.holds:
            case Holds.VECTOR:
                members.append(Member(member.name, member.type, meaning, (learned,), (f"{upper}_LEARNED",), unit))
            case Holds.MATRIX if factors(learned):
                members.append(Member(member.name, member.type, meaning, (factors(learned),), (f"{upper}_FACTORS",)))
            case Holds.NUMBER | Holds.INTEGER | Holds.FLAG:
                members.append(Member(member.name, member.type, meaning, unit=unit, remark=remark))
            case Holds.COUNTERS:
                members += [Member(name, "uint32_t", counter.meaning) for name, counter in words.COUNTERS.items()]
            case Holds.INPUTS if model.blocks:
                members.append(Member(member.name, inputs_struct(model), meaning))
            case Holds.TERMS if model.terms:
                members.append(Member(member.name, terms_struct(model), meaning))
    return members


def rows(members: Sequence[Member]) -> list[str]:
    """One line of C per member: its declaration and, in an aligned column, its comment."""
    declared = [f"{member.declaration()};" for member in members]
    wide = max(len(text) for text in declared)
    return [f"{text:<{wide}}  /**< {member.comment} */" for text, member in zip(declared, members, strict=True)]
