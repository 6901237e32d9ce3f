"""The comparison itself, on a machine of two words with planted faults: every fault is reported, and only those."""

import dataclasses
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from hysgen.checking import Build
from hysgen.checking.bits import ComparedRun, Mismatch, Report
from hysgen.checking.bits.comparison import Task, compare_selftest, compare_task, shares, tasks
from hysgen.checking.bits.functions import NEARLY_FULL, STYLES, CallTrace, ComparedStruct, chunks, ranges, weaker_stage
from hysgen.float32.reference.instance import Instance
from hysgen.machine.native import Toolchain
from hysgen.model.file import load_model

Words = NDArray[np.uint32]
Spoil = Callable[[int, Words, Words], None]
MODEL = load_model("appendix_a")


class Host:
    """A function that adds its first argument to word 0 and counts its calls in word 1; spoil: the planted fault."""

    name, channels, selftested, commits = "two", 0, True, False

    def __init__(self, spoil: Spoil = lambda call, words, result: None, returns: bool = False) -> None:
        self.spoil, self.returns, self.runs, self.calls, self.failures = spoil, returns, 0, 0, 0

    def words_of(self, struct: Words) -> Words:
        return struct

    def layout(self, struct: str) -> dict[str, int]:
        assert struct == "two_learner_t"
        return {"before": 0, "sum": 1, "count": 2}

    def call(self, function: str) -> int:
        assert function == "selftest"
        return self.failures

    def run(
        self, function: str, struct: Words, columns: Sequence[Words], *, first: int, words: int, flush: bool
    ) -> tuple[Words, Words]:
        assert (function, first, words) == ("learn", 1, 2)
        self.runs += 1
        out, after = np.zeros(columns[0].size, np.uint32), np.empty((columns[0].size, 2), np.uint32)
        for i, (a, _) in enumerate(zip(*columns, strict=True)):
            struct[1:] += np.array([a, 1], np.uint32)
            result = np.array([struct[1] if self.returns else 0], np.uint32)
            self.spoil(self.calls, struct[1:], result)
            out[i], after[i], self.calls = result[0], struct[1:], self.calls + 1
        return out, after


class Reference:
    """The same in NumPy, over lanes."""

    def __init__(self, returns: bool) -> None:
        self.returns = returns
        self.sum = self.count = np.zeros(1, np.uint32)

    def words(self) -> dict[str, Words]:
        return {"sum": self.sum, "count": self.count}

    def restore(self, words: Sequence[Words]) -> None:
        self.sum, self.count = words

    def learn(self, y: NDArray[np.float32], u: NDArray[np.float32]) -> NDArray[np.float32] | None:
        self.sum, self.count = self.sum + y.view(np.uint32), self.count + np.uint32(1)
        return self.sum.view(np.float32) if self.returns else None


def compared(
    *hosts: Any, style: str = "random", samples: int = 120, returns: bool = False
) -> tuple[ComparedRun, list[Mismatch], list[int]]:
    def wear(host: Any, struct: Words) -> None:
        struct[2] = NEARLY_FULL

    made = ComparedStruct(
        "learner_t",
        {"learn": ("measured", "voltage")},
        "sum",
        lambda host: np.zeros(3, np.uint32),
        lambda model: Reference(returns),
        wear,
        has_channels=False,
        chunk=50,
    )
    builds = [Build(Toolchain(f"cc{i}", ()), False, host) for i, host in enumerate(hosts)]
    progress: list[int] = []
    run, mismatches = compare_task(MODEL, builds, Task(made, "learn", style), samples, 3, progress.append)
    return run, mismatches, progress


def flipped(word: int, at: int, by: int = 1) -> Spoil:
    def spoil(call: int, words: Words, result: Words) -> None:
        if call == at:
            (words if word < 2 else result)[word % 2] ^= np.uint32(by)

    return spoil


@pytest.mark.parametrize("returns", [False, True])
def test_equal_builds_are_equal_in_every_chunk(returns: bool) -> None:
    run, mismatches, progress = compared(Host(returns=returns), Host(returns=returns), returns=returns)
    assert (run, mismatches) == (ComparedRun("appendix_a", "learn", "random", 120, 2), [])
    assert progress == [50, 50, 20]


