"""`python -m hysgen_c674x FILE.c [FILE.c ...]`: code bytes and cycles of each function of C files on the C674x."""

import sys
from pathlib import Path

from hysgen.errors import HysgenError, TargetError
from hysgen_c674x import toolchain
from hysgen_c674x.cycles import bounds


def report(paths: list[Path]) -> str:
    """A table of code bytes and stall-free cycle bounds of every function in the files."""
    firmware = toolchain.compile([(path.name, path.read_text(encoding="utf-8")) for path in paths])
    decoded = firmware.packets
    lines = [f"{'function':32} {'code B':>8} {'cycles':>12}"]
    for symbol in sorted(firmware.image.symbols.values(), key=lambda each: each.address):
        if not symbol.function or symbol.name.startswith("__"):
            continue
        try:
            cycles = bounds(firmware.image, decoded, symbol.name)
            shown = str(cycles.best) if cycles.constant else f"{cycles.best} .. {cycles.worst}"
        except TargetError as refusal:
            shown = f"not bounded: {refusal}"
        lines.append(f"{symbol.name:32} {symbol.size:8} {shown:>12}")
    sizes = ", ".join(f"{name} {size} B" for name, size in firmware.section_bytes.items())
    return "\n".join([*lines, sizes, "stall-free: caches, memory banks and cross paths may add cycles"])


def main() -> int:
    """Print the report, or the error in one line."""
    paths = [Path(argument) for argument in sys.argv[1:]]
    try:
        missing = [str(path) for path in paths if not path.is_file()]
        if missing or not paths:
            raise TargetError(f"{' '.join(missing) or 'no file'}: not there; name the C files to compile")
        print(report(paths))
    except HysgenError as fault:
        print(f"hysgen_c674x: {fault}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
