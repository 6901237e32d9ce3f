"""How many wrong lines the tests let pass: plants faults, one at a time, and runs the tests that reach each of them.

    python benchmarks/planted_faults.py FOLDER                 200 faults of this commit, at most two hours on two cores
    python benchmarks/planted_faults.py FOLDER --list          the draw alone
    python benchmarks/planted_faults.py FOLDER --rerun FILE    the faults of an earlier results.jsonl, or of a list

It needs git, gcc, the packages of `pip install -e .[test]`, and coverage >= 7.6. FOLDER holds all that it writes:
`reached` (which test reaches which line, measured once for each commit; about half an hour), copies of the tree in
which the faults are planted, `results.jsonl` (a run that was interrupted goes on from there) and `survivors.txt`.

A room is a package directly below generator/hysgen (modules there: the room `api`), hysgen_c674x, hysgen_lab, the
templates of C, firmware/controller and firmware/board. The seed is the commit's hash. Each room gives as many faults as
any other, to within one: first a line is drawn among those of the room that can be changed, then a change of this line.

Operators, in Python, C and the C of the templates:

    binary       + and -, * and /, // and /, % and //, ** and *, & and |, ^ and &, << and >>, and the same with =
    comparison   < and <=, > and >=, each turned round as well; == and !=; `in`, `is` and their `not`
    logic        `and` and `or`, && and ||; `not` and ! left out
    constant     n to n + 1, x to 10 x, 0.0 to 1.0; True and False
    condition    that of an `if` to true, to false; of a `while` in Python to false
    dropped      calls whose result is not used, assignments to attributes and elements, `raise`, break, continue, and
                 returns inside an `if`
    swapped      two neighbouring arguments of a call

They are the slips of a hand that writes numerical code: a sign, a limit, an off-by-one, a unit, a forgotten step. Texts
(messages, help, names) are never changed, nor what only guards the writer: annotations, `assert`, `strict=` of zip,
decorators (frozen=, maxsize=), `__all__` and imports for type checking, tags of Jinja, and the preprocessor.
`<` to `<=` between floats, and limits of speed or of memory (how much a cache holds, when to stop an iteration), are
drawn although many of these faults are equivalent: those that a reader found so stand, with the reason, in
equivalent_faults.json beside this file, and are counted apart.

A fault that does not compile is drawn again. A fault is seen if a test fails that passes without it; a test that does
not end within five times its measured time counts as failed. A run that somebody ends (a signal from the keyboard, of
`kill`, or of a system without memory) says nothing: it is tried once more, then stands as interrupted. Tests marked
`golden` (stored bytes) and `proof` do not run. Lines that no test reaches survive at once. The tests of the fault's
room run first, short ones before long ones, as many as take --most-s seconds: "not all" counts survivors that others
reach, too. What a test reaches includes processes that it starts; a line that runs in a fixture or while a test file
is imported counts for all tests of the file; a line at the top of a module for the tests that run the module's
functions, or a function that names what the line defines; C of the firmware and of templates for the tests of a file
that opens it.

mutmut and cosmic-ray mutate Python alone: no C, no templates, and no draw by room.
"""

from __future__ import annotations

import argparse
import bisect
import itertools
import json
import os
import re
import shutil
import signal
import subprocess
import threading
import time
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from random import Random
from typing import Final

from fault_reach import PACKAGES, ROOT, Edit, Place, Reach, committed, compiles, in_threads, measure
from fault_sites import Site, c_sites, python_sites
from scipy.stats import beta

EQUIVALENT: Final = Path(__file__).with_name("equivalent_faults.json")
MOST_S: Final = 240.0
SLOWER: Final = 5.0
HOURS: Final = 2.0


@dataclass(frozen=True)
class Fault:
    room: str
    kind: str
    edits: tuple[Edit, ...]

    @property
    def key(self) -> str:
        return json.dumps([asdict(edit) for edit in self.edits])

    @property
    def of_python(self) -> bool:
        return all(edit.file.endswith(".py") for edit in self.edits)

    def __str__(self) -> str:
        lines = [f"{edit.file}:{edit.line}\n- {edit.old.strip()}\n+ {edit.new.strip()}" for edit in self.edits]
        return "\n".join(lines)


def rooms() -> dict[str, list[str]]:
    """The files of every room, from the commit."""
    found: dict[str, list[str]] = {}
    for name in committed():
        path = Path(name)
        of_c = name.endswith((".c.j2", ".h.j2")) or (path.parent.name == "templates" and "." not in path.stem)
        if name.startswith(PACKAGES) and path.suffix in (".py", ".c", ".h"):
            inside = path.parts[2] if len(path.parts) > 3 else "api"
            found.setdefault(inside if path.parts[1] == "hysgen" else path.parts[1], []).append(name)
        elif path.parts[0] == "templates" and of_c and path.suffix == ".j2":
            found.setdefault("templates", []).append(name)
        elif path.parts[:2] in {("firmware", "controller"), ("firmware", "board")} and path.suffix in (".c", ".h"):
            found.setdefault("/".join(path.parts[:2]), []).append(name)
    return found