@pytest.mark.parametrize("place", [0, 1, 2], ids=["one build more", "the first of two", "the second of two"])
@pytest.mark.parametrize(("word", "name"), [(0, "sum"), (1, "count"), (2, "result")])
@pytest.mark.parametrize("at", [0, 49, 50, 119])
def test_one_bit_of_one_build_is_found_wherever_it_is(place: int, word: int, name: str, at: int) -> None:
    """The learner returns nothing: equal results prove no equal states. One report: the next samples start from it."""
    hosts = [Host() for _ in range(max(place, 1))]
    hosts.insert(place if place < 2 else 1, Host(flipped(word, at)))
    found = hosts.index(next(host for host in hosts if host.spoil.__name__ == "spoil"))
    _, mismatches, progress = compared(*hosts)
    (mismatch,) = mismatches
    assert (mismatch.build, mismatch.sample, mismatch.word) == (f"cc{found}", at, name)
    assert mismatch.got ^ mismatch.expected == 1
    assert (mismatch.model, mismatch.function, mismatch.style) == ("appendix_a", "learn", "random")
    columns = [
        np.concatenate(parts)
        for parts in zip(*chunks(MODEL, "random", ["measured", "voltage"], 120, 3, 50), strict=True)
    ]
    assert mismatch.inputs == tuple(int(column[at]) for column in columns)
    assert progress == [50, 50, 20]


def test_the_earliest_sample_is_reported_and_the_build_is_left_out() -> None:
    def spoil(call: int, words: Words, result: Words) -> None:
        words[0] ^= np.uint32(call >= 30)
        words[1] ^= np.uint32(call >= 20)

    wrong, right = Host(spoil), Host()
    _, mismatches, _ = compared(right, wrong)
    assert [(mismatch.sample, mismatch.word) for mismatch in mismatches] == [(20, "count")]
    assert (wrong.runs, right.runs) == (1, 3)
    assert compared(Host(spoil), Host(spoil))[2] == [50], "nothing is left to compare"


def test_edges_are_compared_on_a_struct_after_months_of_operation() -> None:
    starts: dict[str, int] = {}
    for style in STYLES:

        def spoil(call: int, words: Words, result: Words, style: str = style) -> None:
            starts.setdefault(style, int(words[1]))

        compared(Host(spoil), style=style)
    assert starts == {"random": 1, "smooth": 1, "edges": NEARLY_FULL + 1, "patterns": 1}


@pytest.mark.parametrize("field", ["before", "results", "after"])
def test_traces_are_equal_in_all_parts_or_not_at_all(field: str) -> None:
    columns = [np.arange(5, dtype=np.uint32)]
    trace = CallTrace(columns, [], np.zeros((5, 2), np.uint32), np.zeros(5, np.uint32), np.ones((5, 2), np.uint32))
    other = getattr(trace, field).copy()
    assert trace.equals(dataclasses.replace(trace, **{field: other}))
    other.flat[3] ^= 1
    assert not trace.equals(dataclasses.replace(trace, **{field: other}))


@pytest.mark.parametrize("failures", [1, 2, 65536])
def test_a_self_test_with_any_mismatch_is_one_of_its_build(failures: int) -> None:
    hosts: list[Any] = [Host(), Host()]
    hosts[1].failures = failures
    run, mismatches = compare_selftest(MODEL, [Build(Toolchain("cc"), i == 1, host) for i, host in enumerate(hosts)])
    assert run == ComparedRun("appendix_a", "selftest", "fixed", 1, 2)
    assert [(m.build, m.got, m.expected, m.word) for m in mismatches] == [
        ("cc -O2, flush to zero", failures, 0, "result")
    ]


def test_every_function_of_the_header_is_compared_under_every_style_in_its_share() -> None:
    host: Any = Host()
    host.entries = dict.fromkeys(["init", "predict", "simulate", "learn", "other"])
    assert [(task.function, task.style) for task in tasks(host)] == [
        (function, style) for function in ("init", "predict", "simulate", "learn") for style in STYLES
    ]
    # A third of 1000 samples for each of three functions, in shares of 25, 40, 20 and 15 %; init 5000 per style.
    assert sum(samples for _, samples in shares(host, 1000)) == 3 * (84 + 134 + 67 + 50) + 4 * 5000
    assert [task.learns for task in tasks(host)] == [False] * 12 + [True] * 4


def column(style: str, quantity: str, samples: int = 20_000) -> NDArray[np.float32]:
    parts = [part[0] for part in chunks(MODEL, style, [quantity], samples, 5, 7000)]
    assert [part.size for part in parts[:-1]] == [7000] * (len(parts) - 1)
    return np.concatenate(parts).view(np.float32)


