"""hysgen: from measured records of a piezo stage to verified float32 C."""

__version__ = "0.1.0"
