# make fit    set everything up, fit the LGMD2 to its target curves, leave the results in results/lgmd2/
# make test   set everything up, run the tests
# make test-lowest   the tests at the lowest versions that pyproject.toml allows, on Python 3.11
# make test-newest   the tests at the newest versions, on Python 3.13; TESTS=tests/targets takes a part of them
# make test-robot    hard.py on Python 3.8 with NumPy 1.17
# make notebooks   set everything up, run the notebooks and write them again
# make docs   set everything up, build the documentation site; open build/site/index.html
# make dist   set everything up, build the source archive and the wheel from it, check both; they lie in build/dist/
# make test-wheel   the wheel outside of the clone, on the lowest and the newest Python: a smoke test, the examples and
#                   the notebooks that need no clone
# make lint   set everything up, check style, types, and which room imports which
PYTHON ?= python3
VENV ?= .venv

.PHONY: fit gallery test test-lowest test-newest test-robot notebooks docs dist test-wheel lint
fit: $(VENV)/ready
	mkdir -p results
	$(VENV)/bin/lgmd2jax fit fits/lgmd2.toml -o results/lgmd2

# What fits/ shows: the same fits, written where git keeps them.
gallery: $(VENV)/ready
	for recipe in lgmd2 table1 twin dcmd video; do $(VENV)/bin/lgmd2jax fit fits/$$recipe.toml || exit 1; done

test: $(VENV)/ready
	$(VENV)/bin/python -m pytest -n 2 --dist loadfile

test-lowest: $(VENV)/ready
	$(VENV)/bin/uv venv --quiet --clear --python 3.11 build/lowest
	$(VENV)/bin/uv pip install --quiet --python build/lowest --resolution lowest-direct --editable '.[test]'
	build/lowest/bin/python -m pytest $(TESTS)

test-newest: $(VENV)/ready
	$(VENV)/bin/uv venv --quiet --clear --python 3.13 build/newest
	$(VENV)/bin/uv pip install --quiet --python build/newest --upgrade --editable '.[test]'
	build/newest/bin/python -m pytest $(TESTS)

test-robot: $(VENV)/ready
	$(VENV)/bin/uv venv --quiet --clear --python 3.8 build/robot
	$(VENV)/bin/uv pip install --quiet --python build/robot numpy==1.17.3
	LGMD2JAX_ROBOT_PYTHON=$(CURDIR)/build/robot/bin/python $(VENV)/bin/python -m pytest tests/handover/test_hard.py -k robot

notebooks: $(VENV)/ready
	$(VENV)/bin/python -m notebooks.build $(NOTEBOOKS)

docs: $(VENV)/ready
	NO_MKDOCS_2_WARNING=1 $(VENV)/bin/python -m mkdocs build --strict --quiet

dist: $(VENV)/ready
	rm -rf build/dist
	$(VENV)/bin/python -m build --quiet --outdir build/dist
	$(VENV)/bin/twine check --strict build/dist/*

test-wheel: dist
	for python in 3.11 3.13; do \
		$(VENV)/bin/uv venv --quiet --clear --python $$python build/wheel-$$python && \
		$(VENV)/bin/uv pip install --quiet --python build/wheel-$$python "$$(echo build/dist/*.whl)[cluster,notebooks,video]" && \
		$(VENV)/bin/python -m benchmarks.wheel build/wheel-$$python/bin/python && \
		build/wheel-$$python/bin/python -m notebooks.build --check --tutorial || exit 1; \
	done

lint: $(VENV)/ready
	$(VENV)/bin/ruff check
	$(VENV)/bin/ruff format --check
	$(VENV)/bin/lint-imports --no-cache --no-logo
	$(VENV)/bin/pyright --pythonpath $(VENV)/bin/python

$(VENV)/ready: pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' \
		|| { echo "lgmd2jax needs Python 3.11 or later; name one: make PYTHON=python3.12"; exit 1; }
	$(PYTHON) -m venv $(VENV)
	$(VENV)/bin/python -m pip install --quiet --disable-pip-version-check --editable '.[dev]'
	touch $@
