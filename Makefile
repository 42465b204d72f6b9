# Two commands on a fresh machine (Python 3.11 or later, a C compiler, make):  make demo   make test
# Another interpreter: make PYTHON=python3.12 demo
# Nothing is written outside this folder but pip's own download cache.
VENV := .venv
BIN := $(VENV)/bin
SOURCES := pyproject.toml tools/venv.sh $(wildcard csrc/*.[ch] csrc/*/*.[ch])

# Recordings that tests and studies read where they are present; without them those tests are skipped.
DATA := $(shell cd ../shared/data 2>/dev/null && pwd)
ifneq ($(DATA),)
export ROBUSTNAV_DATA ?= $(DATA)
endif
RUN := XDG_CACHE_HOME="$(CURDIR)/$(VENV)/cache" MPLCONFIGDIR="$(CURDIR)/$(VENV)/cache/matplotlib" $(BIN)/python -m

# A stamp holds the folder it was made in and the Python that was named: a checkout that was moved, or a call that names
# another Python, sets itself up again.
RUNTIME := $(VENV)/.runtime
DEV := $(VENV)/.dev
FOLDER := $(shell pwd -P)
stale = $(shell [ -x $(BIN)/python ] && grep -qsxF '$(FOLDER)' $(1) $(if $(PYTHON),&& grep -qsxF '$(PYTHON)' $(1)) || echo again)

.PHONY: demo test lint generate examples native wheel clean again
.NOTPARALLEL:

demo: $(RUNTIME)
	@$(RUN) robustnav demo attitude --out out/attitude

test: $(DEV)
	@$(RUN) pytest -n auto

lint: $(DEV)
	@$(RUN) ruff check .
	@$(RUN) ruff format --check .
	@$(RUN) mypy

# The committed C of the built-in models.
generate: $(DEV)
	@$(RUN) robustnav.model.generate

examples: $(DEV)
	@$(RUN) pytest -n auto tests/test_examples.py

# The C under every warning, and the sanitizers over kernel and extension.
native: $(DEV)
	@$(MAKE) --no-print-directory -j2 -C tests/native models
	@$(MAKE) --no-print-directory -C tests/native PYTHON='$(CURDIR)/$(BIN)/python'

wheel: $(DEV)
	rm -rf build/wheel
	@$(RUN) build --outdir build/wheel

$(RUNTIME): $(SOURCES) $(call stale,$(RUNTIME))
	@PYTHON='$(PYTHON)' tools/venv.sh report
	@printf '%s\n' '$(FOLDER)' '$(PYTHON)' >$@

$(DEV): $(SOURCES) $(call stale,$(DEV))
	@PYTHON='$(PYTHON)' tools/venv.sh dev
	@printf '%s\n' '$(FOLDER)' '$(PYTHON)' | tee $(RUNTIME) >$@

clean:
	rm -rf build out $(VENV)
