# Two commands do all the set-up: `make demo` and `make test`.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
# Of pytest: one more than there are cores, for some tests only wait, and no more than the tests of
# real servers bear. A file's tests stay together, because they share what is expensive to make.
WORKERS ?= $(shell $(PYTHON) -c 'import os; print(os.cpu_count() + 1)')
PYTEST := $(BIN)/pytest --numprocesses=$(WORKERS) --maxprocesses=4 --dist=loadfile \
	--no-loadscope-reorder
# The kernels are compiled beside the first tests, which need none, not by each of the others.
tests_marked = $(BIN)/python tests/compile_kernels.py & $(PYTEST) -m "$(1)"; status=$$?; wait; exit $$status
.DEFAULT_GOAL := help

.PHONY: help env env-test demo test test-all lint types bench soak openapi format clean

help:  ## Show the targets
	@grep -hE '^[a-z-]+:.*##' $(MAKEFILE_LIST) | sed -E 's/:.*## /\t/' | sort

$(BIN)/python:
	$(PYTHON) -m venv $(VENV)

$(VENV)/.installed: pyproject.toml | $(BIN)/python
	$(BIN)/pip install --quiet --disable-pip-version-check --editable .
	@touch $@

$(VENV)/.installed-test: pyproject.toml | $(BIN)/python
	$(BIN)/pip install --quiet --disable-pip-version-check --editable '.[test]'
	@touch $@ $(VENV)/.installed

# mypy needs to see the rooms under their import names.
.ns/snapfit: Makefile
	@mkdir -p $@
	@for room in models tracking server clients; do ln -sfn ../../$$room $@/$$room; done
	@touch $@

env: $(VENV)/.installed  ## Virtual environment with snapfit in it
env-test: $(VENV)/.installed-test .ns/snapfit  ## The same with the test tools

demo: env  ## Track the simulated bench and serve its poses on http://127.0.0.1:8000
	$(BIN)/snapfit demo

test: env-test lint types  ## Everything that CI runs
	$(call tests_marked,not slow)

test-all: env-test lint types  ## The slow tests too
	$(call tests_marked,slow or not slow)

lint: env-test
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	PYTHONPATH=.ns $(BIN)/lint-imports

types: env-test
	$(BIN)/mypy .ns/snapfit

bench: env-test  ## Speed of the tracker, the viewpoint models and the server
	$(BIN)/python tests/bench/run.py

soak: env-test  ## Whether the server grows: twelve minutes at 60 frames a second
	$(BIN)/python tests/bench/run.py soak

openapi: env  ## Write openapi/openapi.json anew
	$(BIN)/snapfit openapi --out openapi/openapi.json

format: env-test  ## Let ruff put the code in order
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

clean:
	rm -rf $(VENV) .ns build *.egg-info
