"""The host computer: native builds, compiled kernels, atomic file writes, caches, processes, threads, installed data files."""
