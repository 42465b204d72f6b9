# Two commands on a fresh machine (Python 3.11+, a C compiler, make):  make demo   make test
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
STAMP := $(VENV)/.installed

ifneq ($(wildcard ../shared/data),)
export ROBUSTNAV_DATA ?= $(abspath ../shared/data)
endif

.PHONY: demo test setup lint generate clean

demo: setup
	$(BIN)/robustnav demo attitude --out out/attitude

test: setup
	$(BIN)/python -m pytest -n auto

setup: $(STAMP)

$(STAMP): pyproject.toml $(wildcard csrc/*) $(wildcard csrc/generated/*) $(wildcard csrc/python/*)
	test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install -q --disable-pip-version-check -e ".[dev]"
	@touch $@

lint: setup
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

generate: setup
	$(BIN)/python -m robustnav.model.generate

clean:
	rm -rf build out $(VENV)