def drawn(room: str, files: Sequence[str], seed: str) -> Iterator[Fault]:
    """Faults of a room in the order of the draw: a line, then a change of it. Those that do not compile are missing."""
    random = Random(f"{seed} {room}")
    lines: dict[tuple[str, int], list[Site]] = {}
    texts = {name: (ROOT / name).read_text(encoding="utf-8") for name in files}
    for name, text in texts.items():
        of_python = name.endswith(".py")
        # Positions in Python count bytes.
        starts = [place for place, byte in enumerate(text.encode() if of_python else text) if byte in (10, "\n")]
        for site in python_sites(text) if of_python else c_sites(text):
            lines.setdefault((name, bisect.bisect_left(starts, site[0]) + 1), []).append(site)
    for name, line in random.sample(sorted(lines), len(lines)):
        begin, end, new, kind = random.choice(sorted(lines[name, line]))
        text = texts[name]
        if name.endswith(".py"):
            begin, end = (len(text.encode()[:place].decode()) for place in (begin, end))
        first, last = text.rfind("\n", 0, begin) + 1, (text + "\n").index("\n", end)
        edit = Edit(name, line, text[first:last], text[first:begin] + new + text[end:last])
        if compiles(edit, text):
            yield Fault(room, kind, (edit,))


def interrupted(code: int | None, output: str) -> bool:
    """Whether pytest was ended from outside: by SIGINT, SIGKILL or SIGTERM, or 128 + one of them from a shell."""
    signals = (signal.SIGINT, signal.SIGKILL, signal.SIGTERM)
    by_name = "KeyboardInterrupt" in output and not re.search(r"^(?:FAILED|ERROR) ", output, re.MULTILINE)
    return code in {*(-number for number in signals), *(128 + number for number in signals)} or by_name


@dataclass
class Trial:
    """What became of a fault. tried: tests that ran. left: tests that reach it and did not run, for want of time."""

    fault: Fault
    outcome: str
    by: str = ""
    tried: int = 0
    left: int = 0
    seconds: float = 0.0


class Planter:
    def __init__(self, folder: Path, reach: Reach, most_s: float) -> None:
        self.folder, self.reach, self.most_s = folder, reach, most_s
        self.sound: set[str] = set()
        self.unsound: set[str] = set()
        self._writes = 10**9

    def trial(self, place: Place, fault: Fault, tests: Sequence[str]) -> Trial:
        """Plant a fault and run tests until one of them fails; they run in parts, the first one short."""
        trial, began = Trial(fault, "survived" if tests else "not reached"), time.monotonic()
        rest, spent, until = list(tests), 0.0, 8.0
        self._fresh_cache(place, fault)
        while rest and spent < self.most_s and trial.outcome == "survived":
            part: list[str] = []
            while rest and (not part or spent < min(until, self.most_s)):
                name = rest.pop(0)
                spent += self.reach.seconds[name]
                part += [name] * (name not in self.unsound)
            until *= 5.0
            for _ in range(2):
                code, output = self._planted(place, fault, part) if part else (0, "")
                if not interrupted(code, output):
                    break
            failed = re.search(r"^(?:FAILED|ERROR) (.+?)(?: - |$)", output, re.MULTILINE)
            by = failed[1] if failed else "no end" if code is None else f"exit {code}"
            if interrupted(code, output):
                trial.outcome = "interrupted"
            elif code in (0, 5):
                trial.tried += len(part)
            elif not fault.of_python and _does_not_compile(output):
                trial.outcome = "does not compile"
            elif code == 1 and by in self.reach.seconds and not self._is_sound(place, by):
                rest = part + rest
                spent -= sum(self.reach.seconds[name] for name in part)
            else:
                trial.outcome, trial.by = "seen", by
        trial.left, trial.seconds = len(rest), round(time.monotonic() - began, 1)
        return trial

    def _planted(self, place: Place, fault: Fault, tests: Sequence[str]) -> tuple[int | None, str]:
        """What pytest says with the fault in the source, which is put back."""
        texts = {edit.file: (place.tree / edit.file).read_text(encoding="utf-8") for edit in fault.edits}
        try:
            for edit in fault.edits:
                path = place.tree / edit.file
                self._write(path, edit.applied(path.read_text(encoding="utf-8")))
            return self._run(place, tests)
        finally:
            if not place.whole():
                place.make(measured=False)
            for file, text in texts.items():
                self._write(place.tree / file, text)

    def _run(self, place: Place, tests: Sequence[str]) -> tuple[int | None, str]:
        (place.folder / "tests.json").write_text(json.dumps(tests), encoding="utf-8")
        files = dict.fromkeys(name.partition("::")[0] for name in tests)
        most_s = 60.0 + 5.0 * len(files) + SLOWER * sum(self.reach.seconds[name] for name in tests)
        arguments = ["-x", "-m", "not proof and not golden", *files]
        return place.pytest(arguments, most_s, PLANTED_TESTS=str(place.folder / "tests.json"))

    def _is_sound(self, place: Place, name: str) -> bool:
        """Whether a test passes without a fault, here and now."""
        if name not in self.sound | self.unsound:
            passes = any(self._run(place, [name])[0] == 0 for _ in range(2))
            (self.sound if passes else self.unsound).add(name)
        return name in self.sound

    def _write(self, path: Path, text: str) -> None:
        # Compiled Python is known by the second of its source: every version gets its own.
        self._writes += 2
        path.write_text(text, encoding="utf-8")
        os.utime(path, (self._writes, self._writes))

    def _fresh_cache(self, place: Place, fault: Fault) -> None:
        """A cache that holds what the measured run compiled, but nothing where the fault is in compiling and caching.

        Its files are named by the digests of their sources. Results of computations are not among them.
        """
        shutil.rmtree(place.cache, ignore_errors=True)
        place.cache.mkdir()
        texts = [(place.tree / edit.file).read_text(encoding="utf-8") for edit in fault.edits]
        if fault.room == "machine" or any("hysgen.machine.native" in text for text in texts):
            return
        for path in (self.folder / "cache").glob("*.*o"):
            os.link(path, place.cache / path.name)


