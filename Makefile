# `make run` and `make test` each make the environment they need; everything lives in .venv and goes with `make clean`.

SHELL := /bin/sh
VENV := .venv
PY := $(VENV)/bin/python
# The newest Python that is at least 3.11, or whatever PYTHON=... names.
PYTHON ?= $(shell for p in python3.14 python3.13 python3.12 python3.11 python3 python; do \
	command -v $$p >/dev/null 2>&1 && $$p -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null \
	&& { echo $$p; break; }; done)
# Without a compiler of the system, pip brings clang: the extra `compiler`.
CC_FOUND := $(shell for c in "$(CC)" cc gcc clang; do command -v $$c >/dev/null 2>&1 && { echo $$c; break; }; done)
EXTRA ?= $(if $(CC_FOUND),,[compiler])
OUT ?= hysgen-demo

# Tests start many processes: each would compile the package again.
unexport PYTHONDONTWRITEBYTECODE

.PHONY: run test prove check style quick-tests all-tests help clean

run: $(VENV)/.installed  ## the main job on the bundled record: diagnosis, C, equality of bits, cost, one page
	$(PY) -m hysgen demo -o $(OUT)

check: $(VENV)/.tested  ## style, types, import layers, and the fast tests: two minutes on two cores
	@$(MAKE) --no-print-directory --jobs=2 style quick-tests

test: $(VENV)/.tested  ## style, types, import layers, and every test but those of `make prove`
	@$(MAKE) --no-print-directory --jobs=2 style all-tests

quick-tests: $(VENV)/.tested
	$(PY) -m pytest -n auto --dist worksteal -m "not slow and not proof"

all-tests: $(VENV)/.tested
	$(PY) -m pytest -n auto --dist worksteal -m "not proof"

prove: $(VENV)/.tested  ## every call of the two models that ship, proved by Frama-C, proofs of kernels, planted faults: about ten minutes
	$(PY) -m pytest -n auto --dist worksteal -m proof

style: $(VENV)/.tested
	$(PY) -m ruff check .
	$(PY) -m ruff format --check .
	$(PY) -m mypy
	$(VENV)/bin/lint-imports --no-cache
	$(PY) benchmarks/house.py --check

help:  ## what can be made
	@sed -n 's/^\([a-z]*\):.*## /\1: /p' $(MAKEFILE_LIST)

$(VENV)/.installed: pyproject.toml
	@test -n "$(PYTHON)" || { echo "hysgen needs Python 3.11 or newer: install it, or name it: make PYTHON=/path/to/python3"; exit 1; }
	@test -x $(PY) || $(PYTHON) -m venv $(VENV) || { \
		echo "$(PYTHON) cannot make virtual environments: install its venv module (on Debian: apt install python3-venv)"; \
		rm -rf $(VENV); exit 1; }
	$(PY) -m pip install --disable-pip-version-check --no-compile --editable '.$(EXTRA)'
	@touch $@

$(VENV)/.tested: $(VENV)/.installed
	$(PY) -m pip install --disable-pip-version-check --no-compile --editable '.[test]'
	@touch $@

clean:
	rm -rf $(VENV) $(OUT) .pytest_cache .mypy_cache .ruff_cache .hypothesis
