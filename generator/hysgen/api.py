"""The Python interface for scripts and notebooks; `import hysgen` gives all of its names.

record = hysgen.load_record("record.csv")
study = hysgen.diagnose(record)             # errors of the simulation, their causes, an extended model
model = study.model                         # or hysgen.fit(record, memory=True)
code = hysgen.generate(model)               # the C, as text
hysgen.verify(code)                         # the C compared with its reference, bit for bit
"""

from __future__ import annotations

import dataclasses
import json
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from hysgen.certify.certificates import Certificates, certify
from hysgen.certify.dynamics import Dynamics, dynamics
from hysgen.checking.bits import VerifySettings, verify_texts
from hysgen.checking.bits.report import Report
from hysgen.checking.cost import Cost, cost_of_texts
from hysgen.checking.proof.checks import CHECKS, CheckSettings, Proof, known_checks
from hysgen.cli import schemas
from hysgen.codegen import Options, write
from hysgen.codegen import generate as generate_texts
from hysgen.codegen.manifest import read_folder
from hysgen.diagnosis import DiagnoseSettings
from hysgen.diagnosis.evaluation import Study, diagnose_and_evaluate
from hysgen.display import Displayed, Summary
from hysgen.errors import FitError, RecordWarning
from hysgen.firmware.binding import firmware_model, with_learner
from hysgen.firmware.image import NO_KEY, Label, encode
from hysgen.firmware.link import BAUD, Client, open_line
from hysgen.fitting import FitSettings, PathSize
from hysgen.fitting import fit as fit_model
from hysgen.fitting.refit import Comparison
from hysgen.fitting.refit import compare as compare_models
from hysgen.fitting.refit import refit as refit_model
from hysgen.model.file import model_of
from hysgen.model.model import Model
from hysgen.model.rivals import fit_rivals, score_rivals
from hysgen.model.scores import Score, Scores
from hysgen.model.scores import score as score_model
from hysgen.record import Record, check_for_fit, check_validation
from hysgen.record.columns import nearest
from hysgen.record.inspection import Inspection
from hysgen.record.inspection import inspect as inspect_record
from hysgen.record.read import record_of
from hysgen.report.words import price_of
from hysgen.uncertainty.history import LIMIT_PERCENT, History
from hysgen.uncertainty.history import history as history_of

if TYPE_CHECKING:
    from hysgen.report.page import Page

Progress = Callable[[float, str], None]
Settings = TypeVar("Settings", FitSettings, DiagnoseSettings)


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class Generated(Displayed):
    """Generated files: the model, and texts by file name; `code["stage.h"]` is one text."""

    model: Model
    texts: Mapping[str, str]

    def __getitem__(self, name: str) -> str:
        return self.texts[name]

    def write(self, folder: str | Path) -> Path:
        """Write every file into a folder, each whole or not at all. Returns the folder."""
        write(self.texts, Path(folder))
        return Path(folder)

    def summary(self) -> Summary:
        """The files and their sizes."""
        rows = [[name, f"{len(text.splitlines())}", f"{len(text.encode())}"] for name, text in self.texts.items()]
        return Summary(f"C of model {self.model.name}: {len(self.texts)} files", ["file", "lines", "bytes"], rows)


def fit(
    record: Record | Any,
    settings: FitSettings | None = None,
    *,
    memory: bool | int | PathSize = False,
    progress: Progress | None = None,
    **changes: Any,
) -> Model:
    """A model of a record: by default the paper's structure with refined free run, otherwise as in `settings`.

    record: a Record, a DataFrame, or the name of a file. memory: whether the path holds a hysteresis: True, the number
    of its plays, or a PathSize. changes: fields of FitSettings, as rules=8. Raises FitError or RecordError.
    """
    record = record_of(record)
    chosen = _with(settings or FitSettings(), changes)
    if memory is not False:
        size = PathSize(plays=memory) if isinstance(memory, int) and memory is not True else memory
        chosen = dataclasses.replace(chosen, memory=PathSize() if size is True else size)
    parameters = 3 * chosen.rules
    if chosen.memory is not None:
        parameters += chosen.memory.operator(*record.u_range_V).size
    _warn(check_for_fit(record, chosen.rules, parameters))
    return fit_model(record, chosen, progress=progress)


def score(model: Model | str | Path, record: Record | Any, settle: int | None = None) -> Scores:
    """Errors of a model on a record: one step, against the horizon, in free run; persistence; noise floor.

    settle: samples at the start that are not scored; by default those that depend on an unknown past. Raises ModelError
    or RecordError.
    """
    return score_model(model_of(model), record_of(record), settle)


def inspect(record: Record | Any) -> Inspection:
    """Ranges, noise and excitation of a record, and what each cause needs to show. Raises RecordError."""
    return inspect_record(record_of(record))


def refit(model: Model, record: Record | Any, progress: Progress | None = None) -> tuple[Model, Scores]:
    """The same structure fitted to another record, and its scores there. Raises ModelError, RecordError or FitError."""
    return refit_model(model_of(model), record_of(record), progress)


def diff(old: Model, new: Model, records: Sequence[Record | Any] = ()) -> Comparison:
    """What changed from one model to another of the same structure; free-run errors of both on `records`."""
    return compare_models(model_of(old), model_of(new), [record_of(one) for one in records])


def history(folder: str | Path, limit_percent: float = LIMIT_PERCENT) -> History:
    """What moved over all refits of a stage: its model files in one folder, ordered by name. Raises HysgenError."""
    return history_of(Path(folder), limit_percent)


def rivals(known: Record, unseen: Record) -> dict[str, Score]:
    """Free-run scores on `unseen` of the paper's rivals (Prandtl-Ishlinskii, proportional, ARX), fitted to `known`."""
    return dict(score_rivals(fit_rivals(record_of(known)), record_of(unseen)))


