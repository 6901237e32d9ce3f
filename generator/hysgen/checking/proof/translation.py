"""Generated C computes the bits of its reference for every input: translation validation, function by function.

The reference is called with symbols in place of numbers (`symbolic.arrays`), the C is executed with the same symbols
(`symbolic.from_c`), and every word that they leave is compared (`symbolic.equivalence`): equal operations of equal
operands, or selections and bit tricks that a solver finds equal. The C of learner and commit asks early and leaves
early, the reference computes every lane to its end: they are compared in each case of the truths that the C branches
on. Assumed are the certified box of the state before the call, which `hysgen prove` shows to be left by no call,
indices inside their arrays, and that the compiler keeps the semantics of C; `hysgen verify` samples the compiler.

Source: Pnueli, Siegel, Singerman, Translation validation (1998).
"""

import dataclasses
import importlib.util
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from hysgen.certify.certificates import certify
from hysgen.checking.proof.eva.boxes import learner_box, parts_box, state_box
from hysgen.checking.symbolic.arrays import Symbols, coerced, traced, with_symbols
from hysgen.checking.symbolic.dataflow import Graph, Op
from hysgen.checking.symbolic.equivalence import SAMPLES, Sweep
from hysgen.checking.symbolic.expressions import negated
from hysgen.checking.symbolic.from_c import Decision, outcome
from hysgen.checking.symbolic.solver import SOLVER
from hysgen.checking.symbolic.source import KernelRefusalError, Source
from hysgen.codegen.structs import Interface, interface_of
from hysgen.float32.coefficients import Bank, coefficients, commit_numbers
from hysgen.float32.learner_numbers import bank_box
from hysgen.float32.reference.commit import Committer
from hysgen.float32.reference.instance import Instance
from hysgen.float32.reference.learner import Learner
from hysgen.float32.struct_words import Phase
from hysgen.model.intervals import Interval
from hysgen.model.model import Model
from hysgen.model.structs import Member, Struct

Words = NDArray[np.uint32]

INSTANCE, LEARNER, AUX = "t", "learner_t", "aux"
CALLS: Final[Mapping[str, tuple[tuple[str, ...], int]]] = {
    "init": ((INSTANCE,), 2),
    "aux": ((INSTANCE, AUX), 0),
    "limits": ((INSTANCE,), 3),
    "predict": ((INSTANCE,), 2),
    "simulate": ((INSTANCE,), 1),
    "inverse": ((INSTANCE,), 2),
    "correct": ((INSTANCE,), 1),
    "learn_init": ((LEARNER, INSTANCE), 0),
    "learn_aux": ((LEARNER, AUX), 0),
    "learn": ((LEARNER,), 2),
    "commit": ((INSTANCE, LEARNER), 0),
}
"""Structs, or the auxiliary channels, behind the pointers of every function that is proved, and the number of its float
arguments. A public function that is generated and not named here is said to be not proved."""

PREFIX: Final[Mapping[str, str]] = {INSTANCE: "", LEARNER: "learner.", AUX: ""}
"""Before the paths of the words of a struct."""

UNKNOWN: Final = "it has no reference"

FEW_DECISIONS: Final = 8
"""With more `if` statements, the samples rarely pass them all, and equal samples say little."""

MOST_OPEN: Final = 200
"""Words left open over all cases, behind which no further case is looked at."""

GROUPS: Final = ("slope", "offset", "gain", "weight")


