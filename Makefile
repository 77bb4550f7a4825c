# make demo: a pipe, a trained policy, its evaluation, and pictures of robots in the pipe, in demo/
# make test: what continuous integration runs
# make quick: the tests that take neither seconds nor real time, in less than a minute
# make explore: the tests of laws once more, with new examples each time
# make clean: remove everything that these make

PYTHON ?= $(shell command -v python3.11 || command -v python3)
BIN := .venv/bin
PIP := $(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt
CPU_BUILDS := https://download.pytorch.org/whl/cpu

.PHONY: demo test quick explore clean

demo: .venv/installed
	rm -rf demo
	$(BIN)/pipenav gen-pipe --d 100 --angle 75 --out demo
	$(BIN)/pipenav train --backend mujoco --out demo/run
	$(BIN)/pipenav eval --policy demo/run/best.zip --out demo/eval
	$(BIN)/pipenav view --policy demo/run/best.zip --pipes d=100,angle=75 --out demo/front-half.png
	$(BIN)/pipenav view --policy pirate --pipes d=100,angle=75 --out demo/passing.png
	@echo
	@echo "The pictures, the last one of a whole robot passing the corner:"
	@find demo -name '*.png' ! -name passing.png | sort | sed 's/^/  /'
	@echo "  demo/passing.png"

test: .venv/installed-dev
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/pytest -m "not realtime" -n auto
	$(BIN)/pytest -m realtime

quick: .venv/installed-dev
	$(BIN)/pytest -m "not slow and not realtime" --hypothesis-profile quick -n auto

explore: .venv/installed-dev
	$(BIN)/pytest -m "hypothesis and not realtime" --hypothesis-profile explore -n auto

clean:
	rm -rf .venv demo .mypy_cache .pytest_cache .ruff_cache .hypothesis
	find pipenav plugins tests -name __pycache__ -prune -exec rm -rf {} +

.venv/bin/python:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { \
	    echo "pipenav needs Python 3.11 or newer: make PYTHON=/path/to/python3.11 ..." >&2; exit 1; }
	$(PYTHON) -m venv .venv

# torch without CUDA: where pip does not know its CPU build, PyTorch's own index has it.
.venv/torch: constraints.txt | .venv/bin/python
	$(PIP) torch 2> .venv/torch.log || $(PIP) --extra-index-url $(CPU_BUILDS) torch
	touch $@

.venv/installed: pyproject.toml constraints.txt .venv/torch | .venv/bin/python
	$(PIP) -e .
	touch $@

.venv/installed-dev: pyproject.toml constraints.txt .venv/torch | .venv/bin/python
	$(PIP) -e '.[dev]'
	touch $@ .venv/installed
