SHELL := bash
.SHELLFLAGS := -eu -o pipefail -c
.DEFAULT_GOAL := help
MAKEFLAGS += --no-print-directory

PYTHON ?= python3
PORT ?= 8000
SITE ?= ../shared/data/mall
WORKERS ?= 2
ARGS ?=

BIN := .venv/bin
LOCKED := $(BIN)/python -m pip install --quiet --disable-pip-version-check --require-hashes -r
# the package itself: its dependencies come from the lock, what builds it too
PACKAGE := $(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps --no-build-isolation --editable .

.PHONY: help
help: ## what can be made
	@awk -F ':.*## ' '/^[a-z-]+:.*## /{printf "  make %-12s %s\n", $$1, $$2}' $(MAKEFILE_LIST)
	@echo "  variables: PYTHON=$(PYTHON) PORT=$(PORT) WORKERS=$(WORKERS) SITE=$(SITE) ARGS='options of the command behind it'"

$(BIN)/python:
	@$(PYTHON) -c 'import sys; sys.exit("Surefix needs Python 3.11 or newer; name one: make PYTHON=python3.11 ..." if sys.version_info < (3, 11) else 0)'
	$(PYTHON) -m venv .venv

.venv/run.stamp: requirements/run.txt pyproject.toml | $(BIN)/python
	@echo "installing what Surefix runs on; this takes a minute, once"
	$(LOCKED) requirements/run.txt
	$(PACKAGE)
	@echo "compiling what every request needs; this takes one to three minutes, once"
	$(BIN)/python -c "from app.fusion.warm_up import warm_up; warm_up()"
	@touch $@

.venv/dev.stamp: requirements/dev.txt .venv/run.stamp
	@echo "installing what Surefix is tested with"
	$(LOCKED) requirements/dev.txt
	@touch $@

.PHONY: install
install: .venv/run.stamp ## .venv with the surefix command in it, from the lock

.PHONY: run
run: .venv/run.stamp ## serve a simulated building full of walking phones on loopback; Ctrl-C stops
	$(BIN)/surefix demo --port $(PORT) $(ARGS)

.PHONY: test
test: .venv/dev.stamp ## the tests
	$(BIN)/python -m pytest -n $(WORKERS) --dist loadscope $(ARGS)

.PHONY: check
check: static test ## everything a change must pass: format, lint, types, OpenAPI, tests

.PHONY: static
static: lint types openapi-check

.PHONY: lint
lint: .venv/dev.stamp ## format and lint, changing nothing
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .

.PHONY: types
types: .venv/dev.stamp ## mypy, strict
	$(BIN)/mypy

.PHONY: format
format: .venv/dev.stamp ## format, and mend what lint can mend
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .

.PHONY: openapi
openapi: .venv/run.stamp ## write openapi/openapi.json anew
	$(BIN)/python -m app.api.openapi openapi/openapi.json

.PHONY: openapi-check
openapi-check: .venv/run.stamp ## compare it with what the application says
	$(BIN)/python -m app.api.openapi --check openapi/openapi.json

.PHONY: bench
bench: .venv/dev.stamp ## speed against other people's code; fails where a ratio is missed
	$(BIN)/python -m benchmarks.speed $(ARGS)

.PHONY: evaluate
evaluate: .venv/run.stamp ## errors and integrity on recorded walks, fold 0: tables and plots in build/evaluation
	$(BIN)/surefix evaluate $(SITE) --out build/evaluation $(ARGS)

.PHONY: accuracy
accuracy: .venv/run.stamp ## the same, all folds pooled
	$(BIN)/python -m benchmarks.accuracy $(ARGS)

.PHONY: compare
compare: .venv/run.stamp ## every method and ablation on recorded walks and the papers' sites; docs/comparison.md
	$(BIN)/surefix compare $(SITE) --out build/comparison --page docs/comparison.md $(ARGS)

.PHONY: faults
faults: .venv/run.stamp ## faults in recorded walks and in simulated buildings: tables in build/faults
	$(BIN)/surefix faults $(SITE) --simulated 6 --out build/faults $(ARGS)

.PHONY: buildings
buildings: .venv/run.stamp ## levels and alarms in 20 simulated buildings that no setting was chosen on
	$(BIN)/surefix buildings --out build/buildings $(ARGS)

.PHONY: transfer
transfer: .venv/run.stamp ## leave one floor out: settings learnt on one recorded floor, judged on the other
	$(BIN)/surefix transfer $(SITE) --out build/transfer $(ARGS)

.PHONY: ageing
ageing: .venv/run.stamp ## radio maps months after their survey, simulated
	$(BIN)/surefix ageing --out build/ageing $(ARGS)

# The tool that resolves versions lives apart, so that it is in no lock itself.
build/lock/bin/uv: | $(BIN)/python
	$(BIN)/python -m venv build/lock
	build/lock/bin/python -m pip install --quiet --disable-pip-version-check uv

RESOLVE := build/lock/bin/uv pip compile pyproject.toml --universal --python-version 3.11 --generate-hashes \
	--no-annotate --no-header --no-emit-index-url --no-emit-find-links --quiet

.PHONY: lock
lock: build/lock/bin/uv ## resolve pyproject.toml anew into requirements/*.txt; LOCK=--upgrade takes newer releases
	$(RESOLVE) --extra build $(LOCK) --output-file requirements/run.txt
	$(RESOLVE) --extra build --extra dev $(LOCK) --constraints requirements/run.txt --output-file requirements/dev.txt
	@sed -i '1i # Versions with the hashes of their files; `make lock` writes this from pyproject.toml.\n' requirements/run.txt requirements/dev.txt

.PHONY: clean
clean: ## remove what was built and measured; .venv stays
	rm -rf build out .pytest_cache .mypy_cache .ruff_cache
