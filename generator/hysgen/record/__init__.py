"""Measured records: reading, checking, noise floor."""

from hysgen.record.columns import Columns
from hysgen.record.data import Record
from hysgen.record.excitation import check_validation
from hysgen.record.read import load_record, record_csv
from hysgen.record.segment import Segment

__all__ = ["Columns", "Record", "Segment", "check_validation", "load_record", "record_csv"]
