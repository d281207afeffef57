# Everything there is to run, by one word each; `make` alone lists the words. All of it happens
# in .venv, which the first target that needs it sets up. `make PYTHON=python3.12 ...` chooses
# the Python. Plain make 3.81 and sh are enough, so that a bare Debian or macOS can run it.

VENV := .venv
BIN := $(VENV)/bin
# Two stages, so that the demo does not wait for what only the tests and the camera need.
CORE := $(VENV)/.core-is-set-up
ALL := $(VENV)/.all-is-set-up
# The version is recorded at installation, so a new one is a reason to install again.
INPUTS := pyproject.toml constraints.txt scripts/setup.sh src/kendon/_version.py

.DEFAULT_GOAL := help
.PHONY: help demo test check setup lock clean

help: ## list these targets
	@echo "kendon: reads the phases of a greeting, and lets a robot greet back"
	@awk -F ':.*## ' '/^[a-z]+:.*## / { printf "  make %-7s %s\n", $$1, $$2 }' $(firstword $(MAKEFILE_LIST))

demo: $(CORE) ## greet a simulated person and draw it in greeting.png
	@echo "A simulated person meets a robot, which greets back:"
	$(BIN)/kendon greet --figure greeting.png

test: check ## check, then run every test
	@echo "Running the tests."
	$(BIN)/python -m pytest

check: $(ALL) ## lint, formatting and types, without running anything
	@echo "Checking style and types (half a minute the first time)."
	$(BIN)/ruff check
	$(BIN)/ruff format --check
	$(BIN)/mypy

setup: $(ALL) ## set up .venv with every extra, and do nothing else
	@echo "Everything is set up; the command is $(BIN)/kendon."

lock: $(BIN)/python ## pin what pyproject.toml asks for, keeping pins that fit (UPGRADE=1: newest)
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check uv
	$(BIN)/uv pip compile --quiet --universal --python-version 3.11 --all-extras \
	  --no-emit-index-url --no-emit-find-links --no-annotate \
	  --custom-compile-command 'make lock' $(if $(UPGRADE),--upgrade) \
	  --output-file constraints.txt pyproject.toml
	@echo "constraints.txt is up to date; the next target installs it."

clean: ## remove .venv, caches and what demo and test left behind
	rm -rf $(VENV) .pytest_cache .mypy_cache .ruff_cache .hypothesis build dist greeting.png
	find src tests -name __pycache__ -type d -prune -exec rm -rf {} +

# Also when the Python it was made with has gone, since the link then leads nowhere.
$(BIN)/python:
	@sh scripts/setup.sh $(VENV) venv

$(CORE): $(BIN)/python $(INPUTS)
	@sh scripts/setup.sh $(VENV) core
	@touch $@

# After the core, never beside it: two pips in one environment would tear it (make -j demo test).
$(ALL): $(CORE)
	@sh scripts/setup.sh $(VENV) all
	@touch $@
