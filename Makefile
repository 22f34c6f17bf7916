# Run the program with `make walk`, the tests with `make test`; see `make help`.
# The first call makes the virtual environment; later ones install nothing.

VENV ?= .venv
JOBS ?= 2
ARGS ?=

BIN := $(VENV)/bin
STAMP := $(VENV)/.installed

# Prints the version of a Python that can make the environment, or fails.
USABLE := import ensurepip, sys, venv; v = sys.version_info; v >= (3, 11) or sys.exit(1); \
    print(f"{v[0]}.{v[1]}")
# Interpreters to look for when PYTHON is not given. Drake for CPython 3.11 exists for
# Linux on x86_64 only.
NAMES := $(if $(filter Linux-x86_64,$(shell uname -s)-$(shell uname -m)),python3.11) \
    python3.12 python3.13 python3.14 python3
FIND_PYTHON = $(shell for name in $(NAMES); do \
    if $$name -c '$(USABLE)' >/dev/null 2>&1; then echo $$name; break; fi; done)
ifneq ($(PYTHON),)
WANTED := $(shell '$(PYTHON)' -c '$(USABLE)')
ifeq ($(WANTED),)
$(error PYTHON=$(PYTHON) is not a Python 3.11 or newer that has venv)
endif
endif

# What the environment was made for is kept in the stamp. When its interpreter is gone or
# says something else now (another Python, another machine, a moved folder), or is not the
# one asked for with PYTHON, the environment is made anew.
IDENTITY := import platform, sys; v = sys.version_info; \
    print(f"{v[0]}.{v[1]}", platform.system(), platform.machine(), sys.prefix)
FRESH := $(shell is=$$('$(BIN)/python' -c '$(IDENTITY)' 2>/dev/null) \
    && [ "$$is" = "$$(cat '$(STAMP)' 2>/dev/null)" ] \
    && [ "$${is%% *}" = "$(or $(WANTED),$${is%% *})" ] && echo fresh)

.PHONY: help walk test test-fast lint types format docs picture notebook wheel lock clean stale \
    paper robustness contact-study envelope publish running ground estimation smoother tuning bench qpbenchmark zoo \
    surface-push transfer fault-injection models
.DEFAULT_GOAL := help

help:  ## Say what there is
	@sed -n 's/^\([a-z-]*\):.*## /  make \1|/p' Makefile | column -t -s '|'
	@echo 'Variables: ARGS (for walk, tests and studies), PYTHON, VENV=$(VENV), JOBS=$(JOBS).'

walk: $(STAMP)  ## Walk; for instance make walk ARGS="--duration 2"
	$(BIN)/linefoot walk $(ARGS)

# Each process begins with a half of the tests, in their order, so that what a file or a helper
# simulates once is simulated by one of them, and takes from the other at the end.
PYTEST := $(BIN)/python -m pytest -n $(JOBS) --dist worksteal

test: $(STAMP)  ## Run every test
	$(PYTEST) $(ARGS)

test-fast: $(STAMP)  ## Run the tests that are not marked slow
	$(PYTEST) -m 'not slow' $(ARGS)

lint: $(STAMP)  ## Check style and formatting
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

types: $(STAMP)  ## Check types
	$(BIN)/mypy

format: $(STAMP)  ## Format, and mend what can be mended automatically
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

# A study writes what is published into its folder of docs/, a quick look into out/; ARGS has its
# options.
paper: $(VENV)/.zoo  ## Reproduce the paper's figures
	$(BIN)/python -m studies.paper $(ARGS)

robustness: $(STAMP)  ## Carry out the sweeps of robustness
	$(BIN)/python -m studies.robustness $(ARGS)

contact-study: $(STAMP)  ## Study the contact estimator
	$(BIN)/python -m studies.contact $(ARGS)

models: $(STAMP)  ## Compare models and horizons of the MPC under pushes; writes docs/models/
	$(BIN)/python -m studies.models $(ARGS)

estimation: $(STAMP)  ## Study the state estimator; writes docs/estimation/
	$(BIN)/python -m studies.estimation $(ARGS)

smoother: $(VENV)/.smoother  ## Compare the state estimator with GTSAM; writes docs/estimation/
	$(BIN)/python -m studies.estimation.smoother $(ARGS)

envelope: $(STAMP)  ## Find the fastest commands that are walked
	$(BIN)/python -m studies.envelope $(ARGS)

running: $(STAMP)  ## Run: how fast, how well, and what it survives; writes docs/running/
	$(BIN)/python -m studies.running $(ARGS)

