"""The host computer: native builds, compiled kernels, atomic file writes, caches, processes, installed data files."""
