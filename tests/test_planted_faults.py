"""What benchmarks/planted_faults.py plants: every way that its help lists, in Python and C, and nothing in words."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

BENCHMARKS = Path(__file__).parents[1] / "benchmarks"
IN_PYTHON = {
    "z = a[i] + b": {"z = a[i] - b"},
    "a -= b": {"a += b", "pass"},
    "if x <= 1.5: return": {
        *("if x < 1.5: return", "if x > 1.5: return", "if x <= 15.0: return"),
        *("if True: return", "if False: return", "if x <= 1.5: pass"),
    },
    "y = a is not None and b not in c": {
        *("y = a is None and b not in c", "y = a is not None or b not in c", "y = a is not None and b in c"),
    },
    "return not ready": {"return ready"},
    "f(x, y)": {"f(y, x)", "pass"},
    "raise E": {"pass"},
    "self.a = b": {"pass"},
    "n = 0": {"n = 1"},
    "on = 'µ', True": {"on = 'µ', False"},
}
WORDS_IN_PYTHON = """'''1 < 2'''
__all__ = [1]
if TYPE_CHECKING: import b
Kind = Literal[1, 2]
@cache(1)
def f(x: Literal[1]) -> Literal[2]:
    assert x < 1
    t = max(x, y), f'{x + 1}', zip(x, strict=True)
"""
IN_C = {
    "    x = a + b[i];": {"    x = a - b[i];", "    ;"},
    "    if (!far && n > 2u) {": {
        *("    if (far && n > 2u) {", "    if (!far || n > 2u) {", "    if (!far && n > 3u) {", "    if (1) {"),
        *("    if (!far && n >= 2u) {", "    if (!far && n <= 2u) {", "    if (0) {"),
    },
    "    {{ name }}_f(&x, {{ y }});": {"    {{ name }}_f({{ y }}, &x);", "    ;"},
    "const float most = 0.5f;": {"const float most = 5.0f;"},
    "    bits |= 0x0Fu << 2;": {"    bits &= 0x0Fu << 2;", "    bits |= 0x10u << 2;", "    bits |= 0x0Fu >> 2;"}
    | {"    bits |= 0x0Fu << 3;", "    ;"},
}
WORDS_IN_C = """#define N 3
/* 1 < 2 */ // 1 + 2
{% if n > 2 %}
static float *f(const float *a, int b);
    const char *text = "a + 1";
"""


@pytest.fixture
def changed(monkeypatch: pytest.MonkeyPatch) -> Callable[[str, str], set[str]]:
    """`changed("python" or "c", text)`: the texts with one fault each."""
    monkeypatch.syspath_prepend(BENCHMARKS)
    sites: Any = importlib.import_module("fault_sites")

    def found(language: str, text: str) -> Iterator[str]:
        data = text.encode()
        for begin, end, new, _ in getattr(sites, f"{language}_sites")(text):
            yield (data[:begin] + new.encode() + data[end:]).decode()

    return lambda language, text: set(found(language, text))


@pytest.mark.parametrize("text", IN_PYTHON, ids=range(len(IN_PYTHON)))
def test_every_way_to_be_wrong_is_planted_in_python(changed: Callable[[str, str], set[str]], text: str) -> None:
    assert changed("python", text) == IN_PYTHON[text]


@pytest.mark.parametrize("text", IN_C)
def test_every_way_to_be_wrong_is_planted_in_c(changed: Callable[[str, str], set[str]], text: str) -> None:
    assert changed("c", text) == IN_C[text]


@pytest.mark.parametrize(("language", "text"), [("python", WORDS_IN_PYTHON), ("c", WORDS_IN_C)])
def test_nothing_is_planted_in_words(changed: Callable[[str, str], set[str]], language: str, text: str) -> None:
    assert changed(language, text) == set()


@pytest.mark.parametrize(
    ("code", "output", "ended"),
    [
        *((code, "", True) for code in (-2, 130, -15, 143, -9, 137)),
        (2, "!!! KeyboardInterrupt !!!", True),
        (2, "ERROR tests/test_a.py - KeyboardInterrupt", False),
        *((code, "", False) for code in (None, 0, 1, 5, -11, -6)),
    ],
)
def test_a_run_that_somebody_ends_does_not_see_a_fault(
    code: int | None, output: str, ended: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.syspath_prepend(BENCHMARKS)
    assert importlib.import_module("planted_faults").interrupted(code, output) is ended
