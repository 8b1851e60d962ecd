# Each command makes its own environment, from pinned versions, in .venv.
PYTHON ?= python3
BIN := .venv/bin
# Bytecode is kept, also where the environment says not to: tests start Python some hundred times.
export PYTHONDONTWRITEBYTECODE =

.PHONY: table1 unit test slow lint guide clean

table1: .venv/installed
	$(BIN)/masonry-opt reproduce table1 --out results

# "unit" runs the fast tests of single parts. "test" runs all fast tests, and "slow" the tests that are marked so.
unit: .venv/installed
	OMP_NUM_THREADS=1 $(BIN)/python -m pytest -n 2 --dist worksteal tests/unit

# Tests of one file share the scenes that they solve: a file stays on one worker.
test: .venv/installed
	OMP_NUM_THREADS=1 $(BIN)/python -m pytest -n 2 --dist loadfile

slow: .venv/installed
	OMP_NUM_THREADS=1 $(BIN)/python -m pytest -n 2 --dist worksteal -m slow

lint: .venv/installed
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	# models/ is imported as masonry_opt.models: type-check the tree as a wheel lays it out, by links.
	rm -rf build/typed && mkdir -p build/typed/masonry_opt
	ln -s $(CURDIR)/masonry_opt/* $(CURDIR)/models build/typed/masonry_opt/
	cd build/typed && ../../$(BIN)/python -m mypy --config-file ../../pyproject.toml -p masonry_opt

# The guide, as pages for a browser, in build/guide; its examples and its notebook are run.
guide: .venv/installed
	OMP_NUM_THREADS=1 $(BIN)/python -m sphinx -W --keep-going -q -b html docs build/guide

# Modules are compiled when they are first imported, because most of them are never used.
.venv/installed: pyproject.toml constraints.txt
	$(PYTHON) -c 'import sys; sys.exit(0 if sys.version_info >= (3, 11) else "Python 3.11 or newer is needed: make PYTHON=python3.12")'
	$(PYTHON) -m venv --clear .venv
	$(BIN)/python -m pip install --quiet --no-compile --constraint constraints.txt --editable '.[check,dask,docs,drawings,meshes,mpec,studies,test]'
	touch $@

clean:
	rm -rf .venv build dist results docs/examples docs/jupyter_execute *.egg-info
