"""Measured records: reading them, and refusing what no model should be fitted to."""

from hysgen.record.data import Record, Segment

__all__ = ["Record", "Segment"]
