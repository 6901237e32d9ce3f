"""What Eva is given for the learner: one call of learn or commit, from any state of the learner's box.

The box of learn leaves the covariance out: U, D and what one update keeps of them (U' x, D U' x, the lower words of the
parameters) may hold any 32 bits, NaN among them. Intervals cannot see why a covariance stays positive; the generated
code does not rely on it either, but looks for what has gone wild and starts again. So the proof shows that whatever the
covariance holds, parameters, levels, terms and indices stay where they belong.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from hysgen.certificates import certify
from hysgen.coefficients import coefficients
from hysgen.commit_numbers import commit_numbers
from hysgen.emit.render import render
from hysgen.errors import ModelError
from hysgen.learner_numbers import FAST, LearnerNumbers, learner_numbers
from hysgen.model import Model
from hysgen.proof.eva.boxes import KEPT, instance_box, regressor_sizes
from hysgen.proof.eva.calls import ENTRY, finite_checked
from hysgen.proof.eva.frama import Verdict, analyse
from hysgen.proof.eva.intervals import Interval, hexadecimal, symmetric
from hysgen.proof.eva.splits import Split, annotated, displacements, signs, splits
from hysgen.proof.eva.states import ANY_WORD, Assumed, assumed, ring_places
from hysgen.proof.layout import words

FUNCTIONS: Final = ("beyond", "commit")
"""What is proved of a learner unless it is asked for learn, whose analysis takes long (docs/proof.md)."""

WILD: Final = ("d", "theta_low", "f", "g", "l", "k", "per_alpha", "u")
"""Words that may hold any bits: the covariance, and what is derived from it."""

LEARNED: Final = ("theta", "reference", "candidate.theta")
"""Words that hold a parameter each."""

RESTS: Final = 1e12
"""Larger than what commit may keep of a candidate between its calls, far from what overflows."""

FIRING: Final = 16.0
"""A rule's regressors stay below this many times their typical size, as an analysis by intervals sees them."""


@dataclass(frozen=True)
class Level:
    """A running level: it stays below `most`, and its box is a little wider, for what intervals cannot see."""

    path: str
    most: float

    @property
    def box(self) -> Interval:
        return Interval(-self.most / 64.0, 1.02 * self.most).outwards()

    @property
    def borders(self) -> tuple[str, ...]:
        """Between them the step towards the newest value goes one way."""
        return (f"self->{self.path} < 0.0f", f"self->{self.path} <= {hexadecimal(self.most)}")


def learner_functions(model: Model, texts: Mapping[str, str]) -> tuple[str, ...]:
    """commit, and what it leans on, if the model has a learner."""
    return FUNCTIONS if re.search(rf"\b{model.name}_learn\(", texts[f"{model.name}.h"]) else ()


@dataclass(frozen=True)
class LearnerBox:
    """floats and integers by C path in `<name>_learner_t`: interval, and largest value. levels: those among them."""

    floats: Mapping[str, Interval]
    integers: Mapping[str, int]
    levels: tuple[Level, ...]


def learner_box(model: Model) -> LearnerBox:
    """Every word of the learner that is not WILD, not of its candidate and not constant."""
    numbers = learner_numbers(model, coefficients(model))
    instance = instance_box(model)
    limit = float(numbers.limit_um)
    y = Interval(float(numbers.y_low_um), float(numbers.y_high_um)).hull(instance["y_um"])
    u = Interval(model.u_min_V, model.u_max_V).outwards()
    sizes = _regressors(model, numbers)
    error = 2.0 * (y.magnitude + sum(sizes) * limit) + instance["y_um"].magnitude
    moved = 2.0 * y.magnitude + 1.0
    levels = (
        Level("scale_um", 1.01 * error + 1.0),
        Level("moving_um", moved),
        Level("error", 1.01 * error**2),
        Level("reference_error", 1.01 * error**2),
        Level("step_error", 1.01 * moved**2),
    )
    floats = {f"x[{j}]": symmetric(size).outwards() for j, size in enumerate(sizes)}
    floats |= {f"{name}[{j}]": symmetric(limit) for name in ("theta", "reference") for j in range(numbers.size)}
    floats |= {
        "inflate": Interval(1.0, float(max(numbers.inflate, numbers.inflate_first))),
        "innovation_um": symmetric(error).outwards(),
        "fixed_um": symmetric(instance["y_um"].magnitude),
        "y_um": y,
        "u_V": u,
        "mean_u_V": u.outwards(2.0 * FAST * u.width),
    }
    floats |= {level.path: level.box for level in levels}
    floats |= {path: box for path, box in instance.items() if path.startswith(("terms.", "inputs."))}
    integers = {"turn": numbers.size - 1, "phase": numbers.settings.calls_per_update}
    integers |= dict.fromkeys(("fresh", "rested", "measuring"), 1)
    return LearnerBox(floats, integers, levels)