def certificates(model: Model) -> Certificates:
    """Contraction of the free run, gain and inverse over the whole range of a model."""
    return certify(model_of(model))


def describe(model: Model) -> Dynamics:
    """A model as a dynamic system: time constant, gain, loop against frequency."""
    return dynamics(model_of(model))


def page(result: Study | tuple[Model, Scores, Record] | tuple[Mapping[str, Model], Record], title: str = "") -> Page:
    """The report of a diagnosis, of a model with its scores on a record, or of several models on one record.

    `page(study).save("report.html")`; `page(({"paper": a, "memory": b}, record))` has all models in each table.
    """
    if isinstance(result, Study):
        from hysgen.report.diagnosis import diagnosis_page

        return diagnosis_page(result)
    if len(result) == 2:
        models, record = result
        scored = {name: score(model, record) for name, model in models.items()}
    else:
        model, scores, record = result
        models, scored = {model.name: model}, {model.name: scores}
    from hysgen.report.model import ScoredModels, model_page

    return model_page(title or f"{', '.join(models)} on {record.source}", ScoredModels(record, models, scored))


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


def image(model: Model, label: Label | None = None, key: bytes = NO_KEY) -> bytes:
    """The model's numbers as a parameter image, which running firmware takes if it is whole, right and certified.

    label: device, build and counter of the image; key: the firmware's 16 bytes (`hysgen.firmware.image`).
    """
    return encode(model_of(model), label or Label(), key)


def connect(port: str, baud: int = BAUD) -> Client:
    """Running firmware over its serial line: `with hysgen.connect("/dev/ttyUSB0") as stage: stage.status()`.

    Needs pyserial. Raises HysgenError if the port cannot be opened.
    """
    return Client(open_line(port, baud))


def schema(name: str) -> dict[str, Any]:
    """The JSON Schema of the result of a verb ("score", "score-1"), of "model" or "manifest". Raises HysgenError."""
    content: dict[str, Any] = json.loads(schemas.text_of(name))
    return content


def _with(settings: Settings, changes: Mapping[str, Any]) -> Settings:
    """The settings with these fields. Raises FitError for a field that they do not have."""
    known = [field.name for field in dataclasses.fields(settings)]
    for name in changes:
        if name not in known:
            raise FitError(f"{name}: is not known{nearest(name, known)}; choose from {', '.join(known)}")
    return dataclasses.replace(settings, **changes)


def _warn(lines: Iterable[str]) -> None:
    for line in lines:
        warnings.warn(line, RecordWarning, stacklevel=3)


def diagnose(
    record: Record | Any,
    holdout: Record | Any | None = None,
    settings: DiagnoseSettings | None = None,
    progress: Progress | None = None,
    **changes: Any,
) -> Study:
    """Errors of the simulation of a record, their causes, and the gain and price of an extended model.

    Structure and parameters come from `record` (from its first 65 % if `holdout` is None); scores are held out.
    changes: fields of DiagnoseSettings, as keep_all=True. Raises RecordError or FitError.
    """
    record, holdout = record_of(record), None if holdout is None else record_of(holdout)
    chosen = _with(settings or DiagnoseSettings(), changes)
    if chosen.price is None:
        chosen = dataclasses.replace(chosen, price=price_of)
    _warn(check_for_fit(record, chosen.fit.rules, 3 * chosen.fit.rules))
    if holdout is not None:
        _warn(check_validation(record, holdout))
    return diagnose_and_evaluate(record, holdout, chosen, progress)


def generate(model: Model, options: Options | None = None) -> Generated:
    """The C of a model as text; by default with the inverse if that is certified.

    Raises CertificateError if the inverse in `options` is not certified, BudgetError if a sample exceeds its period.
    """
    model = model_of(model)
    chosen = options or Options(inverse=certify(model).inverse_holds)
    return Generated(model, generate_texts(model, chosen))


def verify(code: Generated | str | Path, samples: int = 200_000, progress: Progress | None = None) -> Report:
    """Compare generated C, or a folder of it, with its float32 reference, bit for bit, in every available build.

    samples: per build. Raises HysgenError if the folder is incomplete or there is no compiler.
    """
    settings = VerifySettings(samples=samples, other_models=0)
    if isinstance(code, Generated):
        return verify_texts(code.model, code.texts, settings, progress)
    folder = read_folder(Path(code))
    return verify_texts(folder.model, folder.texts, settings, progress, folder.altered)


def prove(
    code: Generated | str | Path,
    checks: Sequence[str] = ("warnings", "misra", "sanitize"),
    settings: CheckSettings | None = None,
    progress: Progress | None = None,
) -> Proof:
    """Checks of generated C, or of a folder of it, without the target; "eva" takes minutes and needs Frama-C.

    Raises HysgenError for an unknown check, and if a tool of a check is not installed.
    """
    model, texts = (code.model, code.texts) if isinstance(code, Generated) else _of_folder(code)
    chosen, report = settings or CheckSettings(), progress or (lambda fraction, line: None)
    return Proof(model.name, {name: CHECKS[name](model, texts, chosen, report) for name in known_checks(checks)})


def _of_folder(folder: str | Path) -> tuple[Model, Mapping[str, str]]:
    found = read_folder(Path(folder))
    return found.model, found.texts


def cost(code: Generated | str | Path) -> Cost:
    """The cost of generated C, or of a folder of it: operations, cycles against the sample period, bytes."""
    model, texts = (code.model, code.texts) if isinstance(code, Generated) else _of_folder(code)
    return cost_of_texts(model, texts, timed=False)