def _does_not_compile(output: str) -> bool:
    """Whether a C compiler refused a source, for another reason than a warning."""
    errors = [line for line in output.splitlines() if re.search(r"\.[ch]:\d+:\d+: error: |BuildError: .*error: ", line)]
    return any("-Werror" not in line for line in errors)


# The whole run


def results(path: Path) -> dict[str, Trial]:
    """The last trial of each fault in a file of results, but those that were interrupted."""
    found: dict[str, Trial] = {}
    for line in path.read_text(encoding="utf-8").splitlines() if path.exists() else ():
        content = json.loads(line)
        given = content.pop("fault")
        fault = Fault(given["room"], given["kind"], tuple(Edit(**edit) for edit in given["edits"]))
        if content["outcome"] != "interrupted":
            found[fault.key] = Trial(fault, **content)
    return found


def run(options: argparse.Namespace, draws: Mapping[str, Iterator[Fault]], tokens: Sequence[str]) -> dict[str, Trial]:
    """Plant the next fault of the room that each token names, as time allows."""
    folder, deadline = Path(options.folder), time.monotonic() + 3600.0 * options.hours
    path = folder / options.results
    done = results(path)
    planter = Planter(folder, Reach(folder / "reached"), options.most_s)
    lock, todo = threading.Lock(), list(reversed(tokens))
    counted: list[str] = []

    def keep(trial: Trial) -> None:
        with lock:
            done[trial.fault.key] = trial
            with path.open("a", encoding="utf-8") as file:
                file.write(json.dumps(asdict(trial)) + "\n")
            write_survivors(path.with_suffix(".survivors.txt"), [done[key] for key in counted if key in done])
            edit = trial.fault.edits[0]
            print(f"{trial.fault.room}: {edit.file}:{edit.line} {trial.outcome} {trial.by}", flush=True)

    def draw() -> Fault | None:
        """The next fault, which counts unless it does not compile."""
        with lock:
            while todo and time.monotonic() < deadline:
                fault = next(draws[todo.pop()], None)
                if fault is not None:
                    counted.append(fault.key)
                    return fault
        return None

    def work(number: int) -> None:
        place = Place(folder / f"planted-{number}")
        place.make(measured=False)
        while fault := draw():
            if fault.key not in done:
                keep(planter.trial(place, fault, planter.reach.ordered(fault.edits, fault.room)))
            if done[fault.key].outcome == "does not compile":
                with lock:
                    counted.remove(fault.key)
                    todo.append(fault.room)

    in_threads(work)
    if planter.unsound:
        print("tests that fail here without a fault, and did not count:", *sorted(planter.unsound), sep="\n  ")
    return {key: done[key] for key in counted if key in done}


