# Each target sets up what it needs; `make` alone lists them.

export OMP_NUM_THREADS = 1

UV = sh scripts/uv.sh
RUN = $(UV) run --no-sync
READY = .venv/.ready

.DEFAULT_GOAL := help
.PHONY: help setup demo test torture lint format bench docs clean

help:
	@awk -F ':.*## ' '/^[a-z]+:.*## / { printf "make %-7s %s\n", $$1, $$2 }' Makefile

setup: $(READY) ## install everything into .venv (needs Python 3.12 or later and a C compiler)

$(READY): pyproject.toml uv.lock .python-version scripts/uv.sh
	@$(UV) sync --locked
	@touch $@

demo: $(READY) ## run the contracting sheet of the paper, result in runs/sheet-2d
	$(RUN) myostrain run sheet-2d --out runs/sheet-2d --force
	@echo
	@echo 'numbers:   runs/sheet-2d/results.json, under "metrics"'
	@echo 'pictures:  runs/sheet-2d/figures/'
	@echo 'ParaView:  runs/sheet-2d/fields.bp'

test: $(READY) ## run the tests; options for pytest in ARGS, as in: make test ARGS="-k sheet"
	$(RUN) pytest -n auto --maxprocesses 4 $(ARGS)

torture: $(READY) ## kill, fill, corrupt and resume runs, and print what survived; options in ARGS
	$(RUN) python scripts/torture.py $(ARGS)

lint: $(READY) ## check style, format and types; changes nothing
	$(RUN) ruff check
	$(RUN) ruff format --check
	$(RUN) mypy

format: $(READY) ## format the code, apply the safe fixes, write docs/howto/case-file.md
	$(RUN) ruff check --fix-only
	$(RUN) ruff format
	$(RUN) python docs/extensions/case_reference.py

bench: $(READY) ## measure work against precision, write docs/benchmarks.md (half an hour); options in ARGS
	$(RUN) python benchmarks/work_precision.py $(ARGS)
	$(RUN) python benchmarks/solid.py
	$(RUN) python benchmarks/heart.py
	$(RUN) python benchmarks/electrics.py
	$(RUN) python benchmarks/membranes.py

docs: $(READY) ## build the documentation in build/docs (no network); start with build/docs/index.html
	$(RUN) sphinx-build -W --keep-going -q -b html -d build/doctrees docs build/docs
	@echo 'documentation: build/docs/index.html'

clean: ## remove the environment, tools, caches and builds; keeps runs/
	rm -rf .venv .tools build dist .hypothesis .mypy_cache .pytest_cache .ruff_cache
	find src tests benchmarks examples docs -name __pycache__ -prune -exec rm -rf {} + 2>/dev/null || true
