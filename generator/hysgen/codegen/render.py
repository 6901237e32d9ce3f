"""Rendering of C text from a model: variables of the templates, sums over the rules, environment of Jinja2.

Named places in the templates where the proof inserts annotations or takes lines out.

`{% hook "finite: bits" %}`, alone on its line, renders to nothing in generated C. In the text for the proof it renders
to a line that holds HOOK and the name. A hook `guard: NAME | CALL INPUTS | C` stands before a line without which the
proof of CALL must fail, and holds the C in its place (tests/fixtures/guards.py).
"""

import functools
import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Final

import jinja2
import numpy as np
from jinja2 import nodes
from jinja2.ext import Extension
from jinja2.parser import Parser

from hysgen.codegen.parameters import Constant, Section, bits, literal
from hysgen.codegen.structs import (
    bank_struct,
    inputs_struct,
    instance_struct,
    loop_struct,
    part_struct,
    rows,
    terms_struct,
)
from hysgen.float32.coefficients import OCTAVES_PER_STEP, WINDOW, Coefficients
from hysgen.machine.files import data_folder, version
from hysgen.model import float32_arithmetic as arithmetic
from hysgen.model.disturbances import Term
from hysgen.model.disturbances.base import Mirror
from hysgen.model.model import Model
from hysgen.model.path import InputBlock, preview
from hysgen.model.path.modes import straying
from hysgen.model.structs import COUNTERS, Status, Struct

HOOK: Final = "//hook "
"""Start of the line of a hook; the rest of the line is the name."""


class Hook(Extension):
    """The tag `hook` in a template that renders to nothing."""

    tags = {"hook"}  # noqa: RUF012  # jinja2 declares it as a plain attribute

    def parse(self, parser: Parser) -> nodes.Node:
        """The tag and its name as an output node."""
        line = next(parser.stream).lineno
        return nodes.Output([self.call_method("line", [parser.parse_expression()])], lineno=line)

    def line(self, name: str) -> str:
        """The text that the hook `name` renders to."""
        return ""


class MarkedHook(Hook):
    """The tag `hook` that renders to a line with its name."""

    def line(self, name: str) -> str:
        return f"{HOOK}{name}\n"


Joining = Callable[[int, str, str], str]
"""C text of the combination of two neighbours, from level, left and right text."""


@dataclass(frozen=True)
class Step:
    """The assignment `name = text` in C."""

    name: str
    text: str


@dataclass(frozen=True)
class Sum:
    """A sum over the rules: assignments of the intermediate values in order, and the C expression of the sum."""

    name: str
    steps: Sequence[Step]
    value: str


def squares(count: int) -> list[Step]:
    """Assignments of r2, r4, r8, ... for a polynomial of `count` coefficients in r by Estrin's scheme.

    >>> [f"{step.name} = {step.text}" for step in squares(6)]
    ['r2 = r * r', 'r4 = r2 * r2']
    """
    halves = [2**k for k in range(count) if 2 ** (k + 1) < count]
    return [Step(_power(2 * half), f"{_power(half)} * {_power(half)}") for half in halves]


def powers(count: int) -> list[Step]:
    """Assignments of r2, r3, ... r<count - 1> by r^k = r^(k//2) r^(k - k//2), the fewest multiplications in sequence.

    >>> [f"{step.name} = {step.text}" for step in powers(5)]
    ['r2 = r * r', 'r3 = r * r2', 'r4 = r2 * r2']
    """
    return [Step(_power(k), f"{_power(k // 2)} * {_power(k - k // 2)}") for k in range(2, count)]


def polynomial(name: str, coefficients: Sequence[str]) -> Sum:
    """sum_k coefficients[k] r^k by Estrin's scheme: neighbours combine as a + b r, the results with r2, then r4, ..."""
    return _joined(name, coefficients, lambda level, left, right: f"{left} + {right} * {_power(2**level)}")


def pairs(name: str, products: Sequence[str]) -> Sum:
    """The sum of `products` by pairwise summation."""
    return _joined(name, products, lambda _, left, right: f"{left} + {right}")


def _joined(name: str, texts: Sequence[str], join: Joining) -> Sum:
    """Pairwise combination of `texts`; an intermediate is named by the first letter of `name`, first and last row."""
    parts = [(text, row, row) for row, text in enumerate(texts)]
    steps: list[Step] = []
    level = 0
    while len(parts) > 1:
        neighbours = []
        for (left, first, _), (right, _, last) in zip(parts[0::2], parts[1::2], strict=False):
            steps.append(Step(f"{name[0]}{first}_{last}", join(level, left, right)))
            neighbours.append((steps[-1].name, first, last))
        parts = [*neighbours, *parts[2 * len(neighbours) :]]
        level += 1
    return Sum(name, steps[:-1], steps[-1].text)


def _power(exponent: int) -> str:
    return "r" if exponent == 1 else f"r{exponent}"


