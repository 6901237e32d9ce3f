"""Description of a C struct by the annotated attributes of its mirror; the words of `<name>_t`.

The annotated attributes of a subclass of `StructWords` are the members of a generated struct, in the order of the
struct. An annotation (`vector`, `number`, `integer`, ...) states type, comment, initial value and assumptions of the
proof. The struct, its initialisation, the order of the mirror's words and the sets of the proof are derived from it.

The words of `<name>_learner_t`, its status bits and counters, and the return values of `_commit`.

The C struct ends with two members that are not words of the mirror: the bank of the parameters that are not learned,
and the candidate of a commit (`hysgen.codegen.structs`).
"""

import dataclasses
import enum
import functools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, ClassVar, Final, get_type_hints

import numpy as np
from numpy.typing import NDArray

from hysgen.model.disturbances import Mirror
from hysgen.model.feedback import FeedbackMirror
from hysgen.model.path.chain import ChainMirror
from hysgen.model.structs import COUNTERS, Counter, MeantEnum, MeantFlag, Scalar

Floats32 = NDArray[np.float32]
Words = NDArray[np.uint32]


class Holds(enum.Enum):
    """Kind of a member: C type; shape or type of the mirror's attribute."""

    VECTOR = "float per learned parameter; (n, lanes)"
    MATRIX = "float per stored element of U; (n, n, lanes)"
    NUMBER = "float; (lanes,)"
    INTEGER = "uint32_t; (lanes,)"
    FLAG = "uint32_t, 0 or 1; (lanes,)"
    COUNTERS = "uint32_t each; by name, (lanes,)"
    INPUTS = "state of the input blocks; a ChainMirror"
    TERMS = "state of the terms; a Mirror per term"
    LOOP = "state of the feedback; a FeedbackMirror"


class Start(enum.Enum):
    """Initial value of a word that `_learn_init` writes directly."""

    ZERO = 0
    ONE = 1
    MODEL_Y = "y_um of the instance"
    MODEL_U = "u_V of the instance"


class Restart(enum.Enum):
    """Value of a word after a restart of the shadow; the generated code writes vectors in the order of this list."""

    REFERENCE = "the reference parameters"
    ZERO = 0
    PRIOR = "the prior"
    LEVEL = "the level that errors start from"


@dataclass(frozen=True)
class Described:
    """A member of the struct, the annotation of the mirror's attribute of the same name.

    meaning, remark: comment in the C header, before and behind the unit. unit: "" for a pure number. start: initial
    value, None if another generated function writes it. restart: value after a restart, None if a restart does not
    change it.
    any_bits: whether the proof admits every bit pattern. parameter: whether the proof assumes and shows that the member
    is finite and within the limit of the parameters.
    written_by: kinds of functions of an update that write it (`project`, `factor`, `clear`, `step`).
    """

    holds: Holds
    meaning: str = ""
    unit: str = ""
    remark: str = ""
    name: str = ""
    start: Start | None = None
    restart: Restart | None = None
    any_bits: bool = False
    parameter: bool = False
    written_by: tuple[str, ...] = ()

    @property
    def type(self) -> Scalar:
        """C type of each scalar of the member."""
        return "float" if self.holds in (Holds.VECTOR, Holds.MATRIX, Holds.NUMBER) else "uint32_t"


vector = functools.partial(Described, Holds.VECTOR)
matrix = functools.partial(Described, Holds.MATRIX)
number = functools.partial(Described, Holds.NUMBER)
integer = functools.partial(Described, Holds.INTEGER)
flag = functools.partial(Described, Holds.FLAG)
COUNTERS_OF: Final = Described(Holds.COUNTERS)
INPUTS_OF: Final = Described(Holds.INPUTS, "state of the input blocks")
LOOP_OF: Final = Described(Holds.LOOP, "state of the feedback")
TERMS_OF: Final = Described(Holds.TERMS, "state of the terms")