def write_survivors(path: Path, trials: Iterable[Trial]) -> None:
    parts = []
    for trial in trials:
        if trial.outcome in ("survived", "not reached"):
            tests = f"{trial.tried} tests" + f" of {trial.tried + trial.left}" * (trial.left > 0)
            parts.append(f"[{trial.fault.room}, {trial.fault.kind}] {trial.outcome}, {tests}\n{trial.fault}\n")
    path.write_text("\n".join(parts), encoding="utf-8")


def equivalent() -> dict[tuple[str, str, str], str]:
    """Reasons by file, line and changed line."""
    listed = json.loads(EQUIVALENT.read_text(encoding="utf-8"))
    return {(each["file"], each["line"], each["fault"]): each["reason"] for each in listed}


def report(trials: Iterable[Trial]) -> str:
    """Survivors by room, with upper bounds at 95 %."""
    reasons = equivalent()
    counts: dict[str, Counter[str]] = {}
    for trial in trials:
        edits = trial.fault.edits
        same = all((edit.file, edit.old.strip(), edit.new.strip()) in reasons for edit in edits)
        outcome = "equivalent" if same and trial.outcome != "seen" else trial.outcome
        for room in (trial.fault.room, "all"):
            counts.setdefault(room, Counter())[outcome] += 1
            counts[room]["not all"] += outcome == "survived" and trial.left > 0
    columns = ("planted", "seen", "survived", "bound", "not reached", "not all", "equivalent", "interrupted")
    lines = [f"{'room':<22}" + "".join(f"{column:>13}" for column in columns)]
    for room in sorted(counts, key=lambda room: (room == "all", room)):
        count = counts[room]
        lost = count["survived"] + count["not reached"]
        planted = lost + count["seen"]
        bound = 1.0 if lost == planted else float(beta.ppf(0.95, lost + 1, planted - lost))
        cells = (planted, count["seen"], lost, f"{bound:.0%}", *(count[column] for column in columns[4:]))
        lines.append(f"{room:<22}" + "".join(f"{cell:>13}" for cell in cells))
    lines.append("bound: upper end of the one-sided 95 % interval of the surviving share (Clopper and Pearson).")
    lines.append("equivalent, interrupted: not among the planted; reasons of the equivalent in equivalent_faults.json.")
    return "\n".join(lines)


def listed_faults(path: Path, room_of: Mapping[str, str]) -> Iterator[Fault]:
    """The faults of an earlier results file, or of a list of {"edits": [{"file", "line", "old", "new"}, ...]}."""
    for line in path.read_text(encoding="utf-8").splitlines():
        content = json.loads(line)
        given = content.get("fault", content)
        edits = tuple(Edit(**edit) for edit in given["edits"])
        if content.get("outcome") != "does not compile":
            yield Fault(room_of[edits[0].file], given.get("kind", "listed"), edits)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", metavar="FOLDER")
    parser.add_argument("--count", type=int, default=200, help="faults to plant (default: %(default)s)")
    parser.add_argument("--only", metavar="ROOM", action="append", help="faults of this room alone; may be repeated")
    parser.add_argument("--seed", help="default: the commit's hash")
    parser.add_argument("--list", action="store_true", help="print the draw and end")
    parser.add_argument("--rerun", metavar="FILE", type=Path, help="plant these faults instead")
    parser.add_argument("--results", metavar="NAME", default="results.jsonl", help="default: %(default)s")
    parser.add_argument(
        "--most-s", type=float, default=MOST_S, help="seconds of tests for a fault (default: %(default)s)"
    )
    parser.add_argument("--hours", type=float, default=HOURS, help="default: %(default)s")
    options = parser.parse_args()
    head = subprocess.run(["git", "rev-parse", "HEAD"], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    seed, files = options.seed or head.strip(), rooms()
    names = sorted(files)
    Random(f"{seed} rooms").shuffle(names)
    # One room after the other, so that a run that is broken off has drawn evenly.
    tokens = list(itertools.islice(itertools.cycle(names), options.count))
    tokens = [room for room in tokens if not options.only or room in options.only]
    draws = {room: drawn(room, files[room], seed) for room in set(tokens)}
    if options.rerun:
        room_of = {name: room for room, listed in files.items() for name in listed}
        faults = list({fault.key: fault for fault in listed_faults(options.rerun, room_of)}.values())
        tokens = [fault.room for fault in faults]
        draws = {room: iter([fault for fault in faults if fault.room == room]) for room in set(tokens)}
    if options.list:
        for fault in (next(draws[room]) for room in tokens):
            print(fault)
        return
    measure(Path(options.folder))
    trials = run(options, draws, tokens)
    print(f"seed {seed}, commit {head.strip()}, {len(trials)} faults of {len(tokens)}")
    print(report(trials.values()))


if __name__ == "__main__":
    main()
