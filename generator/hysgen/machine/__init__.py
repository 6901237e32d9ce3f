"""The host computer: native builds, compiled kernels, atomic file writes, caches, threads, installed data files."""