class StructWords:
    """State over lanes; the annotated attributes are the members of a C struct, in the order of the struct."""

    COUNTERS: ClassVar[Mapping[str, Counter]] = {}

    @classmethod
    @functools.cache
    def described(cls) -> tuple[Described, ...]:
        """The members in the order of the struct."""
        described = []
        for name, hint in get_type_hints(cls, include_extras=True).items():
            members = [mark for mark in getattr(hint, "__metadata__", ()) if isinstance(mark, Described)]
            described += [dataclasses.replace(member, name=name) for member in members]
        return tuple(described)

    @classmethod
    def written_by(cls, function: str) -> tuple[str, ...]:
        """Names of the members that functions of kind `function` write, in the order of the struct."""
        names: list[str] = []
        for member in cls.described():
            names += [member.name] if function in member.written_by else []
            if member.holds is Holds.COUNTERS:
                names += [name for name, counter in cls.COUNTERS.items() if function in counter.written_by]
        return tuple(names)

    def words(self) -> Mapping[str, Words]:
        """The bit patterns of all words by C path, in the order of the struct, (lanes,) each.

        Word i of the input blocks is `inputs[i]`, word i of term j `terms[j][i]`, a stored element of U `u[i,j]`.
        """
        named: dict[str, Words] = {}
        for member in self.described():
            name, value = member.name, getattr(self, member.name)
            match member.holds:
                case Holds.VECTOR:
                    named |= {f"{name}[{i}]": _bits(row) for i, row in enumerate(value)}
                case Holds.MATRIX:
                    named |= {f"{name}[{i},{j}]": _bits(value[i, j]) for i, j in self.stored()}
                case Holds.NUMBER:
                    named[name] = _bits(value)
                case Holds.INTEGER | Holds.FLAG:
                    named[name] = value
                case Holds.COUNTERS:
                    named |= value
                case Holds.INPUTS | Holds.LOOP:
                    named |= {f"{name}[{i}]": word.view(np.uint32) for i, word in enumerate(value.state())}
                case Holds.TERMS:
                    for place, term in enumerate(value):
                        named |= {f"{name}[{place}][{i}]": w.view(np.uint32) for i, w in enumerate(term.state())}
        return named

    def restore(self, words: Sequence[Words]) -> None:
        """Set the state from `words` in the order of `words()`, (lanes,) each; the number of lanes may change."""
        remaining = iter(words)
        lanes = words[0].size
        for member in self.described():
            name = member.name
            match member.holds:
                case Holds.VECTOR:
                    rows = [next(remaining) for _ in range(len(getattr(self, name)))]
                    setattr(self, name, np.stack(rows).view(np.float32))
                case Holds.MATRIX:
                    size, zero = range(len(getattr(self, name))), np.zeros(lanes, np.float32)
                    stored = {place: next(remaining).view(np.float32) for place in self.stored()}
                    rows = [np.stack([stored.get((i, j), zero) for j in size]) for i in size]
                    setattr(self, name, np.stack(rows))
                case Holds.NUMBER:
                    setattr(self, name, next(remaining).view(np.float32))
                case Holds.INTEGER | Holds.FLAG:
                    setattr(self, name, next(remaining))
                case Holds.COUNTERS:
                    setattr(self, name, {counter: next(remaining) for counter in getattr(self, name)})
                case Holds.INPUTS | Holds.TERMS | Holds.LOOP:
                    value = getattr(self, name)
                    mirrors: list[ChainMirror | Mirror | FeedbackMirror] = (
                        value if member.holds is Holds.TERMS else [value]
                    )
                    for mirror in mirrors:
                        mirror.restore([next(remaining) for _ in mirror.state()])

    def stored(self) -> list[tuple[int, int]]:
        """(i, j) of every matrix element that the C struct stores, in the order of the struct."""
        return []


def _bits(x: Floats32) -> Words:
    return np.asarray(x, np.float32).view(np.uint32)


class InstanceWords(StructWords):
    """State of `lanes` instances; every scalar word is an array (lanes,)."""

    COUNTERS: ClassVar[Mapping[str, Counter]] = COUNTERS

    y_um: Annotated[Floats32, number("last output of the model", unit="um", remark=", from which a free run continues")]
    u_V: Annotated[Floats32, number("last accepted input", unit="V")]
    low_V: Annotated[Floats32, number("lowest voltage that may be put out", unit="V")]
    high_V: Annotated[Floats32, number("highest voltage that may be put out", unit="V")]
    step_V: Annotated[Floats32, number("largest change of the voltage per sample", unit="V")]
    status: Annotated[Words, integer("bits {NAME}_STATUS_..., set by events and cleared by the caller")]
    counters: Annotated[dict[str, Words], COUNTERS_OF]
    inputs: Annotated[ChainMirror, INPUTS_OF]
    terms: Annotated[list[Mirror], TERMS_OF]
    loop: Annotated[FeedbackMirror, LOOP_OF]


