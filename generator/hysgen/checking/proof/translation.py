"""Generated C computes the bits of its reference for every input: translation validation, function by function.

The reference is called with symbols in place of numbers (`symbolic.arrays`), the C is executed with the same symbols
(`symbolic.from_c`), and every word that they leave is compared (`symbolic.equivalence`): equal operations of equal
operands, or selections and bit tricks that a solver finds equal. Assumed are the certified box of the state before the
call, which `hysgen prove` shows to be left by no call, indices inside their arrays, and that the compiler keeps the
semantics of C; `hysgen verify` samples the compiler.

Source: Pnueli, Siegel, Singerman, Translation validation (1998).
"""

from __future__ import annotations

import dataclasses
import importlib.util
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from hysgen.checking.proof.eva.boxes import bank_box, parts_box, state_box
from hysgen.checking.symbolic.arrays import Symbols, coerced, traced, with_symbols
from hysgen.checking.symbolic.dataflow import Graph, Op
from hysgen.checking.symbolic.equivalence import SAMPLES, SOLVER, Sweep
from hysgen.checking.symbolic.expressions import negated
from hysgen.checking.symbolic.from_c import outcome
from hysgen.checking.symbolic.source import KernelRefusalError, Source
from hysgen.codegen.structs import interface_of
from hysgen.float32.coefficients import Bank
from hysgen.float32.reference.instance import Instance
from hysgen.model.model import Model
from hysgen.model.structs import Word

Words = NDArray[np.uint32]

ARGUMENTS: Final[Mapping[str, int]] = {"init": 2, "limits": 3, "predict": 2, "simulate": 1, "inverse": 2}
"""Float arguments of the functions that are proved."""


@dataclass(frozen=True)
class FunctionProof:
    """The proof that one function computes the bits of its reference.

    words: compared, the returned one included. open: those not shown equal, by their C path. solved: equalities that
    the solver decided. difference: of the first open word that differs in a drawn sample, the sample. refused: why
    there is no proof, if the function is outside what is traced.
    """

    function: str
    words: int
    open: tuple[str, ...]
    solved: int
    seconds: float
    difference: str = ""
    refused: str = ""

    @property
    def holds(self) -> bool:
        return not self.open and not self.refused

    def line(self) -> str:
        if self.refused:
            return f"{self.function}: not proved: {self.refused}"
        if self.difference:
            return f"{self.function}: DIFFERS: {self.difference}"
        said = f"{self.words} words, {self.solved} equalities by the solver, {self.seconds:.1f} s"
        if self.open:
            return f"{self.function}: not proved: {len(self.open)} words are open, {self.open[0]} first ({said})"
        return f"{self.function}: equal for every input ({said})"


