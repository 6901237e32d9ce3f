"""The constants and tables of `<name>_params.h` in sections, and float32 numbers as C literals."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hysgen.codegen.structs import consequents, rule_axis
from hysgen.errors import ModelError
from hysgen.float32.coefficients import WINDOW_REACH, Coefficients
from hysgen.float32.reference.accuracy import Accuracy
from hysgen.machine.files import digest
from hysgen.machine.reproducible import rounded_up
from hysgen.model.disturbances import Term
from hysgen.model.model import Model
from hysgen.model.path import InputBlock
from hysgen.model.structs import Axis, Quantity

PER_ROW: Final = 8
"""Numbers in a row of a table."""


@dataclass(frozen=True)
class Constant:
    """`#define <NAME>_<name> value`, a float32 or an unsigned word."""

    name: str
    value: np.float32 | np.uint32

    @property
    def text(self) -> str:
        return _text(self.value)

    @property
    def comment(self) -> str:
        return bits(self.value) if isinstance(self.value, np.float32) else ""


@dataclass(frozen=True)
class Table:
    """`static const <type> <name>_<table>[size]`, one row per number; `size` is C text, `type` float or uint32_t.

    axis: of the index, if the numbers belong to physical values.
    """

    name: str
    size: str
    values: NDArray[np.float32] | NDArray[np.uint32]
    about: Quantity
    axis: Axis | None = None

    @property
    def type(self) -> str:
        return "float" if self.values.dtype == np.float32 else "uint32_t"

    @property
    def rows(self) -> list[str]:
        """The C literals, eight to a row, in aligned columns."""
        texts = [_text(value) for value in self.values]
        wide = max(len(text) for text in texts)
        columns = [f"{text + ',':>{wide + 1}}" for text in texts]
        return [" ".join(columns[k : k + PER_ROW]) for k in range(0, len(columns), PER_ROW)]


@dataclass(frozen=True)
class Section:
    """A group of numbers; about: its comment, with equation and units; public: whether `<name>.h` includes it."""

    about: str
    constants: Sequence[Constant] = ()
    tables: Sequence[Table] = ()
    public: bool = False


def range_section(numbers: Coefficients, *, responds: bool) -> Section:
    """Limits of the inputs, and the replacements of non-finite initial values; responds: whether u and w differ."""
    path = [
        Constant("W_MIN", numbers.w_min),
        Constant("W_MAX", numbers.w_max),
        Constant("W_TOLERANCE", numbers.w_tolerance),
    ]
    return Section(
        "Ranges: inputs outside are limited and counted; a start that is not finite becomes the rest value.",
        [
            Constant("Y_MIN_UM", numbers.y_min_um),
            Constant("Y_MAX_UM", numbers.y_max_um),
            Constant("Y_REST_UM", numbers.rest_um),
            Constant("U_MIN_V", numbers.u_min_V),
            Constant("U_MAX_V", numbers.u_max_V),
            Constant("U_REST_V", numbers.rest_V),
            Constant("U_STEP_MAX_V", numbers.u_step_max_V),
            Constant("REFERENCE_MIN_UM", numbers.reference_min_um),
            Constant("REFERENCE_MAX_UM", numbers.reference_max_um),
            *(path if responds else []),
        ],
        public=True,
    )


def error_section(errors: Accuracy, *, inverse: bool, responds: bool) -> Section:
    """Differences between float32 and the model in one step, proved and found; responds: whether u and w differ."""
    stated = {"PREDICT_FOUND_UM": errors.predict_um}
    if responds and errors.path:
        stated["PATH_FOUND"] = errors.path
    if inverse:
        solved = {"INVERSE_FOUND_UM": errors.predict_of_inverse_um}
        stated |= solved if responds else {"INVERSE_FOUND_V": errors.inverse_V}
    if errors.correct_um:
        stated["CORRECT_FOUND_UM"] = errors.correct_um
    comment = (
        f"Error of one step from any state. FOUND: the largest against float64 over {errors.samples} samples of the\n"
        "whole range, rounded up; larger ones exist."
    )
    if responds:
        comment += " PATH: part of the path, of w; INVERSE: of y(k+1) against\nthe reference where no limit acts."
        comment += "" if errors.path else " The part of this path is in none of them."
    if errors.proved is None:
        comment += "\nNo bound is proved: of a part of your own, or of a state that does not decay."
    else:
        comment += "\nBOUND: proved against real arithmetic, for every input and state and these numbers;"
        comment += "\nANY_BANK: for all numbers that a learner may commit, at the limits of its parameters."
        bounds = {"PREDICT_UM": errors.proved.predict_um, "INVERSE_V": errors.proved.inverse_V}
        if responds:
            bounds |= {"PATH": errors.proved.path, "INVERSE_UM": errors.proved.inverse_um}
        bounds |= {"CORRECT_UM": errors.proved.correct_um, "PREDICT_ANY_BANK_UM": errors.proved.any_bank_um}
        bounds["INVERSE_ANY_BANK_V"] = errors.proved.any_bank_inverse_V
        for name, bound in bounds.items():
            function, _, unit = name.partition("_")
            if bound is not None:
                stated[f"{function}_BOUND{'_' * bool(unit)}{unit}"] = bound
    return Section(comment, [Constant(name, _stated(error)) for name, error in stated.items()], public=True)


def error_texts(name: str, errors: Accuracy, *, responds: bool) -> dict[str, str]:
    """What the header says of the error of a function over its ranges, by the function's name."""
    texts = {}
    fields = {"PREDICT": "predict_um", "INVERSE": "inverse_um" if responds else "inverse_V", "CORRECT": "correct_um"}
    for function, field in fields.items():
        start, unit = f"{name.upper()}_{function}", field.rpartition("_")[2].upper()
        sampled = f"the largest found against float64 is {start}_FOUND_{unit}"
        bound = f"at most {start}_BOUND_{unit}, proved against real arithmetic"
        proved = getattr(errors.proved, field, None) is not None
        texts[function.lower()] = f"{bound};\n * {sampled}" if proved else f"{sampled}; no bound is proved"
    return texts


