"""The structs and functions of the generated C as data: rendered into its header, declared to cffi and Eva.

Modules that compile, call or prove generated C use this description and do not parse the text.
"""

import itertools
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from hysgen.codegen.manifest import MANIFEST
from hysgen.errors import HysgenError
from hysgen.float32.coefficients import Coefficients, coefficients
from hysgen.float32.learner_numbers import factors, learner_numbers
from hysgen.float32.struct_words import Commit, Holds, InstanceWords, LearnerWords, StructWords
from hysgen.model.disturbances import Term
from hysgen.model.file import parse_model
from hysgen.model.model import Model
from hysgen.model.path import InputBlock
from hysgen.model.path.modes import astray_members, straying
from hysgen.model.structs import INPUT_UNIT, Axis, Member, Quantity, Struct


def structs(model: Model) -> tuple[Struct, ...]:
    """Every struct of the generated header in the order of its definitions: a member's struct precedes its owner."""
    numbers = coefficients(model)
    declared = [part_struct(model, block) for block in model.blocks if block.members()]
    declared += [inputs_struct(model)] if model.blocks else []
    declared += [part_struct(model, term) for term in model.terms]
    declared += [terms_struct(model)] if model.terms else []
    declared += [loop_struct(model)] if model.feedback else []
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
    mode = straying(model.blocks, model.Ts_s)
    units = {INPUT_UNIT: _input_unit(model, mode)} if mode else {}
    astray = [replace(member, unit=units.get(member.unit, member.unit)) for member in astray_members(mode)]
    last = Member("v_V", "float", "last input of the stage", unit="V")
    return Struct(f"{model.name}_inputs_t", (last, *astray, *members))


def terms_struct(model: Model) -> Struct:
    """`<name>_terms_t`: the state of all terms."""
    return Struct(
        f"{model.name}_terms_t",
        tuple(Member(term.kind, part_struct(model, term), f"state of the term `{term.kind}`") for term in model.terms),
    )


def loop_struct(model: Model) -> Struct:
    """`<name>_loop_t`: the state of the feedback."""
    assert model.feedback is not None
    return Struct(f"{model.name}_loop_t", model.feedback.members())


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
    """`<name>_candidate_t`: how far a commit is with the copy of the shadow, and the copy as a bank."""
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
            Member("bank", bank_struct(model, numbers), "the parameters on trial as a bank"),
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
            case Holds.LOOP if model.feedback:
                members.append(Member(member.name, loop_struct(model), meaning))
            case Holds.TERMS if model.terms:
                members.append(Member(member.name, terms_struct(model), meaning))
    return members


def rows(members: Sequence[Member]) -> list[str]:
    """One line of C per member: its declaration and, in an aligned column, its comment."""
    declared = [f"{member.declaration()};" for member in members]
    wide = max(len(text) for text in declared)
    return [f"{text:<{wide}}  /**< {member.comment} */" for text, member in zip(declared, members, strict=True)]


@dataclass(frozen=True)
class Function:
    """A public function.

    name: without the model's prefix; result: C type; arguments: C declarations, the struct of the state first.
    """

    name: str
    result: str
    arguments: tuple[str, ...]

    @property
    def state(self) -> str:
        """C type of the struct of the first argument; "" without arguments."""
        return self.arguments[0].removesuffix(" *self") if self.arguments else ""

    @property
    def floats(self) -> int:
        """Number of arguments after `self` if all of them are floats, else 0."""
        rest = self.arguments[1:]
        return len(rest) if all(text.startswith("float ") for text in rest) else 0

    def prototype(self, model: str) -> str:
        """The declaration as C, without semicolon."""
        return f"{self.result} {model}_{self.name}({', '.join(self.arguments) or 'void'})"


@dataclass(frozen=True)
class Interface:
    """The public part of the C of a model: structs and functions in the order of their declaration.

    channels: number of auxiliary channels.
    """

    name: str
    structs: tuple[Struct, ...]
    functions: tuple[Function, ...]
    channels: int

    def struct(self, name: str) -> Struct:
        """The struct with the C type `name`."""
        return next(struct for struct in self.structs if struct.name == name)

    def has(self, function: str) -> bool:
        """Whether the model has the function `function`, named without the model's prefix."""
        return any(known.name == function for known in self.functions)

    @property
    def prototypes(self) -> dict[str, str]:
        """C declarations without semicolon, by function, named without the model's prefix."""
        return {function.name: function.prototype(self.name) for function in self.functions}

    def declarations(self) -> str:
        """The C declarations of structs and functions for cffi."""
        channels = f"#define {self.name.upper()}_CHANNELS {self.channels}\n" if self.channels else ""
        answers = ", ".join(f"{self.name.upper()}_COMMIT_{answer.name}" for answer in Commit)
        channels += f"typedef enum {{ {answers} }} {self.name}_commit_t;\n"
        declared = "".join(f"{prototype};\n" for prototype in self.prototypes.values())
        return channels + "".join(struct.declaration() for struct in self.structs) + declared


def interface(model: Model, *, inverse: bool) -> Interface:
    """The interface of the C code that `generate` returns for `model`, with or without its inverse."""
    name, channels = model.name, len(model.channels)
    self_t, learner = f"{name}_t *self", f"{name}_learner_t *self"
    aux = f"const float aux[{name.upper()}_CHANNELS]"
    functions = [
        Function("init", "void", (self_t, "float y_um", "float u_V")),
        Function("predict", "float", (self_t, "float y_um", "float u_V")),
        Function("simulate", "float", (self_t, "float u_V")),
    ]
    if channels:
        functions.append(Function("aux", "void", (self_t, aux)))
    if inverse:
        functions.append(Function("limits", "void", (self_t, "float low_V", "float high_V", "float step_V")))
        functions.append(Function("inverse", "float", (self_t, "float y_um", "float y_next_um")))
    if model.feedback:
        functions.append(Function("correct", "float", (self_t, "float residual_um")))
    if model.learner:
        functions.append(Function("learn_init", "void", (learner, f"const {name}_t *model")))
        functions.append(Function("learn", "void", (learner, "float y_um", "float u_V")))
        if channels:
            functions.append(Function("learn_aux", "void", (learner, aux)))
        functions.append(Function("commit", f"{name}_commit_t", (self_t, f"{name}_learner_t *learner")))
    functions.append(Function("selftest", "uint32_t", ()))
    return Interface(name, structs(model), tuple(functions), channels)


def interface_of(name: str, texts: Mapping[str, str]) -> Interface:
    """The interface of generated `texts`, from the model file and the options in the manifest.

    Raises HysgenError if either file is missing or malformed.
    """
    file = f"{name}.json"
    try:
        model, manifest = texts[file], texts[MANIFEST]
    except KeyError as fault:
        raise HysgenError(f"{name}: {fault} belongs to the generated texts; generate the folder again") from fault
    try:
        inverse = bool(json.loads(manifest)["options"]["inverse"])
    except (ValueError, KeyError, TypeError) as fault:
        raise HysgenError(f"{MANIFEST}: names no option inverse ({fault}); generate the folder again") from fault
    return interface(parse_model(model, file), inverse=inverse)