@dataclass(frozen=True)
class FunctionProof:
    """The proof that one function computes the bits of its reference.

    words: compared, the returned one included, in each case. cases: of the truths that the `if` statements of the C
    depend on. open: words not shown equal, by their C path. solved: equalities that the solver decided, by_kind: of
    what, solver_s: in how long. difference: of the first open word that differs in a drawn sample, the sample.
    refused: why there is no proof, if the function is outside what is traced.
    """

    function: str
    words: int = 0
    open: tuple[str, ...] = ()
    solved: int = 0
    seconds: float = 0.0
    difference: str = ""
    refused: str = ""
    cases: int = 1
    by_kind: Mapping[str, int] = field(default_factory=dict)
    solver_s: float = 0.0

    @property
    def holds(self) -> bool:
        return not self.open and not self.refused

    def line(self) -> str:
        if self.refused:
            return f"{self.function}: not proved: {self.refused}"
        if self.difference:
            return f"{self.function}: DIFFERS: {self.difference}"
        cases = f"{self.cases} cases, " if self.cases > 1 else ""
        kinds = ", ".join(f"{number} of {kind}" for kind, number in self.by_kind.items())
        solved = f"{self.solved} equalities by the solver{f' in {self.solver_s:.1f} s ({kinds})' * bool(kinds)}"
        said = f"{self.words} words, {cases}{solved}, {self.seconds:.1f} s"
        if self.open:
            return f"{self.function}: not proved: {len(self.open)} words are open, {self.open[0]} first ({said})"
        return f"{self.function}: equal for every input ({said})"


