"""Compiled C gives the same bits on the simulated C674x as on the host, and the two engines the same cycles."""

import numpy as np
import pytest
from numpy.typing import NDArray

from fixtures.c674x_compiler import firmware, host, need_compiler
from fixtures.c674x_random_c import random_program
from hysgen.errors import TargetError
from hysgen.machine import native
from hysgen_c674x import toolchain

pytestmark = pytest.mark.slow

N = 18
LEARNER_WORDS = 2 * N + N * (N - 1) // 2


def predictions(count: int) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Displacements and voltages inside the model's range, outside it, and at its ends."""
    rng = np.random.default_rng(11)
    y = rng.uniform(-1.0, 6.0, count).astype(np.float32)
    u = rng.uniform(-60.0, 160.0, count).astype(np.float32)
    edges = np.float32([0.6608, 3.7359, 0.0, -0.0, 1e6])
    y[:5], u[5:10] = edges, edges * 30
    return y, u


def learning(count: int) -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.float32]]:
    """A learner's first state, regressors and errors."""
    rng = np.random.default_rng(12)
    state = np.concatenate([np.zeros(N), np.full(N, 1e3), np.zeros(LEARNER_WORDS - 2 * N)]).astype(np.float32)
    return state, rng.uniform(-1, 1, (count, N)).astype(np.float32), rng.normal(0, 0.1, count).astype(np.float32)


def test_predictions_are_the_hosts_bit_for_bit() -> None:
    y, u = predictions(20_000)
    found = firmware("predict").machine().map("predict", y, u)
    function = host("predict", "float predict(float, float);").lib.predict
    expected = np.float32([function(float(a), float(b)) for a, b in zip(y, u, strict=True)])
    assert np.count_nonzero(found.bits != expected.view(np.uint32)) == 0
    assert (found.denormals, found.nans) == (0, 0)


def test_branch_free_code_takes_the_same_cycles_for_every_input() -> None:
    found = firmware("predict").machine().map("predict", *predictions(2_000))
    assert found.cycles.min() == found.cycles.max() <= 180


def test_chained_updates_leave_the_hosts_state_bit_for_bit() -> None:
    state, phi, errors = learning(3_000)
    machine = firmware("learn").machine()
    self, regressor = machine.allocate(LEARNER_WORDS), machine.allocate(N)
    machine.write(self, state)
    found = machine.map("learn", self, regressor, errors, write={regressor: phi}, read={self: LEARNER_WORDS})

    library = host("learn", "void learn(void *, const float *, float);")
    for i, (row, error) in enumerate(zip(phi, errors, strict=True)):
        library.lib.learn(
            library.ffi.from_buffer(state), library.ffi.from_buffer("float[]", row.tobytes()), float(error)
        )
        assert np.array_equal(found.memory[self][i], state.view(np.uint32)), f"after update {i}"
    assert found.denormals == 0


def test_interpreter_and_engine_agree_on_bits_cycles_and_stalls() -> None:
    y, u = predictions(60)
    state, phi, errors = learning(4)
    outcomes = []
    for interpreted in (True, False):
        predicted = firmware("predict").machine(interpreted).map("predict", y, u)
        machine = firmware("learn").machine(interpreted)
        self, regressor = machine.allocate(LEARNER_WORDS), machine.allocate(N)
        machine.write(self, state)
        learned = machine.map("learn", self, regressor, errors, write={regressor: phi}, read={self: LEARNER_WORDS})
        last = machine.call("learn", self, regressor, 0.5)
        outcomes.append((predicted, learned, last, learned.memory[self]))
    (predicted, learned, last, states), (predicted_fast, learned_fast, last_fast, states_fast) = outcomes
    assert np.array_equal(predicted.bits, predicted_fast.bits)
    assert np.array_equal(predicted.cycles, predicted_fast.cycles)
    assert np.array_equal(states, states_fast)
    assert np.array_equal(learned.cycles, learned_fast.cycles)
    assert np.array_equal(learned.stalls, learned_fast.stalls)
    assert last == last_fast
    assert last.stack_bytes > 0


