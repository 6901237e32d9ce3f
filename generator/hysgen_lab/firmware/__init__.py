"""The firmware on the virtual stage, and the models that it ships with."""
