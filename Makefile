# make fit    set everything up, fit the LGMD2 to its target curves, leave the results in results/lgmd2/
# make test   set everything up, run the tests
# make notebooks   set everything up, run the notebooks and write them again
# make lint   set everything up, check style, types, and which room imports which
PYTHON ?= python3
VENV ?= .venv

.PHONY: fit gallery test notebooks lint
fit: $(VENV)/ready
	mkdir -p results
	$(VENV)/bin/lgmd2jax fit fits/lgmd2.toml -o results/lgmd2

# What fits/ shows: the same fits, written where git keeps them.
gallery: $(VENV)/ready
	for recipe in lgmd2 table1 twin dcmd video; do $(VENV)/bin/lgmd2jax fit fits/$$recipe.toml || exit 1; done

test: $(VENV)/ready
	$(VENV)/bin/python -m pytest -n 2 --dist loadfile

notebooks: $(VENV)/ready
	$(VENV)/bin/python -m notebooks.build $(NOTEBOOKS)

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