@dataclass(frozen=True)
class Translation:
    """The proofs of all functions; solver: whether it was installed."""

    model: str
    solver: bool
    functions: tuple[FunctionProof, ...]

    @property
    def equal(self) -> bool:
        """Whether no function was seen to differ."""
        return not any(proof.difference for proof in self.functions)

    def lines(self) -> list[str]:
        lines = [proof.line() for proof in self.functions]
        if not self.solver:
            lines.append("without a solver, equal forms alone are proved: pip install 'hysgen[prove]'")
        proved = sum(proof.holds for proof in self.functions)
        return [*lines, f"{self.model}: {proved} of {len(self.functions)} functions proved"]

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values."""
        return dataclasses.asdict(self) | {"holds": self.equal}


def translation(
    model: Model,
    texts: Mapping[str, str],
    *,
    calls: Sequence[str] = (),
    progress: Callable[[float, str], None] | None = None,
) -> Translation:
    """Prove every public function that the texts of `generate` define, or those of `calls` among them.

    Raises ModelError for a part of the model without a box of its states.
    """
    interface = interface_of(model.name, texts)
    source = Source(model.name, texts)
    names = [name for name in source.public if not calls or name in calls]
    proofs: list[FunctionProof] = []
    for place, function in enumerate(names):
        if progress is not None:
            progress(place / len(names), f"proof of {function}")
        known = function in CALLS
        proofs.append(
            _proved(model, source, interface, function) if known else FunctionProof(function, refused=UNKNOWN)
        )
    return Translation(model.name, importlib.util.find_spec(SOLVER) is not None, tuple(proofs))


def _proved(model: Model, source: Source, interface: Any, function: str) -> FunctionProof:
    begun = time.monotonic()
    call = _Call(model, function, interface)
    try:
        compared = list(call.compared(source))
        many = max(len(decisions) for _, decisions in compared) > FEW_DECISIONS
        sweep = Sweep(call.drawn, list(call.assumed()), by_cases=many)
        open_words: list[str] = []
        difference, words, cases = "", 0, 0
        for pairs, decisions in compared:
            for case in sweep.cases(decisions):
                if difference or len(open_words) > MOST_OPEN:
                    break
                cases, words = cases + 1, words + len(pairs)
                made = sweep.pairs([pair[1:] for pair in pairs], case)
                for (path, _, _), (got, expected) in zip(pairs, made, strict=True):
                    if got is expected:
                        continue
                    open_words.append(path)
                    wrong = np.flatnonzero((sweep.values(got) != sweep.values(expected)) & sweep.holds(case))
                    if wrong.size and not difference:
                        in_c, in_reference = (int(sweep.values(op)[wrong[0]]) for op in (got, expected))
                        values = f"{path}: {in_c:#010x} in C, {in_reference:#010x} in the reference"
                        difference = f"{values}, for {call.sample(int(wrong[0]))}"
    except KernelRefusalError as refusal:
        return FunctionProof(function, seconds=time.monotonic() - begun, refused=str(refusal))
    unique = tuple(dict.fromkeys(open_words))
    solved = sweep.decided.total(), time.monotonic() - begun, difference, "", cases, dict(sweep.decided), sweep.solver_s
    return FunctionProof(function, words, unique, *solved)


class _Call:
    """One function, called with symbols. ranges: of the words before the call that have one, by their path."""

    def __init__(self, model: Model, function: str, interface: Interface) -> None:
        self.model, self.function, self.graph = model, function, Graph()
        suffixes, arguments = CALLS[function]
        aux = Struct("", (Member(AUX, "float", "", (interface.channels,)),))
        structs = [aux if suffix == AUX else interface.struct(f"{model.name}_{suffix}") for suffix in suffixes]
        words = {suffix: list(struct.words(PREFIX[suffix])) for suffix, struct in zip(suffixes, structs, strict=True)}
        self.paths = {suffix: [word.path for word in words[suffix]] for suffix in suffixes}
        self.types = {word.path: word.type for suffix in suffixes for word in words[suffix]}
        ranges = state_ranges(model, function)
        self.ranges = {path: ranges[path] for path in self.types if path in ranges}
        self.arguments = [self.graph.param(k) for k in range(arguments)]
        self.before = {path: self._started(path) for path in self.types}

    def _started(self, path: str) -> Op:
        """The word before the call; a number, if its range is one."""
        low, high = self.ranges.get(path, (0, 1))
        if low == high:
            return self.graph.const(int(np.float32(low + 0.0).view(np.uint32)))
        return self.graph.symbol(path, truth=high == 1 and path in self.ranges and self.types[path] != "float")

    def compared(self, source: Source) -> Iterator[tuple[list[tuple[str, Op, Op]], Sequence[Decision]]]:
        """For every active bank and phase: path of every word after the call, its value in C and in the reference, and
        the decisions of the C."""
        banks = [{}] if self.function == "init" or "active" not in self.before else [{"active": 0}, {"active": 1}]
        phases = [{"learner.candidate.phase": int(phase)} for phase in Phase] if self.function == "commit" else [{}]
        for numbers in (bank | phase for bank in banks for phase in phases):
            before = self.before | {path: self.graph.const(number) for path, number in numbers.items()}
            structs: list[Op | Sequence[Op]] = [[before[path] for path in paths] for paths in self.paths.values()]
            after = outcome(source, self.graph, f"{self.model.name}_{self.function}", [*structs, *self.arguments])
            with traced(), np.errstate(all="ignore"):
                expected, result = self._reference(before)
            words = zip(self.paths.values(), after.structs.values(), strict=True)
            in_c = {path: op for paths, ops in words for path, op in zip(paths, ops, strict=True)}
            pairs = [(path, op, expected.get(path, before[path])) for path, op in in_c.items()]
            yield pairs + ([("result", after.result, result)] if after.result is not None else []), after.decisions

    def _reference(self, before: Mapping[str, Op]) -> tuple[dict[str, Op], Any]:
        """Words that the reference leaves, by their path in C, and what it returns."""
        start = np.zeros(1, np.float32)
        instance = Instance(self.model, start, start)
        if LEARNER in self.paths:
            return self._learner_reference(before, instance)
        lanes = self._restored(before, instance)
        arguments = [Symbols.of(self.graph, [argument], np.float32) for argument in self.arguments]
        returned = getattr(lanes, self.function)(*arguments, *self._channels(before))
        expected = self._words(INSTANCE, lanes.words())
        if self.function == "init":
            numbers = [op for group in GROUPS for op in getattr(lanes.numbers.bank, group).ops]
            banks = [path for path in before if path.startswith("bank[")]
            expected |= {"active": self.graph.const(0)} | dict(zip(banks, [*numbers, *numbers], strict=True))
        return expected, returned.ops.ravel()[0] if isinstance(returned, Symbols) else None

    def _learner_reference(self, before: Mapping[str, Op], instance: Instance) -> tuple[dict[str, Op], Any]:
        """`_reference` of a function of the learner."""
        model, returned = self.model, None
        if self.function == "learn_init":
            lanes = self._restored(before, instance)
            lanes.numbers = instance.numbers
            learner = Learner(model, lanes)
            idle = {"learner.candidate.phase": 0, "learner.candidate.point": 0}
            expected = {path: self.graph.const(number) for path, number in idle.items()} | {
                f"learner.base.{path.partition('.')[2]}": op
                for path, op in before.items()
                if path.startswith(f"bank[{before['active'].number}].")
            }
            return expected | self._words(LEARNER, learner.words()), None
        numeric = Learner(model, instance)
        if self.function in ("learn", "learn_aux"):
            learner = self._restored(before, numeric)
            arguments = [Symbols.of(self.graph, [argument], np.float32) for argument in self.arguments]
            getattr(learner, self.function.removeprefix("learn_"))(*arguments, *self._channels(before))
            return self._words(LEARNER, learner.words()), None
        committer = Committer(commit_numbers(model, instance.numbers, certify(model)), numeric)
        committer = with_symbols(self.graph, committer)
        committer.learner = self._restored(before, numeric)
        candidate = [path for path in self.paths[LEARNER] if path.startswith("learner.candidate.")]
        for name in ("phase", "point", "gain_remainder_um_per_V", "slope_remainder"):
            rows = [path for path in candidate if path.split(".")[2].partition("[")[0] == name]
            setattr(committer, name, self._rows(before, rows, getattr(committer, name)))
        for group, numbers in committer.bank.items():
            rows = [path for path in candidate if path.startswith(f"learner.candidate.bank.{group}[")]
            committer.bank[group] = self._rows(before, rows, numbers)
            rows = [path for bank in (0, 1) for path in before if path.startswith(f"bank[{bank}].{group}[")]
            committer.banks[group] = self._rows(before, rows, committer.banks[group])
        committer.active = Symbols.of(self.graph, [before["active"]])
        returned = committer.commit()
        expected = self._words(LEARNER, committer.learner.words())
        expected |= dict(zip(candidate, self._ops(committer.words()), strict=True))
        expected["active"] = committer.active.ops.ravel()[0]
        for group, rows_of in committer.banks.items():
            paths = [path for bank in (0, 1) for path in before if path.startswith(f"bank[{bank}].{group}[")]
            expected |= dict(zip(paths, coerced(self.graph, rows_of, np.dtype(np.float32)).ops.ravel(), strict=True))
        return expected, coerced(self.graph, returned, np.dtype(np.uint32)).ops.ravel()[0]

    def _channels(self, before: Mapping[str, Op]) -> list[list[Symbols]]:
        """The samples of the auxiliary channels as the last argument of the reference, of a call that has them."""
        channels = [Symbols.of(self.graph, [before[path]], np.float32) for path in self.paths.get(AUX, ())]
        return [channels] if channels else []

    def _restored(self, before: Mapping[str, Op], lanes: Any) -> Any:
        """The mirror of a struct with the words before the call and its bank, the active one or the learner's base."""
        suffix = LEARNER if isinstance(lanes, Learner) else INSTANCE
        paths = self._mirrored(suffix, lanes.words())
        lanes = with_symbols(self.graph, lanes)
        if self.function == "init":
            return lanes
        lanes.restore([Symbols.of(self.graph, [before[path]]) for path in paths])
        of = "learner.base." if suffix == LEARNER else f"bank[{before['active'].number}]."
        rows = [[op for path, op in before.items() if path.startswith(f"{of}{group}[")] for group in GROUPS]
        bank = Bank(*(Symbols.of(self.graph, row, np.float32) for row in rows))  # type: ignore[arg-type]
        setattr(lanes, "base" if suffix == LEARNER else "bank", bank)
        return lanes

    def _mirrored(self, suffix: str, words: Mapping[str, Any]) -> list[str]:
        """Paths of the words that the mirror of a struct has: all behind `active`, up to its banks or candidate."""
        first = int(suffix == INSTANCE)
        return self.paths[suffix][first : first + len(words)]

    def _words(self, suffix: str, words: Mapping[str, Any]) -> dict[str, Op]:
        return dict(zip(self._mirrored(suffix, words), self._ops(words), strict=True))

    def _ops(self, words: Mapping[str, Any]) -> list[Op]:
        return [coerced(self.graph, word, np.dtype(np.uint32)).ops.ravel()[0] for word in words.values()]

    def _rows(self, before: Mapping[str, Op], paths: Sequence[str], like: Any) -> Symbols:
        made = Symbols.of(self.graph, [before[path] for path in paths], like.dtype)
        return made.reshape(*like.shape)

    def assumed(self) -> Iterator[Op]:
        """What holds before the call: every word in its range, and the limits of the voltage in their order."""
        graph = self.graph
        for path, (low, high) in self.ranges.items():
            word = self.before[path]
            if word.kind == "const":
                continue
            if self.types[path] == "float":
                for kind, end in (("cmpltsp", low), ("cmpgtsp", high)):
                    bits = graph.const(int(np.float32(end).view(np.uint32)))
                    yield negated(graph, graph.op(kind, word, bits))
                yield graph.op("cmpeqsp", word, word)
            else:
                yield negated(graph, graph.op("cmpgtu", word, graph.const(int(high))))
        if "low_V" in self.before and self.ranges:
            yield negated(graph, graph.op("cmpgtsp", self.before["low_V"], self.before["high_V"]))

    def drawn(self, op: Op) -> Words:
        """Samples of an argument or of a word before the call: random numbers, ends, and any bits where they may be."""
        name = op.name or f"argument {op.number}"
        rng = np.random.default_rng(list(name.encode()))
        any_bits = rng.integers(0, 1 << 32, SAMPLES, dtype=np.uint32)
        low, high = self.ranges.get(op.name, (0, 0xFFFF_FFFF))
        if op.name and self.types[op.name] != "float":
            words = rng.integers(int(low), int(high), SAMPLES, dtype=np.uint32, endpoint=True)
            ends = np.array([low, high], np.uint32)
        else:
            if not op.name:
                low, high = -200.0, 200.0
            elif op.name not in self.ranges:
                moderate = rng.uniform(-2.0, 2.0, SAMPLES).astype(np.float32).view(np.uint32)
                return np.where(np.arange(SAMPLES) % 2, moderate, any_bits)  # bits alone soon overflow
            words = rng.uniform(low, high, SAMPLES).astype(np.float32).view(np.uint32)
            ends = np.array([low, high, min(max(0.0, low), high)], np.float32).view(np.uint32)
        words = np.where(rng.random(SAMPLES) < 0.1, rng.choice(ends, SAMPLES), words)
        if not op.name:
            words = np.where(rng.random(SAMPLES) < 0.2, any_bits, words)
        if op.name == "high_V":
            floats = np.maximum(words.view(np.float32), self.drawn(self.before["low_V"]).view(np.float32))
            return floats.view(np.uint32)
        return words

    def sample(self, index: int) -> str:
        """The arguments of a drawn sample, auxiliary channels among them."""
        given = [*self.arguments, *(self.before[path] for path in self.paths.get(AUX, ()))]
        values = [int(self.drawn(argument)[index]) for argument in given]
        return "arguments " + ", ".join(f"{value:#010x}" for value in values)


def state_ranges(model: Model, function: str) -> dict[str, tuple[float, float]]:
    """Path -> least and largest value, of every word of the structs before the call that has a box."""
    if function == "init":
        return {}
    boxes: dict[str, Interval] = dict(state_box(model))
    largest = {path: float(last) for path, last in parts_box(model).integers.items()}
    if model.learner:
        banks = bank_box(model)
        boxes |= {f"bank[{b}].{path}": box for b in (0, 1) for path, box in banks.items()}
        learner, points = learner_box(model), commit_numbers(model, coefficients(model), certify(model)).points
        boxes |= {f"learner.{path}": box for path, box in learner.floats.items()}
        for part in ("base", "candidate.bank"):
            boxes |= {f"learner.{part}.{path}": box for path, box in banks.items()}
        largest |= {f"learner.{path}": float(last) for path, last in learner.integers.items()}
        largest["learner.candidate.point"] = points - 1.0
    return {path: (b.low, b.high) for path, b in boxes.items()} | {path: (0.0, last) for path, last in largest.items()}