@dataclass(frozen=True)
class Feature:
    """An optional part of the generated code besides init, predict, simulate and inverse: the learner or its commit.

    template: file with the macros `declarations()` for the header and `definitions()` for the source.
    facts: variables of the macros, by name; sections: numbers of the feature in `<name>_params.h`.
    """

    template: str
    facts: Mapping[str, Any] = field(default_factory=dict)
    sections: Sequence[Section] = ()


@dataclass(frozen=True)
class StateText:
    """The struct of the state of a term or an input block as C, and the prefix of its functions and constants."""

    kind: str
    struct: Struct
    prefix: str

    @property
    def type(self) -> str:
        """Name of its struct."""
        return self.struct.name

    @property
    def rows(self) -> list[str]:
        """The members of its struct as C."""
        return rows(self.struct.members)


@dataclass(frozen=True)
class TermText(StateText):
    """The data of a term's template.

    first: index of its first regressor. corrects: whether the innovation corrects its state. channels: indices of its
    channels in aux[].
    """

    term: Term
    first: int
    corrects: bool
    channels: tuple[int, ...]

    @property
    def size(self) -> int:
        return self.term.size

    @property
    def template(self) -> str:
        return f"disturbances/{self.kind}.c.j2"


@dataclass(frozen=True)
class BlockText(StateText):
    """The data of an input block's template; solves: whether the inverse solves it for its input.

    channels: indices of its channels in aux[].
    """

    block: InputBlock
    solves: bool
    channels: tuple[int, ...]

    @property
    def responds(self) -> bool:
        """Whether the block is a response of the stage."""
        return self.block.responds

    @property
    def stateful(self) -> bool:
        """Whether the block has state that lasts from one sample to the next."""
        return bool(self.struct.members)

    @property
    def state(self) -> str:
        """C text of the first argument of its functions, the pointer to its state; "" without state."""
        return f"&inputs->{self.kind}, " if self.stateful else ""

    @property
    def template(self) -> str:
        return f"path/{self.kind}.c.j2"


def term_texts(model: Model, numbers: Coefficients) -> list[TermText]:
    """The model's terms in order, each with the index of its first regressor."""
    firsts = itertools.accumulate((term.size for term in model.terms), initial=0)
    return [
        TermText(
            term.kind,
            part_struct(model, term),
            f"{model.name}_{term.kind}",
            term,
            first,
            type(term.mirror(1, model.Ts_s)).correct is not Mirror.correct,
            tuple(model.channels.index(name) for name in term.channels),
        )
        for term, first in zip(model.terms, firsts, strict=False)
    ]


def block_texts(model: Model) -> list[BlockText]:
    """The model's input blocks in order."""
    return [
        BlockText(
            block.kind,
            part_struct(model, block),
            f"{model.name}_{block.kind}",
            block,
            block.responds and block.solves(model.Ts_s),
            tuple(model.channels.index(name) for name in block.channels),
        )
        for block in model.blocks
    ]


def context(model: Model, numbers: Coefficients) -> dict[str, Any]:
    """The variables of every template, by name; the templates themselves compute nothing."""
    terms = term_texts(model, numbers)
    blocks = block_texts(model)
    responses = [block for block in blocks if block.responds]
    notches = model.feedback.modes if model.feedback else 0
    two_words = any(part.two_words for part in (*model.terms, *model.blocks))
    late = next((block for block in blocks if block.block.interpolates), None)
    mode = straying(model.blocks, model.Ts_s)
    strays = next((block for block in blocks if block.block is mode), None)
    return {
        "name": model.name,
        "NAME": model.name.upper(),
        "version": version(),
        "Ts_us": f"{1e6 * model.Ts_s:.9g}",
        "Ts_s": np.float32(model.Ts_s),
        "period_ns": round(1e9 * model.Ts_s),
        "period_rounded": abs(1e9 * model.Ts_s - round(1e9 * model.Ts_s)) > 1e-6,
        "rules": numbers.rules,
        "bank_rules": numbers.bank_rules,
        "inputs_members": rows(inputs_struct(model).members),
        "terms_members": rows(terms_struct(model).members) if model.terms else [],
        "bank_members": rows(bank_struct(model, numbers).members),
        "instance_members": rows(instance_struct(model, numbers).members),
        "counters": list(COUNTERS),
        "windowed": numbers.windowed,
        "window": WINDOW,
        "terms": terms,
        "weights": sum(term.size for term in model.terms),
        "corrected": any(term.corrects for term in terms),
        "two_words": arithmetic.FACTS if two_words else None,
        "inside_limit": arithmetic.LIMIT if two_words or notches else None,
        "accumulates": any(term.two_words for term in model.terms),
        "parts": {part: facts for term in model.terms for part, facts in term.parts.items()},
        "channels": model.channels,
        "listening": [kind for kind, parts in (("terms", terms), ("inputs", blocks)) if any(p.channels for p in parts)],
        "blocks": blocks,
        "responses": responses,
        "feedback": model.feedback is not None,
        "notches": notches,
        "loop_members": rows(loop_struct(model).members) if model.feedback else [],
        "rises": model.rises,
        "omitted": next((block.kind for block in responses if not block.solves), ""),
        "delay": late,
        "strays": strays.kind if strays else "",
        "stray": strays,
        "stray_modes": len(mode.f_Hz) if mode else 0,
        "ahead": late is not None and bool(responses),
        "w_min": f"{model.name.upper()}_{'W_MIN' if responses else 'U_MIN_V'}",
        "w_max": f"{model.name.upper()}_{'W_MAX' if responses else 'U_MAX_V'}",
        "input": "w" if responses else "v" if blocks else "u",
        "preview": preview(model.blocks),
        "foreseen": preview(model.blocks) > 0 and any(term.foreseen for term in model.terms),
        "status_rows": _status_rows(model.name.upper(), bool(responses)),
        "squares": squares(numbers.rules),
        "powers": powers(WINDOW),
        "sums": _window_sums() if numbers.windowed else _dense_sums(model.name, numbers.rules),
        "octaves_per_step": np.float32(OCTAVES_PER_STEP),
        **_arithmetic(),
    }