@dataclass(frozen=True)
class Translation:
    """The proofs of all functions; solver: whether it was installed. sampled: functions without a proof."""

    model: str
    solver: bool
    functions: tuple[FunctionProof, ...]
    sampled: tuple[str, ...]

    @property
    def holds(self) -> bool:
        """Whether no function was seen to differ."""
        return not any(proof.difference for proof in self.functions)

    def lines(self) -> list[str]:
        lines = [proof.line() for proof in self.functions]
        lines += [f"{function}: not proved; `hysgen verify` samples it" for function in self.sampled]
        if not self.solver:
            lines.append("without a solver, equal forms alone are proved: pip install 'hysgen[prove]'")
        proved = sum(proof.holds for proof in self.functions)
        return [*lines, f"{self.model}: {proved} of {len(self.functions) + len(self.sampled)} functions proved"]

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values."""
        return dataclasses.asdict(self) | {"holds": self.holds}


def translation(
    model: Model, texts: Mapping[str, str], *, progress: Callable[[float, str], None] | None = None
) -> Translation:
    """Prove every function of ARGUMENTS that the texts of `generate` define; the others are named.

    Raises ModelError for a part of the model without a box of its states.
    """
    interface = interface_of(model.name, texts)
    source = Source(model.name, texts)
    names = [name for name in ARGUMENTS if interface.has(name)]
    proofs: list[FunctionProof] = []
    for place, function in enumerate(names):
        if progress is not None:
            progress(place / len(names), f"proof of {function}")
        proofs.append(_proved(model, source, interface, function))
    sampled = tuple(name for name in ("learn", "learn_init", "commit") if interface.has(name))
    return Translation(model.name, importlib.util.find_spec(SOLVER) is not None, tuple(proofs), sampled)


def _proved(model: Model, source: Source, interface: Any, function: str) -> FunctionProof:
    begun = time.monotonic()
    words = tuple(interface.struct(f"{model.name}_t").words())
    call = _Call(model, function, words, state_ranges(model, function))
    try:
        pairs = list(call.pairs(source))
    except KernelRefusalError as refusal:
        return FunctionProof(function, 0, (), 0, time.monotonic() - begun, refused=str(refusal))
    sweep = Sweep(call.drawn, list(call.assumed()))
    compared = sweep.pairs([pair[1:] for pair in pairs])
    open_words: list[str] = []
    difference = ""
    for (path, _, _), (got, expected) in zip(pairs, compared, strict=True):
        if got is expected:
            continue
        open_words.append(path)
        wrong = np.flatnonzero(sweep.values(got) != sweep.values(expected))
        if wrong.size and not difference:
            in_c, in_reference = (int(sweep.values(op)[wrong[0]]) for op in (got, expected))
            difference = (
                f"{path}: {in_c:#010x} in C, {in_reference:#010x} in the reference, for {call.sample(int(wrong[0]))}"
            )
    seconds = time.monotonic() - begun
    return FunctionProof(function, len(pairs), tuple(open_words), sweep.decided, seconds, difference)


@dataclass
class _Call:
    """One function, called with symbols. words: of its struct. ranges: of the words before the call that have one."""

    model: Model
    function: str
    words: Sequence[Word]
    ranges: Mapping[str, tuple[float, float]]

    def __post_init__(self) -> None:
        self.graph = Graph()
        self.types = {word.path: word.type for word in self.words}
        self.arguments = [self.graph.param(k) for k in range(ARGUMENTS[self.function])]
        self.before = {word.path: self._started(word.path) for word in self.words}

    def _started(self, path: str) -> Op:
        """The word before the call; a number, if its range is one."""
        low, high = self.ranges.get(path, (0, 1))
        if low == high:
            return self.graph.const(int(np.float32(low + 0.0).view(np.uint32)))
        return self.graph.symbol(path)

    def pairs(self, source: Source) -> Iterator[tuple[str, Op, Op]]:
        """Path of every word after the call, its value in C and in the reference."""
        for active in (None,) if self.function == "init" else (0, 1):
            before = dict(self.before)
            if active is not None:
                before["active"] = self.graph.const(active)
            function = f"{self.model.name}_{self.function}"
            after = outcome(source, self.graph, function, [list(before.values()), *self.arguments])
            in_c = dict(zip(before, after.structs["self"], strict=True))
            with traced(), np.errstate(all="ignore"):
                expected, result = self._reference(before, active or 0)
            for path, value in in_c.items():
                yield path, value, expected.get(path, before[path])
            if after.result is not None:
                yield "result", after.result, result

    def _reference(self, before: Mapping[str, Op], active: int) -> tuple[dict[str, Op], Any]:
        """Words that the reference leaves, by their path in C, and what it returns."""
        graph, model = self.graph, self.model
        arguments = [Symbols.of(graph, [argument], np.float32) for argument in self.arguments]
        start = np.zeros(1, np.float32)
        lanes = Instance(model, start, start)
        paths = [word.path for word in self.words][1 : 1 + len(lanes.words())]  # `active` is no word of the mirror
        lanes = with_symbols(graph, lanes)
        if self.function != "init":
            lanes.restore([Symbols.of(graph, [before[path]]) for path in paths])
            groups = ("slope", "offset", "gain", "weight")
            lanes.bank = Bank(*(self._row(before, f"bank[{active}].{group}[") for group in groups))
        returned = getattr(lanes, self.function)(*arguments)
        words = [coerced(graph, word, np.dtype(np.uint32)).ops.ravel()[0] for word in lanes.words().values()]
        expected = dict(zip(paths, words, strict=True))
        if self.function == "init":
            expected |= {"active": graph.const(0)} | self._banks(lanes.numbers.bank)
        return expected, returned.ops.ravel()[0] if isinstance(returned, Symbols) else None

    def _row(self, before: Mapping[str, Op], prefix: str) -> Any:
        ops = [op for path, op in before.items() if path.startswith(prefix)]
        return Symbols.of(self.graph, ops, np.float32)

    def _banks(self, bank: Any) -> dict[str, Op]:
        """Both banks as `init` writes them."""
        rows = {path: op for path, op in self.before.items() if path.startswith("bank[")}
        numbers = [op for row in (bank.slope, bank.offset, bank.gain, bank.weight) for op in row.ops]
        return dict(zip(rows, [*numbers, *numbers], strict=True))

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
        if "low_V" in self.ranges:
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
                return any_bits
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
        """The arguments of a drawn sample."""
        values = [int(self.drawn(argument)[index]) for argument in self.arguments]
        return "arguments " + ", ".join(f"{value:#010x}" for value in values)


def state_ranges(model: Model, function: str) -> dict[str, tuple[float, float]]:
    """C path -> least and largest value, of every word of the struct before the call that has a box."""
    if function == "init":
        return {}
    boxes, largest = dict(state_box(model)), parts_box(model).integers
    if model.learner:
        boxes |= {f"bank[{b}].{path}": box for b in (0, 1) for path, box in bank_box(model).items()}
    return {path: (b.low, b.high) for path, b in boxes.items()} | {path: (0, last) for path, last in largest.items()}