ground: $(STAMP)  ## Walk stairs, gaps, stones and blocks with a map; writes docs/ground/
	$(BIN)/python -m studies.ground $(ARGS)

publish: $(STAMP)  ## Make again what docs/ publishes of other code; ARGS=--check only looks
	$(BIN)/python -m studies.publish $(ARGS)

tuning: $(STAMP)  ## Search weights of the MPC; for instance make tuning ARGS="--model ecd"
	$(BIN)/python -m studies.tuning $(ARGS)

bench: $(VENV)/.bench  ## Measure speed and memory, beside other packages
	$(BIN)/python -m studies.bench $(ARGS)

qpbenchmark: $(VENV)/.qpbenchmark  ## Write the MPC's programs for qpbenchmark, and solve them
	$(BIN)/python -m studies.qpbenchmark $(ARGS)

zoo: $(VENV)/.zoo  ## Walk robots of others, and made-up ones
	$(BIN)/python -m studies.zoo $(ARGS)

surface-push: $(VENV)/.zoo  ## Push a G1 that walks on its soles; writes docs/zoo/
	$(BIN)/python -m studies.zoo.surface_push $(ARGS)

transfer: $(STAMP)  ## Walk in MuJoCo and in Drake; writes docs/transfer/
	$(BIN)/python -m studies.transfer $(ARGS)

fault-injection: $(STAMP)  ## Try to break it, for half an hour at most; writes docs/reliability.md
	$(BIN)/python -m studies.fault_injection $(ARGS)

# The site's tools are installed when it is built for the first time. Not --quiet: warnings that
# are not shown do not count, and --strict would let them pass.
docs: $(VENV)/.docs  ## Build the documentation into site/, strictly
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --strict
	@echo 'Open site/index.html'

picture: $(STAMP)  ## Make the pictures of the docs anew, in a headless Chromium; look at them
	$(BIN)/python tools/make_picture.py $(ARGS)

notebook: $(STAMP)  ## Run examples/tour.ipynb and keep its outputs in it
	$(BIN)/python tools/run_notebook.py

wheel: $(STAMP)  ## Build dist/, with a wheel that brings machine code, and check that
	rm -rf dist
	$(BIN)/python -m build --no-isolation
	$(BIN)/python tools/make_wheel.py dist/*-py3-none-any.whl
	$(BIN)/python -m twine check --strict dist/*

lock: $(STAMP)  ## Make requirements/ anew; for instance make lock ARGS="--upgrade-package numpy"
	$(BIN)/python tools/lock.py $(ARGS)

clean:  ## Remove the environment and what tools have left
	if [ -f '$(VENV)/pyvenv.cfg' ]; then rm -rf '$(VENV)'; fi
	rm -rf build dist site *.egg-info .pytest_cache .mypy_cache .ruff_cache .hypothesis
	find . -name __pycache__ -type d -not -path './.venv*' -prune -exec rm -rf {} +

# Installed with a path, not with an import hook (compat): editors and mypy follow it from any folder.
# Of every file that pip installs, requirements/ has the hash; the project itself is built by what
# was installed so.
# What pip says goes on: Drake alone is 100 MB.
INSTALL = @$(BIN)/python -m pip install --disable-pip-version-check
LOCKED = $(INSTALL) --require-hashes

$(STAMP): pyproject.toml requirements/base.txt requirements/dev.txt $(if $(FRESH),,stale)
ifeq ($(FRESH),)
	@if [ -e '$(VENV)' ] && [ ! -f '$(VENV)/pyvenv.cfg' ]; then \
	    echo '$(VENV) is not a virtual environment; it is left alone' >&2; exit 1; fi
	@if [ -z '$(or $(PYTHON),$(FIND_PYTHON))' ]; then \
	    echo 'No Python 3.11 or newer that has venv: looked for $(strip $(NAMES)).' \
	        'Install one, or say where it is: make PYTHON=/path/to/python' >&2; exit 1; fi
	'$(or $(PYTHON),$(FIND_PYTHON))' -m venv --clear '$(VENV)'
endif
	@echo 'Installing into $(VENV); the first time takes a minute or more'
	$(LOCKED) -r requirements/base.txt -r requirements/dev.txt
	$(INSTALL) --no-deps --no-build-isolation --config-settings editable_mode=compat -e .
	@$(BIN)/python -c '$(IDENTITY)' > '$(STAMP)'

EXTRAS := $(patsubst %,$(VENV)/.%,docs bench zoo qpbenchmark smoother)
$(EXTRAS): $(VENV)/.%: $(STAMP) requirements/%.txt
	$(LOCKED) -r requirements/$*.txt
	@touch '$@'
