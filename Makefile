# A fresh machine needs Python and make alone: each target sets up what it uses.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
SHARED := $(abspath ../shared)

ifneq ($(wildcard $(SHARED)/README.md),)
export VPF_SIM_SHARED := $(SHARED)
endif

CORE := envs/camera/core/_core.abi3.so

.PHONY: install core test lint types unit slow benchmark docs docs-links notebooks clean

install: $(VENV)/installed $(CORE)

$(VENV)/installed: pyproject.toml
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[dev]'
	touch $@

core: $(CORE)

$(CORE): $(wildcard envs/camera/core/*.[ch] envs/camera/core/*/*.[ch] building/*.py) setup.py | $(VENV)/installed
	$(BIN)/python -m building

test: lint types unit

lint: install
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .

# mypy does not follow the mapped packages of an editable install, so it reads them through links, laid out as installed.
types: install
	rm -rf .types && mkdir -p .types/vpf_sim
	ln -s $(abspath $(wildcard vpf_sim/*) envs controllers scenarios) .types/vpf_sim/
	cd .types && $(abspath $(BIN))/mypy --config-file ../pyproject.toml --cache-dir ../.mypy_cache -p vpf_sim

# One thread each, as in the drives: numpy's own threads spin while tests run side by side.
unit slow: export OPENBLAS_NUM_THREADS := 1
# Compiled tests are kept for the next run and for the other worker, also where the surroundings forbid it.
unit slow: export PYTHONDONTWRITEBYTECODE :=

unit: install
	$(BIN)/python -m pytest -n 2 --dist worksteal

slow: install
	$(BIN)/python -m pytest -m slow

benchmark: install
	$(BIN)/vpf-sim benchmark --seeds 1000:1003

$(VENV)/docs: $(VENV)/installed
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[docs]'
	touch $@

# A warning is an error: a link within the pages that leads nowhere, a docstring that cannot be read.
docs: $(VENV)/docs
	$(BIN)/python -m sphinx --fail-on-warning --keep-going docs build/docs

docs-links: $(VENV)/docs
	$(BIN)/python -m sphinx -b linkcheck docs build/links

notebooks: $(VENV)/docs
	$(BIN)/python scripts/notebooks.py

clean:
	rm -rf $(VENV) $(CORE) .types build *.egg-info .pytest_cache .mypy_cache .ruff_cache
