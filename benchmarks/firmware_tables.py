"""Writes the tables of docs/firmware_results.md: sizes and cycles of the firmware's four images on the C6748.

    python benchmarks/firmware_tables.py      (about three minutes; needs firmware/toolchain/build_c674x.sh)

Both reference models, by gcc alone and with the scheduled kernels; what each number is stands in the page.
"""

import re
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any

from hysgen.firmware import firmware_model
from hysgen_c674x.caches import Misses
from hysgen_c674x.firmware.timing import BUDGET, TIMING_HEADS, Timing, image_cost, timing_rows
from hysgen_c674x.schedule.folder import kernels, with_kernels
from hysgen_lab.firmware.reference_models import firmware_models

PAGE = Path(__file__).resolve().parents[1] / "docs" / "firmware_results.md"
SAMPLES = 12_000
IMAGES = (("appendix_a", True), ("extended", True), ("appendix_a", False), ("extended", False))
HEADS = [("Appendix A" if name == "appendix_a" else name) + ", kernels" * kernel for name, kernel in IMAGES]
STATES = (("POWER", "RISE"), ("LOOP", "HOLD"), ("APPROACH", "TRACK"))
FUNCTIONS = ("inverse", "learn_init", "learn", "commit")


def cost(name: str, scheduled: bool) -> dict[str, Any]:
    """What `hysgen firmware` says of an image with the learner, as JSON."""
    (model,) = (each for each in firmware_models() if each.name == name)
    texts = firmware_model(model, aligned=scheduled)
    if scheduled:
        texts = with_kernels(name, texts, kernels(name, texts))
    return image_cost(model, texts, SAMPLES, lambda _: None, print)


def table(heads: Sequence[str], rows: Sequence[Sequence[object]]) -> str:
    """A table of Markdown."""
    return "\n".join(f"| {' | '.join(map(str, row))} |" for row in (heads, ["---"] * len(heads), *rows))


def span(pair: Sequence[int]) -> str:
    return f"{pair[0]} .. {pair[1]}"


def sizes(costs: Sequence[dict[str, Any]]) -> str:
    sections = [{each["name"]: each for each in cost["target"]["sections"]} for cost in costs]
    rows = [
        [
            name,
            f"0x{sections[0][name]['address']:08x}" if row < 2 else "behind it",
            *(each[name]["size"] for each in sections),
        ]
        for row, name in enumerate(sections[0])
    ]
    used = [cost["target"]["used"]["L2 RAM"] for cost in costs]
    return table(["section", "address", *HEADS], [*rows, ["of 262144", "all of it", *used]])


def cycles(costs: Sequence[dict[str, Any]]) -> str:
    runs = [cost["simulated"] for cost in costs]
    assert all(run["equal"] for run in runs), "not the host's bits"
    rows: list[list[object]] = []
    for states in STATES:
        spans = [[run["interrupt"][state] for state in states] for run in runs]
        whole = [(min(low for low, _ in each), max(high for _, high in each)) for each in spans]
        shares = [f" ({round(100 * high / BUDGET)} %)" * ("TRACK" in states) for _, high in whole]
        rows.append(
            [f"interrupt in {' and '.join(states)}", *(span(w) + share for w, share in zip(whole, shares, strict=True))]
        )
    rows.append(["idle loop, a call of commit included", *(span(run["idle"]) for run in runs)])
    rows += [
        [text, *(run[key] for run in runs)]
        for text, key in (("boot with self-test", "boot"), ("commits on the way", "commits"))
    ]
    return table(["", *HEADS], rows)


def bounds(costs: Sequence[dict[str, Any]]) -> str:
    names = ["hysgen_firmware_interrupt", *FUNCTIONS]
    found = [
        {key.removeprefix(f"{name}_"): value for key, value in cost["bounds"].items()}
        for cost, (name, _) in zip(costs, IMAGES, strict=True)
    ]
    return table(["function", *HEADS], [[name, *(span(each[name]) for each in found)] for name in names])


def timing(costs: Sequence[dict[str, Any]]) -> str:
    rows: list[list[str]] = []
    for head, cost in sorted(zip(HEADS, costs, strict=True), key=lambda pair: pair[0]):
        cases = {
            f"{head}, {name}": Timing(each["delay"], each["total"], Misses(*each["cold"]), Misses(*each["warm"]))
            for name, each in cost["timing"].items()
        }
        rows += timing_rows(cases, BUDGET)
    return table(TIMING_HEADS, rows)


def main() -> None:
    with ProcessPoolExecutor() as processes:
        costs = [*processes.map(cost, *zip(*IMAGES, strict=True))]
    page = PAGE.read_text(encoding="utf-8")
    for write in (sizes, cycles, bounds, timing):
        mark = f"<!-- {write.__name__} -->\n"
        page, count = re.subn(f"{mark}(\\|.*\n)*", f"{mark}{write(costs)}\n", page)
        assert count == 1, mark
    PAGE.write_text(page, encoding="utf-8")


if __name__ == "__main__":
    main()