def test_inputs_reach_what_their_style_promises() -> None:
    low, high = (float(end) for end in ranges(MODEL)["voltage"])
    width = high - low
    drawn = column("random", "voltage")
    assert (drawn.min(), drawn.max()) == pytest.approx((low - 0.15 * width, high + 0.15 * width), abs=0.002 * width)
    assert np.mean((drawn >= low) & (drawn <= high)) == pytest.approx(1.0 / 1.3, abs=0.01)
    smooth = column("smooth", "voltage")
    k = np.arange(smooth.size)
    still = (k // 3000) % 5 == 4
    assert low <= smooth.min() < low + 0.1 * width < high - 0.1 * width < smooth.max() <= high
    assert np.unique(smooth[still & (k < 14_000)]).size == 1
    assert 1e-5 * width < np.abs(np.diff(smooth[~still])).mean() < 0.05 * width
    bits = column("edges", "voltage").view(np.uint32)
    special = [0.0, 2.0**-149, 2.0**-127, 2.0**-126, 2.0**-41, 2.0**-40, 2.0**-39, 1e9, 3e38, np.inf, low, high]
    ends = [np.nextafter(np.float32(end), np.float32(way)) for end in (low, high) for way in (-np.inf, np.inf)]
    for value in (*special, 0.5 * (low + high), *ends):
        assert {int(np.float32(sign * value).view(np.uint32)) for sign in (1, -1)} <= set(bits.tolist()), value
    assert {0x7FC00000, 0xFFC00000, 0x7F800001, 0xFFBFFFFF, 0x7FFFFFFF} <= set(bits.tolist())
    # An ordinary value in 40 %, and a special one held with probability 0.3 from the sample before.
    assert np.mean(np.diff(bits.astype(np.int64)) == 0) == pytest.approx(0.6**2 * (0.3 + 0.7 / 39), abs=0.03)
    patterns = column("patterns", "voltage").view(np.uint32)
    assert np.unpackbits(patterns.view(np.uint8)).mean() == pytest.approx(0.5, abs=0.002)


def test_a_reference_can_be_reached_and_what_is_measured_is_a_weaker_stage() -> None:
    names = ["displacement", "reference"]
    for style in ("random", "smooth"):
        (y, wanted), (_, u) = (
            next(chunks(MODEL, style, columns, 4000, 5)) for columns in (names, ["displacement", "voltage"])
        )
        start = Instance(MODEL, y.view(np.float32), np.zeros(4000, np.float32))
        np.testing.assert_array_equal(start.predict(y.view(np.float32), u.view(np.float32)).view(np.uint32), wanted)
    rng = np.random.default_rng(2)
    u = np.full(30_000, 60.0, np.float32).view(np.uint32)
    settled = weaker_stage(MODEL, u, rng).view(np.float32)[20_000:]
    weaker = dataclasses.replace(MODEL, consequents=MODEL.consequents * [1.0, 0.95, 1.0])
    rest = Instance(weaker, settled[:1], np.full(1, 60.0, np.float32))
    for _ in range(1500):
        y_um = rest.simulate(np.full(1, 60.0, np.float32))
    span = MODEL.grid.y_max_um - MODEL.grid.y_min_um
    assert settled.mean() == pytest.approx(float(y_um[0]), abs=1e-4 * span)
    assert settled.std() == pytest.approx(1e-4 * span, rel=0.05)


def test_the_report_counts_what_was_compared_and_is_equal_only_then() -> None:
    runs = (
        ComparedRun("a", "selftest", "fixed", 1, 4),
        ComparedRun("a", "init", "random", 5000, 4),
        ComparedRun("a", "predict", "random", 300, 4),
        ComparedRun("a", "predict", "edges", 200, 3),
        ComparedRun("a", "commit", "shadows", 70, 4),
        ComparedRun("b", "predict", "random", 9, 4),
    )
    report = Report("a", ("one",), (), (), runs, (), 2.0)
    assert (report.equal, report.samples) == (True, 500)
    rows = {(row[0], row[1]): row[2:] for row in report.summary().rows}
    assert rows["a", "predict"] == ["500", "4", "equal"]
    assert rows["b", "predict"] == ["9", "4", "equal"]
    mismatches = tuple(
        Mismatch("a", "predict", style, build, 1, "result", 0x3F800000, 7, (0x40000000,))
        for style, build in (("random", "one"), ("edges", "one"), ("edges", "other"))
    )
    wrong = dataclasses.replace(report, mismatches=mismatches)
    assert not wrong.equal
    assert {(row[0], row[1]): row[4] for row in wrong.summary().rows}["a", "predict"] == "2 differ"
    assert str(mismatches[0]) == (
        "a_predict(0x40000000 (2)): result is 0x3f800000 (1), expected 0x00000007 (7) [random inputs, sample 1, one]"
    )
    assert not dataclasses.replace(report, altered=("x",)).equal
    assert not dataclasses.replace(report, runs=()).equal
    assert (report.to_json()["equal"], report.to_json()["samples"]) == (True, 500)
    assert report.lines()[-1] == "a: equal in every bit over 500 samples per build, 2.0 s"
    assert wrong.lines()[-1].startswith("a: NOT EQUAL")