class LearnerStatus(MeantFlag):
    """Bits of a learner's `status`; an event sets its bit, the caller or `_learn_init` clears it."""

    REJECTED = 1, "A sample was not finite or not plausible and was ignored."
    OUTSIDE = 2, "A displacement was outside the identified range; no update used it."
    RESTING = 4, "The input was at rest; no update used the sample."
    OUTLIER = 8, "An innovation was an outlier; no update used it."
    CHANGED = 16, "Enough outliers in a row were taken for a change of the plant; updates resumed."
    QUIET = 32, "An innovation was inside the dead zone; no update used it."
    LIMITED = 64, "A step of the parameters was reduced."
    CLAMPED = 128, "An element of D was limited."
    RESTARTED = 256, "The shadow was reset to the reference parameters and the prior."


LEARNER_COUNTERS = {
    "updates": Counter("number of updates that changed the parameters", written_by=("step",)),
    "rejected": Counter("number of samples that were not finite or not plausible", LearnerStatus.REJECTED),
    "outside": Counter("number of displacements outside the identified range", LearnerStatus.OUTSIDE),
    "resting": Counter("number of samples with the input at rest", LearnerStatus.RESTING),
    "outliers": Counter("number of innovations rejected as outliers", LearnerStatus.OUTLIER),
    "changes": Counter("number of runs of outliers that were taken for a change", LearnerStatus.CHANGED),
    "quiet": Counter("number of innovations inside the dead zone", LearnerStatus.QUIET),
    "limited": Counter("number of updates whose step was reduced", LearnerStatus.LIMITED, written_by=("step",)),
    "clamped": Counter("number of updates that limited an element of D", LearnerStatus.CLAMPED),
    "restarts": Counter("number of restarts of the shadow", LearnerStatus.RESTARTED),
}
"""The counters in the order of the struct; each stops at 2^32 - 1."""


class Commit(MeantEnum):
    """Return values of `_commit`."""

    BUSY = 0, "The commit is not finished; call again."
    COMMITTED = 1, "The shadow's parameters are active."
    REFUSED_YOUNG = 2, "The shadow has had too few updates since its restart."
    REFUSED_LIMIT = 3, "A parameter is not finite or beyond its limit."
    REFUSED_GAIN = 4, "The gain b(y) would come too close to zero or change its sign."
    REFUSED_SLOPE = 5, "The slope |df/dy| would come too close to 1."
    REFUSED_WORSE = 6, "Over the samples of its trial, the shadow predicted worse than the parameters in use."
    TRYING = 7, "The trial is not finished; learn from further samples, then call again."


class Phase(MeantEnum):
    """Phases of a commit: the member `phase` of a candidate."""

    IDLE = 0, "No commit is under way; the next call copies the shadow."
    CHECK = 1, "The next call examines check points."
    TRIAL = 2, "The candidate is compared with the parameters in use, sample by sample."
    WRITE = 3, "The next call writes the candidate into the idle bank."
    SWITCH = 4, "The next call makes the written bank active."


