"""From a model to C, its checks and its cost, folders for other tools, and running firmware."""

import dataclasses
import json
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from hysgen import schemas
from hysgen.api.models import Progress
from hysgen.checking.bits import Report
from hysgen.checking.bits.comparison import VerifySettings, verify_texts
from hysgen.checking.cost import Cost, cost_of_texts
from hysgen.checking.proof import CHECKS, Checked, CheckSettings, Proof, known_checks
from hysgen.codegen import Derived, Options
from hysgen.codegen import generate as generate_texts
from hysgen.codegen.manifest import MANIFEST, read_folder, require_model, write
from hysgen.codegen.operations import C674X, Weights
from hysgen.display import Displayed, Summary
from hysgen.errors import HysgenError
from hysgen.firmware import Label, encode, firmware_model, with_learner
from hysgen.firmware.link import BAUD, Client, open_line
from hysgen.fitting.refit import restricted_as
from hysgen.model.file import model_of
from hysgen.model.model import Model
from hysgen.targets import Target, with_kernels_in


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class Generated(Displayed, Mapping[str, str]):
    """Generated files: the model, texts by file name, warnings. A mapping: `code["stage.h"]` is one text."""

    model: Model
    texts: Mapping[str, str]
    warnings: tuple[str, ...] = ()

    def __getitem__(self, name: str) -> str:
        return self.texts[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.texts)

    def __len__(self) -> int:
        return len(self.texts)

    def write(self, folder: str | Path) -> Path:
        """Write every file into a folder, each whole or not at all. Returns the folder."""
        write(self.texts, Path(folder))
        return Path(folder)

    def summary(self) -> Summary:
        """The files and their sizes."""
        rows = [[name, f"{len(text.splitlines())}", f"{len(text.encode())}"] for name, text in self.texts.items()]
        return Summary(f"C of model {self.model.name}: {len(self.texts)} files", ["file", "lines", "bytes"], rows)


def generate(model: Model, options: Options | None = None, force: bool = False) -> Generated:
    """The C of a model as text; by default with the inverse if that is certified.

    Raises CertificateError if the inverse in `options` is not certified, BudgetError if a sample exceeds its period;
    without `force`, also ModelError for a model of next to nothing, CertificateError if noise moves the inverse.
    """
    derived = Derived(model_of(model))
    chosen = options or derived.options
    chosen = dataclasses.replace(chosen, forced=chosen.forced or force)
    return Generated(derived.model, generate_texts(derived, chosen))


def _as_before(model: Model, folder: Path) -> tuple[Model, Options | None]:
    """The new model with the learner and ranges of the model in the folder, and the options of its generation.

    Without a manifest in the folder: the model itself and None. Raises HysgenError if
    the folder holds the C of a model of another name.
    """
    if not (folder / MANIFEST).exists():
        return model, None
    before = read_folder(folder)
    require_model(folder / MANIFEST, model.name)
    options = before.facts.get("options", {})
    clock_Hz = float(options.get("clock_Hz", Options().clock_Hz))
    stated = before.facts.get("cost", {}).get("cycles", {}).items()
    measured = {function: int(cycles["value"]) for function, cycles in stated if cycles["measured"]}
    model = restricted_as(before.model, dataclasses.replace(model, learner=before.model.learner))
    inverse, aligned = bool(options.get("inverse")), "kernels" in before.facts
    return model, Options(inverse, clock_Hz, measured, options.get("budget_cycles"), aligned)


def generate_again(model: Model, folder: str | Path, force: bool = False) -> Generated:
    """The C of a new model with the learner, ranges, options, kernels and assemblers of the folder of the old one.

    Raises HysgenError if the folder holds the C of a model of another name, and as `generate` does.
    """
    model, options = _as_before(model_of(model), Path(folder))
    code = generate(model, options, force)
    if options is None or not options.aligned:
        return code
    target, assembler = with_kernels_in(model.name, read_folder(Path(folder)).texts)
    return with_kernels(code, target, assembler)