def test_integer_code_bytes_and_library_calls_are_the_hosts() -> None:
    machine = firmware("integers").machine()
    library = host(
        "integers",
        "uint32_t hash(const uint8_t *, uint32_t); int32_t sum_of_halves(const int16_t *, uint32_t);"
        "int32_t converted(float); float divided(float, float);"
        "uint32_t collatz(uint32_t); uint32_t sorted(int32_t *);",
    )
    rng = np.random.default_rng(13)
    place = machine.allocate(8)
    for _ in range(100):
        words = rng.integers(-(2**31), 2**31, 8).astype(np.int32)
        machine.write(place, words)
        data = words.tobytes()
        assert machine.call("hash", place, 32).bits == library.lib.hash(library.ffi.from_buffer(data), 32)
        halves = library.lib.sum_of_halves(library.ffi.from_buffer("int16_t[]", data), 16)
        assert machine.call("sum_of_halves", place, 16).bits == halves & 0xFFFF_FFFF
        x = float(np.float32(rng.uniform(-30_000, 30_000)))
        assert machine.call("converted", x).bits == library.lib.converted(x) & 0xFFFF_FFFF
        a, b = (float(value) for value in rng.normal(0, 100, 2).astype(np.float32))
        assert machine.call("divided", a, b).float32 == library.lib.divided(a, b)
        n = int(rng.integers(1, 10_000))
        assert machine.call("collatz", n).bits == library.lib.collatz(n)
        moves = machine.call("sorted", place).bits
        ordered = words.copy()
        assert moves == library.lib.sorted(library.ffi.from_buffer("int32_t[]", ordered))
        assert np.array_equal(machine.read(place, 8, np.int32), ordered)


@pytest.mark.parametrize("seed", range(4))
def test_random_programs_are_the_hosts_bit_for_bit(seed: int) -> None:
    need_compiler()
    text, names, declarations = random_program(seed, functions=6)
    library = native.build([("random.c", text)], declarations, None, ())
    program = toolchain.compile([("random.c", text)], ("-Wno-error",))
    fast, slow = program.machine(), program.machine(interpreted=True)
    rng = np.random.default_rng(seed)
    for name in names:
        for trial in range(40):
            a, b = (int(value) for value in rng.integers(0, 2**32, 2) >> rng.integers(0, 32, 2))
            x, y = (float(value) for value in rng.uniform(-100, 100, 2).astype(np.float32))
            outcome = fast.call(name, a, b, x, y)
            assert hex(outcome.bits) == hex(getattr(library.lib, name)(a, b, x, y)), (name, a, b, x, y)
            if trial < 3:
                assert slow.call(name, a, b, x, y) == outcome


def test_denormals_differ_from_the_host_and_are_counted() -> None:
    need_compiler()
    text = "float product(float a, float b); float product(float a, float b) { return a * b; }"
    outcome = toolchain.compile([("product.c", text)]).machine().call("product", 1e-20, 1e-20)
    assert np.float32(1e-20) * np.float32(1e-20) > 0
    assert (outcome.float32, outcome.counts.denormals) == (0.0, 1)


def test_misuse_of_a_machine_is_told_in_one_line() -> None:
    machine = firmware("predict").machine()
    cases = {
        "no such symbol": lambda: machine.call("simulate"),
        "ten go in registers": lambda: machine.call("predict", *range(11)),
        "make them one": lambda: machine.map("predict", np.zeros(3, np.float32), np.zeros(4, np.float32)),
        "outside the target's memory": lambda: machine.read(0x100, 4),
        "do not fit": lambda: machine.allocate(70_000),
        "not 32 bits wide": lambda: machine.write(machine.allocate(4), np.zeros(4)),
        "still running after 50 cycles": lambda: machine.call("predict", 1.0, 1.0, cycle_limit=50),
    }
    for complaint, misuse in cases.items():
        with pytest.raises(TargetError, match=complaint) as refusal:
            misuse()
        assert "\n" not in str(refusal.value)


def test_a_register_not_given_back_is_an_error() -> None:
    need_compiler()
    text = 'void spoil(void); void spoil(void) { __asm__ volatile("mvk .S1 1,a10"); }'
    with pytest.raises(TargetError, match="returned with register a10 changed"):
        toolchain.compile([("spoil.c", text)]).machine().call("spoil")
