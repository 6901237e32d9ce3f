"""A reset at every word that the firmware keeps, on the simulated C674x: nothing unsafe, nothing lost.

    python benchmarks/resets.py

The power fails at each word of the store that an image changes (erase, image, seal); of the word itself all, none or
some bits have changed. Unsafe is: behind the boot START drives with other parameters than those before or the new ones.
Lost is: the counter falls, an image that was acknowledged is gone, or the store takes the image no more. And the reset
comes at each cycle of the handler of exceptions, behind a first fault: lost is that fault. docs/firmware.md has the
figures.
"""

from __future__ import annotations

import numpy as np
from skipped_packets import MODEL, driven, image, machine, send

from hysgen.errors import TargetError
from hysgen.firmware.wire import FirmwareStatus
from hysgen_c674x.machine import Machine

NEVER = 0xFFFFFFFF
BITS = (NEVER, 0, 0x5A5AA5A5)
"""Bits of the last word that change: by turns."""
LATE = "    return 1u;\n}\n\nvoid hysgen_board_calibrate"


def store(target: Machine) -> None:
    """Image 1 is kept; the power fails while image 2 is written."""
    target.call("hysgen_simulated_boot")
    send(target, image(1.01, 1))
    target.call("hysgen_simulated_idle")
    target.call("hysgen_simulated_boot")
    send(target, image(0.99, 2))
    before = bytes(target.processor.memory)
    old = driven(target)
    target.processor.memory[:] = before
    target.call("cut", NEVER, 0)
    target.call("hysgen_simulated_idle")
    words, new = target.call("words_changed").bits, driven(target)
    assert 0 not in (old, new)
    assert old != new
    unsafe, lost = list[int](), list[int]()
    for count in range(1, words + 2):
        target.processor.memory[:] = before
        target.call("cut", count, BITS[count % len(BITS)])
        target.call("hysgen_simulated_idle")
        target.call("cut", NEVER, 0)
        target.call("hysgen_simulated_boot")
        counter, drives = target.call("counter").bits, driven(target)
        if drives != {1: old, 2: new}.get(counter):
            unsafe.append(count)
        target.call("hysgen_simulated_boot")
        send(target, image(0.99, 2))
        target.call("hysgen_simulated_idle")
        again = driven(target)
        if counter not in (1, 2) or (count > words and counter != 2) or again != new:
            lost.append(count)
    print(f"store: power cut at {words} words and behind them, {len(unsafe)} unsafe, {len(lost)} lost", *unsafe, *lost)


def fault(target: Machine) -> None:
    """The reset before is the first fault; an exception follows."""
    target.call("hysgen_simulated_boot")
    target.call("hysgen_simulated_interrupt", np.float32(MODEL.grid.y_min_um), np.float32(2.0))
    before, first = bytes(target.processor.memory), target.call("first_fault").bits
    assert first == FirmwareStatus.FAULT_RESET
    lost, cycles, back = list[int](), 0, False
    while not back:
        target.processor.memory[:] = before
        cycles += 1
        try:
            target.call("panic", cycle_limit=cycles)
            back = True
        except TargetError:
            pass
        target.call("hysgen_simulated_boot")
        if target.call("first_fault").bits | FirmwareStatus.FAULT_EXCEPTION != first | FirmwareStatus.FAULT_EXCEPTION:
            lost.append(cycles)
    print(f"first fault: reset at {cycles} cycles of the exception's handler, {len(lost)} lost", *lost)


if __name__ == "__main__":
    fault(machine({LATE: LATE.replace("1u", "0u")}))
    store(machine())
