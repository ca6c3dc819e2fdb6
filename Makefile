# Two commands for users (play, test); `make help` lists the rest.
PYTHON ?= python3
BIN := .venv/bin
PIP := $(BIN)/pip --disable-pip-version-check install -c constraints.txt

.PHONY: help play venv test test-slow test-large-downloads check bench agents anywhere format generate site lock wheel clean

help: ## list these commands
	@awk -F ':.*## ' '/^[a-z-]+:.*## / { printf "%-23s %s\n", $$1, $$2 }' $(MAKEFILE_LIST)

play: .venv/serve ## serve the game and print its links
	@$(BIN)/movingout play $(ARGS)

venv: .venv/dev ## prepare the environment with everything for development

test: .venv/dev .venv/browser .venv/node ## every test but the long ones (minutes)
	$(BIN)/pytest -n 2 --max-worker-restart 0 --dist loadfile -m "not slow" --durations=25 $(ARGS)

test-slow: .venv/dev .venv/browser .venv/node ## the long tests: pages, studies in real time, trainings, clusters, fuzzing, load
	$(BIN)/pytest -n 2 --max-worker-restart 0 --dist loadfile -m "slow and not large_download" --durations=25 $(ARGS)

test-large-downloads: .venv/dev ## the tests of LeRobot in an environment of its own (8 GB)
	$(BIN)/pytest -m large_download $(ARGS)

check: .venv/dev .venv/node ## format, lint, types, import rules, JavaScript, the list of files in docs/
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/mypy examples/remote_agent.py examples/evaluate_my_policy.py
	$(BIN)/lint-imports
	$(BIN)/pytest --quiet tests/bench/source
	node_modules/.bin/prettier --check --log-level warn 'web/**/*.{js,css}' 'tests/browser/*.js'
	node_modules/.bin/eslint web tests/browser
	cd web && ../node_modules/.bin/tsc -p jsconfig.json
	node --test $$(find web/tests -name '*.test.js')

bench: .venv/dev ## measure; prints ratios and the machine
	$(BIN)/python -m bench

agents: .venv/dev ## train the agents from nothing and write docs/twelve-maps.md (hours)
	$(BIN)/python -m bench.train_agents $(ARGS)

anywhere: .venv/dev ## train the agents for any map from nothing and print their tables (hours)
	$(BIN)/python -m bench.train_anywhere $(ARGS)

format: .venv/dev .venv/node ## rewrite the sources in the house format
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .
	node_modules/.bin/prettier --write --log-level warn 'web/**/*.{js,css}' 'tests/browser/*.js'

generate: .venv/dev ## write what is made from the sources: web/messages.js, tables and lists in docs/
	$(BIN)/python -m movingout.server.messages_js
	$(BIN)/python -m bench.source.metric_pages
	$(BIN)/python -m bench.source.frame_tables
	$(BIN)/python -m tests.server.golden_frames
	$(BIN)/python -m bench.source.phrases

site: .venv/dev ## build the documentation as a site into data/site, with a reference of commands and YAML fields
	NO_MKDOCS_2_WARNING=1 PYTHONPATH=src:. $(BIN)/python -m mkdocs build --strict

lock: .venv/bin/python ## write constraints/serving.txt: what serving needs, by version and hash
	$(BIN)/pip --disable-pip-version-check install --quiet uv
	@head -n 2 constraints/serving.txt > constraints/serving.new
	$(BIN)/uv pip compile pyproject.toml --extra postgres --extra tls --constraint constraints.txt --universal --python-version 3.11 \
		--generate-hashes --no-header --no-annotate --quiet >> constraints/serving.new
	@mv constraints/serving.new constraints/serving.txt

wheel: .venv/bin/python ## build the wheel into dist/
	$(BIN)/pip --disable-pip-version-check wheel --no-deps --wheel-dir dist .

clean: ## remove the environment, caches and what was built (never data/)
	rm -rf .venv node_modules .mypy_cache .ruff_cache .pytest_cache .import_linter_cache .hypothesis test-results build dist ./*.egg-info

.venv/bin/python:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { echo "Python 3.11 or newer is needed; try: make PYTHON=python3.12 $(MAKECMDGOALS)"; exit 2; }
	$(PYTHON) -m venv .venv

.venv/serve: .venv/bin/python pyproject.toml constraints.txt
	@echo "Installing what serving needs (once, a minute or two)."
	$(PIP) -e '.[study,tls]'
	@touch $@

.venv/dev: .venv/serve
	@echo "Installing the tools for development (once, some minutes; torch is the big part)."
	$(PIP) -e '.[dev,train]'
	@touch $@

.venv/browser: .venv/dev
	$(BIN)/python -m tests.browser.install
	@touch $@

.venv/node: package.json .venv/bin/python
	@node -e 'const [main, minor] = process.versions.node.split(".").map(Number); process.exit(main >= 24 || (main === 20 && minor >= 19) || (main === 22 && minor >= 13) ? 0 : 1)' \
		&& command -v npm > /dev/null || { echo "Node 20.19, 22.13, or 24 and newer, with npm, is needed for the checks of the browser code"; exit 2; }
	npm install --no-package-lock --no-audit --no-fund --silent
	@touch $@