class LearnerWords(StructWords):
    """State of `lanes` learners of n parameters: matrices (n, n, lanes), vectors (n, lanes), scalars (lanes,)."""

    COUNTERS: ClassVar[Mapping[str, Counter]] = LEARNER_COUNTERS

    d: Annotated[
        Floats32, vector("diagonal of D in P = U D U', every element positive", restart=Restart.PRIOR, any_bits=True)
    ]
    x: Annotated[Floats32, vector("regressors x = phi / scale of the previous sample", start=Start.ZERO)]
    theta: Annotated[
        Floats32,
        vector(
            "parameters theta of the shadow, scaled",
            unit="um",
            restart=Restart.REFERENCE,
            parameter=True,
            written_by=("step",),
        ),
    ]
    theta_low: Annotated[
        Floats32,
        vector(
            "rounding error of theta, added to the next step",
            unit="um",
            restart=Restart.ZERO,
            any_bits=True,
            written_by=("step",),
        ),
    ]
    reference: Annotated[
        Floats32,
        vector("parameters of the last commit, before it those of the model, scaled", unit="um", parameter=True),
    ]
    trial: Annotated[
        Floats32,
        vector("copy of the shadow's parameters that a commit checks", unit="um", start=Start.ZERO, parameter=True),
    ]
    f: Annotated[
        Floats32, vector("vector f = U' x of this update", start=Start.ZERO, any_bits=True, written_by=("project",))
    ]
    g: Annotated[
        Floats32, vector("vector g = D f of this update", start=Start.ZERO, any_bits=True, written_by=("project",))
    ]
    l: Annotated[Floats32, vector("vector of l_j = -f_j / alpha_(j-1) of this update", start=Start.ZERO, any_bits=True)]  # noqa: E741
    k: Annotated[
        Floats32, vector("vector k = P x of this update", start=Start.ZERO, any_bits=True, written_by=("factor",))
    ]
    per_alpha: Annotated[
        Floats32, number("reciprocal of alpha = 1 + x' P x of this update", start=Start.ONE, any_bits=True)
    ]
    inflate: Annotated[Floats32, number("reciprocal of the forgetting factor lambda of this update", start=Start.ONE)]
    innovation_um: Annotated[Floats32, number("innovation y - x' theta of this update", unit="um", start=Start.ZERO)]
    fixed_um: Annotated[
        Floats32, number("part of the prediction from parameters that are not learned", unit="um", start=Start.ZERO)
    ]
    y_um: Annotated[Floats32, number("last accepted displacement", unit="um", start=Start.MODEL_Y)]
    u_V: Annotated[Floats32, number("last accepted input", unit="V", start=Start.MODEL_U)]
    mean_u_V: Annotated[
        Floats32,
        number("running mean of the input", unit="V", remark="; an input near it is at rest", start=Start.MODEL_U),
    ]
    scale_um: Annotated[
        Floats32, number("running mean of |innovation|, with outliers limited", unit="um", restart=Restart.LEVEL)
    ]
    moving_um: Annotated[Floats32, number("running mean of |y(k) - y(k-1)|", unit="um", restart=Restart.LEVEL)]
    error: Annotated[Floats32, number("mean square innovation of the shadow", unit="um^2", restart=Restart.ZERO)]
    reference_error: Annotated[
        Floats32, number("mean square innovation of the reference parameters", unit="um^2", restart=Restart.ZERO)
    ]
    step_error: Annotated[Floats32, number("mean square of y(k) - y(k-1)", unit="um^2", restart=Restart.ZERO)]
    trial_um: Annotated[Floats32, number("error of the copy in free run, to first order", unit="um", start=Start.ZERO)]
    trial_reference_um: Annotated[Floats32, number("that of the reference parameters", unit="um", start=Start.ZERO)]
    trial_error: Annotated[Floats32, number("mean square of trial_um since the copy", unit="um^2", start=Start.ZERO)]
    trial_reference_error: Annotated[
        Floats32, number("mean square of trial_reference_um since then", unit="um^2", start=Start.ZERO)
    ]
    fresh: Annotated[
        Words, flag("1 if the regressors belong to the previous sample, 0 if it was not usable", start=Start.ZERO)
    ]
    rested: Annotated[Words, flag("1 if the input was at rest at the previous sample", start=Start.ZERO)]
    measuring: Annotated[
        Words, flag("1 if this update uses a sample, 0 if it restores the prior of a parameter", start=Start.ZERO)
    ]
    since_refresh: Annotated[
        Words, integer("number of updates since the prior of a parameter was restored", start=Start.ZERO)
    ]
    turn: Annotated[Words, integer("index of the parameter whose prior is restored next", start=Start.ZERO)]
    trying: Annotated[Words, integer("number of samples that the copy is still to be compared on", start=Start.ZERO)]
    run: Annotated[Words, integer("number of consecutive outliers", restart=Restart.ZERO)]
    age: Annotated[
        Words, integer("number of updates since the last restart", restart=Restart.ZERO, written_by=("step",))
    ]
    status: Annotated[
        Words,
        integer(
            "bits {NAME}_LEARN_..., set by events and cleared by the caller", start=Start.ZERO, written_by=("step",)
        ),
    ]
    counters: Annotated[dict[str, Words], COUNTERS_OF]
    inputs: Annotated[ChainMirror, INPUTS_OF]
    terms: Annotated[list[Mirror], TERMS_OF]
    u: Annotated[
        Floats32,
        matrix("columns of U above its diagonal, one after the other", any_bits=True, written_by=("factor", "clear")),
    ]
