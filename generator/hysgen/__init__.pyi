"""The public names with their modules: type checkers read this list, and so does `__init__.py`."""

from hysgen.api.code import Generated as Generated
from hysgen.api.code import connect as connect
from hysgen.api.code import cost as cost
from hysgen.api.code import firmware_files as firmware_files
from hysgen.api.code import generate as generate
from hysgen.api.code import image as image
from hysgen.api.code import prove as prove
from hysgen.api.code import schema as schema
from hysgen.api.code import verify as verify
from hysgen.api.code import write_export as write_export
from hysgen.api.diagnosing import diagnose as diagnose
from hysgen.api.diagnosing import next_experiment as next_experiment
from hysgen.api.diagnosing import page as page
from hysgen.api.models import certificates as certificates
from hysgen.api.models import describe as describe
from hysgen.api.models import design_loop as design_loop
from hysgen.api.models import diff as diff
from hysgen.api.models import fit as fit
from hysgen.api.models import inspect as inspect
from hysgen.api.models import refit as refit
from hysgen.api.models import rivals as rivals
from hysgen.api.models import score as score
from hysgen.api.models import simulate as simulate
from hysgen.api.models import waveform as waveform
from hysgen.checking.bits import Report as Report
from hysgen.checking.cost import Cost as Cost
from hysgen.codegen import Options as Options
from hysgen.diagnosis import DiagnoseSettings as DiagnoseSettings
from hysgen.diagnosis.evaluation import Study as Study
from hysgen.errors import HysgenError as HysgenError
from hysgen.errors import RecordWarning as RecordWarning
from hysgen.estimator import HysteresisRegressor as HysteresisRegressor
from hysgen.fitting import FitSettings as FitSettings
from hysgen.model.file import load_model as load_model
from hysgen.model.file import save_model as save_model
from hysgen.model.model import Model as Model
from hysgen.model.scores import Scores as Scores
from hysgen.record import Columns as Columns
from hysgen.record import Record as Record
from hysgen.record import load_record as load_record
from hysgen.record.read import demo_record as demo_record
from hysgen.trajectory.plan import Waveform as Waveform
from hysgen.trajectory.reference import Form as Form

__version__: str
__all__: list[str]