def rule_section(model: Model, numbers: Coefficients) -> Section:
    """The partition, and the consequents multiplied by the rules' strengths."""
    upper, unit = model.name.upper(), model.w_unit
    rows, axis = f"{upper}_BANK_RULES", rule_axis(model, numbers.pad)
    strength = Quantity("strength w of each rule")
    if numbers.windowed:
        away = Axis("distance to the nearest centre", "steps", tuple(range(-WINDOW_REACH, WINDOW_REACH + 1)))
        tables = [
            Table("strength", f"{upper}_WINDOW", numbers.strength, strength, away),
            Table("present", rows, numbers.present, Quantity("1: a rule, 0: a phantom beside the rules"), axis),
        ]
    else:
        tables = [Table("strength", f"{upper}_RULES", numbers.strength, strength, axis)]
    for group, about in consequents(unit).items():
        tables.append(Table(group, rows, getattr(numbers.bank, group), about, axis))
    scale = "steps per um from the lowest centre" if numbers.windowed else "octaves per um from the middle"
    return Section(
        f"Rules, Eqs (1) to (7): {scale}; strengths w;\n"
        f"consequents times w, slope q1 [um/um], offset q3 [um], gain q2 [um/{unit}].",
        [Constant("ORIGIN_UM", numbers.origin_um), Constant("PER_STEP", numbers.per_step)],
        tables,
    )


def block_sections(model: Model) -> list[Section]:
    """One section of constants per input block."""
    return [
        Section(
            f"Input block `{block.kind}`: {block.describe()}.",
            tables=_part_tables(model, block),
        )
        for block in model.blocks
    ]


def loop_sections(model: Model, numbers: Coefficients) -> list[Section]:
    """Integral and bounds of the feedback, and the constants of its filter; () without feedback."""
    if model.feedback is None:
        return []
    about = "Feedback: half the integral of a sample, largest correction, largest residual."
    constants = [
        Constant("LOOP_HALF", model.feedback.half),
        Constant("LOOP_LIMIT_UM", np.float32(model.feedback.limit_um)),
        Constant("LOOP_REACH_UM", numbers.reach_um),
    ]
    sections, block = [Section(about, constants, public=True)], model.feedback.filter
    if block is not None:
        values = block.constants(model.Ts_s)
        tables = [
            Table(f"notches_{name}", f"{values[name].size}", values[name], about)
            for name, about in block.quantities.items()
            if name in ("real", "imag", "of_position", "of_velocity", "direct")
        ]
        sections.append(Section(f"Filter of the feedback: {block.describe()}.", tables=tables))
    return sections


def _part_tables(model: Model, part: Term | InputBlock) -> list[Table]:
    """The constants of a term or an input block."""
    return [
        Table(f"{part.kind}_{name}", f"{len(values)}", values, part.quantities.get(name, Quantity(name)))
        for name, values in part.constants(model.Ts_s).items()
    ]


def term_sections(model: Model, numbers: Coefficients) -> list[Section]:
    """One section of shape constants per term, then one of all weights."""
    if not model.terms:
        return []
    upper = model.name.upper()
    sections = []
    for term in model.terms:
        sections.append(Section(f"Term `{term.kind}`: {term.describe()}.", tables=_part_tables(model, term)))
    about = Quantity("weights theta of the terms' regressors, in their order")
    weights = Table("weight", f"{upper}_WEIGHTS", numbers.bank.weight, about)
    return [*sections, Section("Weights theta of the terms' regressors, in their order.", tables=[weights])]


def numbers_digest(sections: Sequence[Section]) -> str:
    """SHA-256 of the 32-bit words of all sections, little endian, in the order of `<name>_params.h`."""
    words: list[bytes] = []
    for section in sorted(sections, key=lambda section: not section.public):
        words += [
            np.asarray(constant.value).astype(constant.value.dtype.newbyteorder("<")).tobytes()
            for constant in section.constants
        ]
        words += [table.values.astype(table.values.dtype.newbyteorder("<")).tobytes() for table in section.tables]
    return digest(b"".join(words))


def numbers_digest_of(params: str) -> str:
    """The digest of the numbers that the text of `<name>_params.h` states."""
    return params.partition('_NUMBERS_DIGEST "')[2].partition('"')[0]


def _stated(error: float) -> np.float32:
    """`error` rounded up to 2 significant digits."""
    return np.float32(rounded_up(error, 2))


def _text(value: np.float32 | np.uint32) -> str:
    return literal(value) if isinstance(value, np.float32) else f"0x{int(value):08x}u"


def literal(value: np.float32) -> str:
    """`value` with 9 significant digits and the suffix f.

    >>> literal(np.float32(0.1))
    '0.100000001f'

    Raises ModelError if the text does not read back to the same bits or the value is not finite.
    """
    text = f"{float(value):.9g}"
    if "." not in text and "e" not in text:
        text += ".0"
    if not np.isfinite(value) or bits(np.float32(text)) != bits(value):
        raise ModelError(f"a number of the model is {value} in float32, which has no float32 literal; scale the record")
    return text + "f"


def bits(value: np.float32) -> str:
    """The bit pattern of `value` as a hexadecimal literal.

    >>> bits(np.float32(1.0))
    '0x3f800000'
    """
    return f"0x{int(np.float32(value).view(np.uint32)):08x}"