def with_kernels(code: Generated, target: Target, assembler: str = "") -> Generated:
    """The C with the kernels of a target; warnings name each function that stays in C."""
    if target.kernels is None:
        raise HysgenError(f"{target.name}: has no kernels")
    texts, refused = target.kernels.schedule(code.model.name, code.texts, assembler or target.kernels.assemblers[0])
    return Generated(code.model, texts, tuple(f"{name} stays in C: {reason}" for name, reason in refused.items()))


def verify(
    code: Generated | str | Path, samples: int = 200_000, progress: Progress | None = None, seed: int = 1
) -> Report:
    """Compare generated C, or a folder of it, with its float32 reference, bit for bit, in every available build.

    samples: per build; seed: of the inputs. Raises HysgenError if the folder is incomplete or there is no compiler.
    """
    given = code if isinstance(code, Generated) else read_folder(Path(code))
    altered = () if isinstance(given, Generated) else given.altered
    return verify_texts(given.model, given.texts, VerifySettings(samples, seed), progress, altered)


def prove(
    code: Generated | str | Path,
    checks: Sequence[str] = ("warnings", "misra", "sanitize"),
    settings: CheckSettings | None = None,
    progress: Progress | None = None,
) -> Proof:
    """Checks of generated C, or of a folder of it, without the target; "eva" takes minutes and needs Frama-C.

    With "equal", the kernels of a folder are proved equal to their C, under the name "kernels".
    Raises HysgenError for an unknown check, and if a tool of a check is not installed.
    """
    given = code if isinstance(code, Generated) else read_folder(Path(code))
    chosen, report = settings or CheckSettings(), progress or (lambda fraction, line: None)
    names = known_checks(checks)
    made = {name: CHECKS[name](given.model, given.texts, chosen, report) for name in names}
    if "equal" in made and "kernels" in json.loads(given.texts.get(MANIFEST, "{}")):
        scheduled = with_kernels_in(given.model.name, given.texts)[0].kernels
        assert scheduled is not None
        answer = scheduled.prove(given.model, given.texts, chosen.calls)
        made["kernels"] = Checked(answer, answer.equal)
    return Proof(given.model.name, made)


def cost(
    code: Generated | str | Path,
    cycles: Mapping[str, int] | None = None,
    *,
    timed: bool = False,
    weights: Weights = C674X,
) -> Cost:
    """The cost of generated C, or of a folder of it: operations, cycles against the sample period, bytes.

    cycles, timed, weights: as for `cost_of_texts`. Raises HysgenError if the folder is incomplete.
    """
    given = code if isinstance(code, Generated) else read_folder(Path(code))
    return cost_of_texts(given.model, given.texts, cycles, timed=timed, weights=weights)


def write_export(model: Model, target: str, folder: str | Path, options: Options | None = None) -> list[Path]:
    """Write a folder for another tool, with its binaries. Returns the paths of its files.

    target: sfunction, fmu, a2l, cmake, shared, cortexm, or the name of an export that was added. Raises HysgenError for
    any other, BuildError without a compiler.
    """
    from hysgen import export

    return export.write_export(model_of(model), target, Path(folder), options)


def firmware_files(model: Model) -> Generated:
    """The C of a model as the firmware takes it, with model.h and, if the model has no learner, one of its rules."""
    model = model_of(model)
    chosen = model if model.learner is not None else with_learner(model)
    return Generated(chosen, firmware_model(chosen))


def image(model: Model, key: bytes, label: Label | None = None) -> bytes:
    """The model's numbers as a parameter image, which running firmware takes if it is whole, right and certified.

    key: the firmware's 16 bytes, not all zeros; label: device, build and counter (`hysgen.firmware`).
    """
    return encode(model_of(model), key, label or Label())


def connect(port: str, baud: int = BAUD) -> Client:
    """Running firmware over its serial line: `with hysgen.connect("/dev/ttyUSB0") as stage: stage.status()`.

    Needs pyserial. Raises HysgenError if the port cannot be opened.
    """
    return Client(open_line(port, baud))


def schema(name: str) -> dict[str, Any]:
    """The JSON Schema of the result of a verb ("score", "score-1"), of "model" or "manifest". Raises HysgenError."""
    content: dict[str, Any] = json.loads(schemas.text_of(name))
    return content