def _regressors(model: Model, numbers: LearnerNumbers) -> list[float]:
    """Largest |x_j| that learning or putting back the prior writes."""
    sizes = iter(regressor_sizes(model))
    found = []
    for parameter, refresh in zip(numbers.parameters, numbers.refresh, strict=True):
        size = 1.01 * next(sizes) / parameter.scale if parameter.group == "terms" else FIRING
        found.append(max(size, 1.01 * float(refresh)))
    return found


def learn_step(model: Model, texts: Mapping[str, str]) -> tuple[dict[str, str], int]:
    """The C that Eva analyses for one call of learn with any 32 bits as inputs, and the number of its checks."""
    name, box = model.name, learner_box(model)
    integers = {**box.integers, **ring_places(model)}
    known: list[Assumed] = []
    for word in words(texts[f"{name}.h"], f"{name}_learner_t"):
        if word.path.split("[")[0] not in WILD and not word.path.startswith(("candidate.", "base.")):
            known.append(assumed("learner", word.path, box.floats.get(word.path), integers.get(word.path)))
    facts = {
        "name": name,
        "words": known,
        "wild": [word for word in WILD if re.search(rf"^    float {word}\[", texts[f"{name}.h"], re.MULTILINE)],
        "scalars": ["per_alpha"],
        "any": f"{name}_float({ANY_WORD})",
    }
    source = annotated(name, texts[f"{name}.c"], [*splits(model, KEPT), *_learn_splits(model, box)])
    source = finite_checked(name, _parameters_looked_at(name, source))
    checks = sum(word.demanded != "" for word in known)
    return {**texts, f"{name}.c": source, ENTRY: render("proof/learn.c.j2", facts)}, checks


def prove_learn(model: Model, texts: Mapping[str, str]) -> tuple[Verdict, int]:
    """What Eva says of one call of learn, and how many checks it must have come to."""
    sources, checks = learn_step(model, texts)
    name = model.name
    options = ["-eva-use-spec", f"{name}_beyond"]
    for function in ("step", "work", "take"):
        options += ["-eva-split-return-function", f"{name}_{function}:0"]
    return analyse(sources, ENTRY, "any", options=options), checks


def commit_step(model: Model, texts: Mapping[str, str]) -> tuple[dict[str, str], int]:
    """The C that Eva analyses for one call of commit, and the number of its checks.

    The learner's parameters and its candidate are in their boxes, and so must both banks be after the call. A candidate
    that is being checked has a check point left; any other may have come to their end.
    """
    name, numbers = model.name, learner_numbers(model, coefficients(model))
    points = commit_numbers(model, coefficients(model), certify(model)).points
    limit, banks = float(numbers.limit_um), bank_box(model, numbers)
    boxes = {f"{path}[{j}]": symmetric(limit) for path in LEARNED for j in range(numbers.size)}
    boxes |= {f"candidate.bank.{path}": box for path, box in banks.items()}
    boxes |= {f"base.{path}": box for path, box in banks.items()}
    boxes |= {path: symmetric(RESTS) for path in ("candidate.gain_rest_um_per_V", "candidate.slope_rest[0]")}
    boxes |= {"candidate.slope_rest[1]": symmetric(RESTS)}
    known = [assumed("learner", path, box, None) for path, box in boxes.items()]
    known += [assumed("self", f"bank[{b}].{path}", box, None) for b in range(2) for path, box in banks.items()]
    known += [assumed("self", "active", None, 1), assumed("learner", "candidate.phase", None, 3)]
    known += [assumed("learner", "age", None, None)]
    facts = {"name": name, "words": known, "points": points}
    source = _contract(name, annotated(name, texts[f"{name}.c"], [*splits(model, KEPT), *_commit_splits(name)]))
    # Asked where commit returns, case by case: afterwards the cases are taken together.
    left = f"/*@ check ensures left: learner->candidate.phase == 1 ==> learner->candidate.point < {points}; */\n"
    source = re.sub(rf"^(uint32_t {name}_commit\()", lambda match: left + match[1], source, flags=re.MULTILINE)
    checks = sum(word.demanded != "" for word in known) + 1
    return {**texts, f"{name}.c": source, ENTRY: render("proof/commit.c.j2", facts)}, checks


def prove_commit(model: Model, texts: Mapping[str, str]) -> tuple[Verdict, int]:
    """What Eva says of one call of commit, and how many checks it must have come to."""
    sources, checks = commit_step(model, texts)
    options = ["-eva-use-spec", f"{model.name}_beyond", "-eva-split-return-function", f"{model.name}_snapshot:0"]
    return analyse(sources, ENTRY, "finite", options=options), checks