def render(template: str, facts: Mapping[str, Any], *, marked: bool = False) -> str:
    """The text of `template` with the variables `facts`; marked: with a line for every hook (hooks.py).

    template: a path in templates/, or, with line ends in it, the template itself.
    Raises jinja2.UndefinedError for a variable without a value.
    """
    environment = _environment(marked)
    chosen = environment.from_string(template) if "\n" in template else environment.get_template(template)
    return chosen.render(facts)


def aligned(constants: Sequence[Constant], upper: str) -> list[str]:
    """One `#define` line per constant, values and comments in aligned columns."""
    names = [f"{upper}_{constant.name}" for constant in constants]
    wide = max((len(name) for name in names), default=0)
    width = max((len(constant.text) for constant in constants), default=0)
    rows = [
        f"#define {name:<{wide}}  {constant.text:>{width}}  /* {constant.comment} */"
        for name, constant in zip(names, constants, strict=True)
    ]
    return [row.removesuffix("  /*  */") for row in rows]


def _dense_sums(name: str, rules: int) -> list[Sum]:
    """S, O, G, W of Eq. (4) as polynomials in r; W comes first, as its reciprocal takes longest."""
    tables = {"weight": f"{name}_strength", "slope": "bank->slope", "offset": "bank->offset", "gain": "bank->gain"}
    return [polynomial(sum_, [f"{table}[{k}]" for k in range(rules)]) for sum_, table in tables.items()]


def _window_sums() -> list[Sum]:
    """S, O, G, W of Eq. (4) as sums of products over the window; W comes first, as its reciprocal takes longest."""
    tables = {"weight": "present", "slope": "slope", "offset": "offset", "gain": "gain"}
    return [pairs(sum_, [f"v{k} * {table}[{k}]" for k in range(WINDOW)]) for sum_, table in tables.items()]


def hexes(row: tuple[Sequence[int], Sequence[int], int]) -> str:
    """The words of a self-test row (arguments, channels, result) as C literals, separated by commas."""
    arguments, channels, result = row
    return ", ".join(f"0x{word:08x}u" for word in (*arguments, *channels, result))


def _status_rows(upper: str, responds: bool) -> list[str]:
    flags = Status.of(responds)
    names = [f"{upper}_STATUS_{flag.name}" for flag in flags]
    wide = max(len(name) for name in names)
    return [
        f"#define {name:<{wide}}  0x{int(flag):02x}u  /**< {flag.meaning} */"
        for name, flag in zip(names, flags, strict=True)
    ]


def _arithmetic() -> dict[str, Any]:
    return {
        "rounding": arithmetic.ROUNDING,
        "rounding_bits": bits(arithmetic.ROUNDING),
        "power": arithmetic.POWER_COEFFICIENTS,
        "power_limit": f"{arithmetic.POWER_LIMIT:g}",
        "power_error": f"{arithmetic.POWER_RELATIVE_ERROR:g}",
        "mantissa_bits": arithmetic.MANTISSA_BITS,
        "reciprocal_seed": f"0x{arithmetic.RECIPROCAL_SEED:08x}",
        "reciprocal_error": f"{arithmetic.RECIPROCAL_RELATIVE_ERROR:g}",
        "newton_steps": arithmetic.NEWTON_STEPS,
        "magnitude_bits": f"0x{arithmetic.MAGNITUDE_BITS:08x}",
        "infinity_bits": f"0x{arithmetic.INFINITY_BITS:08x}",
        "least_bits": bits(arithmetic.LEAST),
    }


@functools.lru_cache(maxsize=2)
def _environment(marked: bool) -> jinja2.Environment:
    environment = template_environment(autoescape=False)
    environment.add_extension(MarkedHook if marked else Hook)
    environment.filters |= {
        "literal": literal,
        "aligned": aligned,
        "hexes": hexes,
    }
    return environment


def template_environment(*, autoescape: bool) -> jinja2.Environment:
    """The Jinja2 environment of the templates folder, an undefined variable being an error; autoescape: for HTML."""
    return jinja2.Environment(
        loader=jinja2.FileSystemLoader(data_folder("templates", holds="source.c.j2")),
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        autoescape=autoescape,
    )
