"""What a verb hands on to the computation, and what it makes of the answer: text, JSON, files, exit code."""

import dataclasses
import json
import os
import re
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from hysgen.api.code import Generated
from hysgen.cli import main
from hysgen.cli.console import Console
from hysgen.cli.main import parser
from hysgen.cli.verbs import firmware, generate, refit, verify
from hysgen.errors import BuildError, HysgenError
from hysgen.export import Compared
from hysgen.firmware import Label, build_id, encode, structure_digest
from hysgen.model.file import load_model
from hysgen.targets import TargetCost, emulated


class Recorded:
    """Stands for a computation: keeps its arguments and says that it holds."""

    def __init__(self, equal: bool = True) -> None:
        self.calls: list[tuple[tuple[Any, ...], dict[str, Any]]] = []
        self.equal = equal
        self.samples = 3

    def __call__(self, *positional: Any, **named: Any) -> Any:
        self.calls.append((positional, named))
        return self

    def lines(self) -> list[str]:
        return ["first", "last"]

    header = rows = notes = lambda self: ["cell"]

    def to_json(self) -> dict[str, Any]:
        return {"equal": self.equal}


@pytest.mark.parametrize("equal", [True, False])
def test_verify_hands_on_samples_and_seed_and_its_code_is_the_answer(
    equal: bool, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    here, there, elsewhere = Recorded(equal), Recorded(equal), Recorded(equal)
    monkeypatch.setattr(verify, "verify", here)
    monkeypatch.setattr("hysgen_c674x.equality.verify_on_target", there)
    monkeypatch.setattr(emulated, "equality", elsewhere)
    written: list[tuple[Any, ...]] = []
    monkeypatch.setattr(Console, "write_json", lambda *given: written.append(given[1:]))
    monkeypatch.setattr(verify, "read_folder", lambda _: SimpleNamespace(model="model", texts="texts", facts={}))
    code = 0 if equal else 1
    assert main(["verify", "d"]) == code
    assert main(["verify", "d", "--samples", "5", "--seed", "9"]) == code
    assert capsys.readouterr().out == "first\nlast\n" * 2
    assert [(*call[0][:2], call[0][3]) for call in here.calls] == [
        (Path("d"), verify.DEFAULT_SAMPLES, 1),
        (Path("d"), 5, 9),
    ]
    assert main(["verify", "d", "--target", "c674x"]) == code
    assert main(["verify", "d", "--target", "c674x", "--samples", "6", "--seed", "8", "--updates", "4"]) == code
    assert capsys.readouterr().out == "first\nlast\n" * 2
    assert [(*call[0][:4], call[0][5]) for call in there.calls] == [
        ("model", "texts", 4000, 1, None),
        ("model", "texts", 6, 8, 4),
    ]
    assert main(["verify", "d", "--target", "emulated"]) == code
    first = verify.PLATFORMS[0].name
    assert main(f"verify d --target emulated --samples 6 --seed 8 --machine {first}".split()) == code
    assert [call[0][2] for call in elsewhere.calls] == [
        emulated.EmulationSettings(samples=20_000, platforms=list(verify.PLATFORMS), seed=1),  # type: ignore[arg-type]
        emulated.EmulationSettings(samples=6, platforms=[verify.PLATFORMS[0]], seed=8),  # type: ignore[arg-type]
    ]
    assert written == [({"equal": equal},)] * 6


def test_an_image_carries_the_label_key_and_build_that_are_asked_for(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    plain = load_model("appendix_a")
    Path("key").write_text("00112233445566778899aabbccddeeff\n")
    key = bytes.fromhex("00112233445566778899aabbccddeeff")
    fits = "".join(f"{word:08x}" for word in structure_digest(plain))
    assert main(["image", "appendix_a", "-o", "a", "--key", "key", "--json", "a.json"]) == 0
    expected = encode(plain, key, Label(0, 0, 1))
    assert Path("a").read_bytes() == expected
    assert f"written: a ({len(expected)} bytes; fits firmware with structure {fits})\n" == capsys.readouterr().out
    told = json.loads(Path("a.json").read_text())
    assert (told["model"], told["file"], told["bytes"], told["structure"]) == ("appendix_a", "a", len(expected), fits)
    whole = "image appendix_a -o b --device ffffffffffffffff --counter 4294967295 --flashed appendix_a --key key"
    assert main(whole.split()) == 0
    label = Label(0xFFFF_FFFF_FFFF_FFFF, build_id(plain), 0xFFFF_FFFF)
    assert Path("b").read_bytes() == encode(plain, key, label)
    for wrong in ("--device 10000000000000000", "--device -1", "--device x", "--counter 0", "--counter 4294967296"):
        assert main([*["image", "appendix_a", "-o", "c", "--key", "key"], *wrong.split()]) == 2
        assert "--device is a hexadecimal number of up to 16 digits" in capsys.readouterr().err
    assert main(["image", "appendix_a", "-o", "c", "--key", "key", "--flashed", "appendix_b"]) == 2
    assert "are not those of appendix_b" in capsys.readouterr().err
    assert not Path("c").exists()


def test_firmware_without_the_targets_compiler_writes_its_files_and_says_what_is_missing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def missing(*_: object) -> None:
        raise BuildError("no compiler")

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("hysgen_c674x.firmware.timing.link_image", missing)
    monkeypatch.setattr(firmware, "firmware_model", lambda model, **given: {"model.h": f"hysgen {given}"})
    assert main(["firmware", "appendix_a", "-o", "d", "--json", "r.json"]) == 0
    captured = capsys.readouterr()
    assert captured.out == (
        "appendix_a: no learner settings in the file; one of the rules' consequents is added\nwritten: 1 files in d\n"
    )
    assert captured.err == "warning: sizes and cycles are missing: no compiler\n"
    assert Path("d/model.h").read_text() == "hysgen {'aligned': False, 'forced': False}"
    told = json.loads(Path("r.json").read_text())
    assert (told["model"], told["target"]) == ("appendix_a", None)


def test_export_says_its_files_and_a_check_that_differs_is_code_1(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    given: list[Any] = []

    def write(model: Any, target: str, folder: Path, *rest: Any) -> list[Path]:
        given.append((model.name, target, *rest))
        names = ("README.md", "model/MANIFEST.json", "model/a.c")
        for name in names:
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            (folder / name).write_text("12345")
        return [folder / name for name in names]

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(generate, "write_export", write)
    for differ, code in ((0, 0), (1, 1)):
        line = Compared("ctypes", "predict", 1, differ)
        monkeypatch.setattr(generate, "compare", lambda *words, line=line, **_: given.append(words[1:4]) or [line])
        assert main(["export", "appendix_a", "--to", "shared", "-o", "d", "--check", "1", "--json", "r.json"]) == code
        assert capsys.readouterr().out == (
            f"written: d/README.md (5 bytes)\nwritten: d/model (2 files of the generated C)\n{line}\n"
        )
        assert given.pop() == ("shared", Path("d"), 1)
        told = json.loads(Path("r.json").read_text())
        assert (told["target"], len(told["files"]), told["checked"][0]["differ"]) == ("shared", 3, differ)
    assert (
        main(["export", "appendix_a", "--to", "a2l", "-o", "d", "--elf", "e", "--instance", "i", "--learner", "l"]) == 0
    )
    target, options, source = given[-1][1:]
    assert (target, source) == ("a2l", {"elf": "e", "instance": "i", "learner": "l"})
    words = parser(["generate"]).parse_args(["generate", "m", "-o", "d"])
    assert options == generate.code_options(words, load_model("appendix_a"))
    for wrong in ("a2l --check 1", "shared --check 0", "shared --elf e", "cmake --instance i", "fmu --learner l"):
        assert main([*["export", "appendix_a", "-o", "x", "--to"], *wrong.split()]) == 2
    assert not Path("x").exists()


def test_a_folder_for_matplotlib_that_the_user_names_stays(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("HOME", "/proc/nowhere")
    monkeypatch.setenv("HYSGEN_CACHE", str(tmp_path))
    monkeypatch.setenv("MPLCONFIGDIR", "mine")
    assert main(["describe", "appendix_a"]) == 0
    assert os.environ["MPLCONFIGDIR"] == "mine"


def test_a_fault_of_hysgen_is_one_line_with_an_exit_code_of_its_own(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(arguments: object) -> None:
        raise ZeroDivisionError("float\ndivision by zero")

    monkeypatch.setattr("hysgen.cli.verbs.inspect.names", broken)
    monkeypatch.setattr("hysgen.cli.verbs.inspect.text_of", broken)
    assert main(["schema", "score"]) == 3
    (line,) = capsys.readouterr().err.splitlines()
    assert re.match(
        r"hysgen schema: a fault of hysgen itself \(ZeroDivisionError in test_handed_on\.py:\d+: float div", line
    )
    with pytest.raises(ZeroDivisionError):
        main(["schema", "score", "--verbose"])


def test_verify_proves_if_it_is_asked_and_both_answers_decide(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    proofs, written = Recorded(), list[dict[str, Any]]()
    monkeypatch.setattr(Console, "write_json", lambda _, told: written.append(told))
    monkeypatch.setattr(verify, "prove", lambda *given, progress: proofs(*given))
    for equal, clean in ((True, True), (True, False), (False, True)):
        monkeypatch.setattr(verify, "verify", Recorded(equal))
        proofs.checks = {"equal": SimpleNamespace(answer=Recorded(clean)), "finite": SimpleNamespace(answer=Recorded())}  # type: ignore[attr-defined]
        proofs.clean = clean  # type: ignore[attr-defined]
        assert main(["verify", "d", "--prove"]) == (0 if equal and clean else 1)
        assert capsys.readouterr().out == "first\nlast\n" * 3
        told = written.pop()
        assert (told["equal"], told["proof"], told["finite"]) == (equal, {"equal": clean}, {"equal": True})
    assert proofs.calls == [((Path("d"), ["equal"]), {})] * 3


def test_prove_warns_of_altered_files_and_says_each_check(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = SimpleNamespace(model=load_model("appendix_a"), texts={}, altered=("a.c was changed",))
    monkeypatch.setattr(verify, "read_folder", lambda _: folder)
    given: list[Any] = []
    written: list[dict[str, Any]] = []

    def proved(code: Any, names: list[str], settings: Any, progress: Any) -> Any:
        given.append((names, settings))
        holds = names != ["sanitize"]
        return SimpleNamespace(checks={names[0]: SimpleNamespace(answer=Recorded(holds), holds=holds)})

    monkeypatch.setattr(verify, "prove", proved)
    monkeypatch.setattr(Console, "write_json", lambda _, told: written.append(told))
    for only, code in (("warnings", 0), ("warnings,sanitize", 1)):
        assert main(["prove", "d", "--only", only, "--samples", "7", "--calls", "learn,,init", "--force"]) == code
        captured = capsys.readouterr()
        assert captured.err == "warning: a.c was changed\n"
        assert captured.out == "".join(f"{name}:\nfirst\nlast\n\n" for name in only.split(","))
    assert [told["clean"] for told in written] == [True, False]
    assert [told["altered"] for told in written] == [["a.c was changed"]] * 2
    settings = verify.CheckSettings(7, ("learn", "init"))
    assert given == [(["warnings"], settings), (["warnings"], settings), (["sanitize"], settings)]


def test_kernels_are_asked_for_and_what_stays_in_c_is_a_warning(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    given: list[Any] = []

    def scheduled(code: Any, target: Any, *assembler: Any) -> Any:
        given.append((target.name, *assembler))
        return Generated(code.model, {**code.texts, "k.asm": "kernels"}, ("learn stays in C: too long",))

    def missing(*_: object) -> None:
        raise BuildError("no compiler")

    monkeypatch.setattr("hysgen_c674x.firmware.timing.link_image", missing)
    monkeypatch.setattr(firmware, "firmware_model", lambda model, **asked: {"model.h": f"{asked}"})
    for verb in (generate, firmware):
        monkeypatch.setattr(verb, "with_kernels", scheduled)
    assert main(["generate", "appendix_a", "-o", "c", "--kernels", "c674x", "--assembler", "gnu"]) == 0
    assert "warning: learn stays in C: too long\n" in capsys.readouterr().err
    assert main(["firmware", "appendix_a", "-o", "f", "--kernels", "c674x"]) == 0
    assert "warning: learn stays in C: too long\n" in capsys.readouterr().err
    assert given == [("c674x", "gnu"), ("c674x",)]
    assert {Path(name, "k.asm").read_text() for name in "cf"} == {"kernels"}
    assert Path("f/model.h").read_text() == "{'aligned': True, 'forced': False}"
    monkeypatch.setattr(firmware, "named", lambda ability: [])
    assert main(["firmware", "appendix_a", "-o", "f", "--force"]) == 0
    assert "no package of a target that the firmware runs on is installed" in capsys.readouterr().err


def test_cost_shows_what_a_target_measured_below_the_estimate(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    figures = {
        "predict": {"cycles": 91, "code_bytes": 700},
        "all": {"code_bytes": 900, "stack_bytes": 64},
        "data": {"struct_bytes": 50, "constant_bytes": 60},
    }
    measured = TargetCost(figures, ("measured by hand",), {"compiler": "gcc"})
    monkeypatch.chdir(tmp_path)
    assert main(["generate", "appendix_a", "-o", "c", "-q"]) == 0
    own = dataclasses.replace(generate.targets()["c674x"], cost=lambda model, texts: measured)
    monkeypatch.setattr(generate, "target", lambda name, ability: own)
    written: list[dict[str, Any]] = []
    monkeypatch.setattr(Console, "write_json", lambda _, told: written.append(told))
    capsys.readouterr()
    assert main(["cost", "c", "--target", "c674x"]) == 0
    assert [line.split() for line in capsys.readouterr().out.splitlines()[-4:]] == [
        ["predict", "91", "700", "-"],
        ["all", "-", "900", "64"],
        ["data:", "50", "bytes", "of", "structs,", "60", "of", "constants"],
        ["measured", "by", "hand"],
    ]
    (told,) = written
    assert (told["target"], told["compiler"]) == (figures, "gcc")
    assert told["functions"]["predict"]["cycles"] == {"value": 91, "measured": True}


def test_a_record_that_cannot_be_explained_is_said_and_a_warning_of_the_c_is_shown(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    def refused(*_: object, **__: object) -> None:
        raise HysgenError("too short")

    console = Console(quiet=False)
    monkeypatch.setattr(refit, "diagnose", refused)
    assert refit.explain(load_model("appendix_a"), SimpleNamespace(), console) == {"error": "too short"}  # type: ignore[arg-type]
    assert capsys.readouterr().out == "diagnosis: too short\n"
    code = Generated(load_model("appendix_a"), {"a.c": "int a;"}, ("over its budget",))
    monkeypatch.setattr(refit, "generate_again", lambda *_: code)
    monkeypatch.setattr(refit, "verify", lambda *_: Recorded(False))
    (tmp_path / "a.c").write_text("int b;")
    told = refit.regenerate(code.model, tmp_path, console, False)
    captured = capsys.readouterr()
    assert "warning: over its budget\n" in captured.err
    assert captured.out == f"changed in {tmp_path}: a.c; as before: 0 files\nlast\n"
    assert told == {"changed": ["a.c"], "equal": False, "samples": 3}
    assert (tmp_path / "a.c").read_text() == "int a;"