def bank_box(model: Model, numbers: LearnerNumbers) -> dict[str, Interval]:
    """Every number of a bank, by C path: what the model has, and what commit may make of learned parameters."""
    bank = coefficients(model).bank
    groups = {"slope": bank.slope, "offset": bank.offset, "gain": bank.gain}
    box = {f"{group}[{i}]": _at(x) for group, values in groups.items() for i, x in enumerate(values)}
    box |= {f"weight[{j}]": _at(x) for j, x in enumerate(model.weights)}
    limit = 1.01 * float(numbers.limit_um)
    for parameter, per_scale in zip(numbers.parameters, numbers.per_scale, strict=True):
        reach = symmetric(limit * float(per_scale))
        names = {"terms": [f"weight[{parameter.index}]"], "bias": [f"offset[{i}]" for i in range(len(bank.offset))]}
        for path in names.get(parameter.group, [f"{parameter.group}[{parameter.index}]"]):
            box[path] = reach.hull(box[path]).outwards(reach.high if parameter.group == "bias" else 0.0)
    return box


def _at(x: float) -> Interval:
    return Interval(float(x), float(x)).outwards()


def _learn_splits(model: Model, box: LearnerBox) -> list[Split]:
    levels = {level.path: level for level in box.levels}
    low, high = (hexadecimal(end) for end in (model.u_min_V, model.u_max_V))
    return [
        Split("learn", (f"self->mean_u_V < {low}", f"self->mean_u_V <= {high}")),
        Split("learn", _plausible(model), "const float y = "),
        Split("keep", displacements(coefficients(model)), "const float y = "),
        *(Split("lost", levels[path].borders) for path in ("moving_um", "error", "reference_error", "step_error")),
        Split("lost", signs("moved")),
        Split("admit", levels["scale_um"].borders),
        Split("admit", signs("e"), "const float e = "),
        Split("limited", ("x <= high",)),
    ]


def _commit_splits(name: str) -> list[Split]:
    return [
        Split("size", signs("x")),
        *(Split(function, signs(x)) for function in ("lesser", "greater") for x in ("a", "b")),
        Split("lesser", ("b < a",)),
        Split("greater", ("b <= a",)),
        Split("commit", (f"candidate->point < {name.upper()}_COMMIT_POINTS",), "candidate->point += 1u"),
    ]


def _plausible(model: Model) -> tuple[str, ...]:
    upper = model.name.upper()
    return (f"y < {upper}_LEARN_Y_LOW_UM", f"y <= {upper}_LEARN_Y_HIGH_UM")


def _parameters_looked_at(name: str, source: str) -> str:
    """`source` with every parameter looked at by whether it is beyond its limit, together with the flag that says so.

    `beyond` is taken at its contract: what it says of every one of the 2^32 floats is checked by running it.
    Raises ModelError if the lines are not found: then the generated text has changed under the proof.
    """
    limit = f"{name.upper()}_LEARN_LIMIT_UM"
    start = source.index(f" {name}_step(")
    body, rest = source[start : (end := source.index("\n}\n", start))], source[end:]
    lines: list[str] = []
    before: list[str] = []
    for line in body.split("\n"):
        sums = re.findall(r"self->theta\[\d+\] = (sum\d+);", line)
        if sums:
            lines += [f"    //@ merge {x} {how};" for x in reversed(before) for how in (f"<= -{limit}", f"< {limit}")]
            lines += [f"    //@ split {x} {how};" for x in sums for how in (f"< {limit}", f"<= -{limit}")]
            before = sums
        if line == f"    if (size > {name.upper()}_LEARN_STEP_UM) {{":
            lines.append("    //@ dynamic_split beyond;")
        lines.append(line)
    looked = "\n".join(lines)
    if "dynamic_split" not in looked or looked.count("split sum") != 2 * looked.count("_beyond(sum"):
        raise ModelError(
            f"{name}_step: its parameters are not where the proof looks for them; adapt proof/eva/learner.py"
        )
    return _contract(name, source[:start] + looked + rest)


def _contract(name: str, source: str) -> str:
    """`source` with the contract of `beyond` before its body."""
    limit = f"{name.upper()}_LEARN_LIMIT_UM"
    kept = rf"\is_finite(theta) && -{limit} < theta < {limit}"
    contract = [
        r"/*@ assigns \result \from theta;",
        rf"    behavior in: assumes {kept}; ensures \result == 0;",
        rf"    behavior out: assumes !({kept}); ensures \result == 1; */",
    ]
    head = rf"^(\w+_INLINE uint32_t {name}_beyond\(float theta\)\n)"
    return re.sub(head, lambda match: "\n".join([*contract, match[1]]), source, flags=re.MULTILINE)
