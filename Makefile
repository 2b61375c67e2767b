# The two commands of the README are `make demo` and `make test`; `make help` lists the others.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
STAMP := $(VENV)/.installed
PROTO := passafe_protocol/passafe.proto
GENERATE := $(BIN)/python -m grpc_tools.protoc -I protocol
DEMO ?=
FUZZ_S ?= 60
PYTHONS ?= python3.12 python3.13
QUIET := not live and not browser and not alone and not campaign and not container
LIVE := live or browser
# Test files in which a mark stands, $(call OF_MARK,live|browser): the others need not be imported.
OF_MARK = $(shell grep -rlE 'mark\.($(1))' --include='test_*.py' tests)
# Whole files to a worker, in the order of tests/conftest.py: the longest first.
PARALLEL := -n auto --dist loadfile --no-loadscope-reorder
# Tests whose coverage of core and protocol counts: to measure it takes a quarter more time, so the others go without.
COVERING := tests/core tests/protocol tests/keys tests/loop tests/tables
CAMPAIGN ?= $(filter-out arm-%,$(basename $(notdir $(wildcard services/passafe_services/scenarios/*.toml))))

.PHONY: help demo test check lint types current fast proto lock docs site pictures screenshots bench campaign core-campaign generated-campaign uncertain-campaign arm-campaign atlas delay-atlas worker-kills resumes faults recovery mutation wheel wheel-test container-test network-test fuzz soak clean golden what-if-pairs

help:  ## list the targets
	@grep -E '^[a-z-]+:.*##' $(MAKEFILE_LIST) | sed 's/:.*##/\t/' | expand -t 13

$(STAMP): pyproject.toml constraints.txt
	@$(PYTHON) -c 'import sys; sys.exit("passafe needs Python 3.11 or newer; this is " + sys.version.split()[0] + ". Try: make PYTHON=python3.12 …") if sys.version_info < (3, 11) else None'
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --upgrade "pip>=24"
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt --editable '.[dev]'
	@touch $(STAMP)

demo: $(STAMP)  ## the multi-process demo; options by DEMO='--mode off --duration 10'
	$(BIN)/passafe demo $(DEMO)

test: $(STAMP)  ## every test that CI runs, with coverage of core and protocol
	$(BIN)/python -m pytest $(PARALLEL) -m '$(QUIET)' $(COVERING) --cov --cov-report=term:skip-covered --cov-fail-under=100
	$(BIN)/python -m pytest $(PARALLEL) -m '$(QUIET)' $(addprefix --ignore=,$(COVERING))
	$(BIN)/python -m pytest $(PARALLEL) -m '($(LIVE)) and not alone' $(call OF_MARK,live|browser)
	$(BIN)/python -m pytest -m alone $(call OF_MARK,alone)

fast: $(STAMP)  ## the tests that start no process and no browser, and compile nothing
	$(BIN)/python -m pytest $(PARALLEL) -m 'not live and not browser and not compiled and not campaign and not container'

check: lint types current  ## lint, format, types, import direction, generated files current; with -j 2 side by side

lint: $(STAMP)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/lint-imports

types: $(STAMP)
	$(BIN)/mypy
	$(BIN)/mypy wheel_build
	$(BIN)/mypy benchmarks
	$(BIN)/mypy docs_build examples
	$(BIN)/mypy deploy

current: $(STAMP)
	@mkdir -p .build && $(GENERATE) --python_out=.build --pyi_out=.build $(PROTO)
	@for f in passafe_pb2.py passafe_pb2.pyi; do cmp .build/passafe_protocol/$$f protocol/passafe_protocol/$$f || { echo "protocol/passafe_protocol/$$f is not current: run make proto"; exit 1; }; done
	$(BIN)/python -m passafe_protocol.wire_table --check docs/wire-protocol.md
	$(BIN)/python docs_build/reference.py --check

proto: $(STAMP)  ## generate the protobuf code
	$(GENERATE) --python_out=protocol --pyi_out=protocol $(PROTO)

docs: $(STAMP)  ## generate the reference pages: wire, command line, keys of files
	$(BIN)/python -m passafe_protocol.wire_table --write docs/wire-protocol.md
	$(BIN)/python docs_build/reference.py --write

site: $(STAMP)  ## the documentation as a site, .build/site/index.html
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --strict

pictures: $(STAMP)  ## the pictures of README and docs, from runs
	$(BIN)/python docs_build/moving_picture.py docs/pictures/four-modes.gif
	$(BIN)/python -m passafe_dashboard.pictures docs/pictures
	$(BIN)/python docs_build/report_picture.py docs/pictures/report.png
	$(BIN)/python docs_build/drive_picture.py docs/pictures

screenshots: $(STAMP)  ## .build/screenshots: the live page of every shipped scenario, four widths, light and dark; some minutes
	$(BIN)/python docs_build/page_pictures.py .build/screenshots

bench: $(STAMP)  ## docs/benchmarks.md: ratios of every benchmark; some 10 minutes on an idle machine
	$(BIN)/python benchmarks/write_page.py

campaign: $(STAMP)  ## 10,000 adversarial rollouts of every shipped scenario; about an hour; resumes where it was interrupted
	$(BIN)/passafe campaign $(CAMPAIGN) --rollouts 10000 --out runs/campaign

core-campaign: $(STAMP)  ## the random requests of the core's tests, of which CI asks the first third; some minutes
	$(BIN)/python -m pytest -n auto -m campaign tests/core

generated-campaign: $(STAMP)  ## 20,000 closed loops of systems made from seeds; hours; resumes where it was interrupted
	$(BIN)/passafe campaign --generated --rollouts 20000 --out runs/generated

arm-campaign: $(STAMP)  ## 200 runs of 10 s of the arm in MuJoCo, pushed and steered at obstacles; an hour
	$(BIN)/python benchmarks/arm_in_mujoco.py --runs 200 --duration 10 --workers 2

uncertain-campaign: $(STAMP)  ## 1,000 rollouts of every way a plant may differ from its model; an hour; resumes where it was interrupted
	$(BIN)/passafe campaign --uncertain --rollouts 1000 --duration 4 --out runs/uncertain

atlas: $(STAMP)  ## the pictures of docs/feasibility.md
	@for gain in 10 1; do \
		$(BIN)/passafe feasibility --fix x2=-1 --fix x3=-1 --gain $$gain --out runs/atlas/gain-$$gain && \
		cp runs/atlas/gain-$$gain/notomista-cai-2020.svg docs/pictures/feasibility-gain-$$gain.svg || exit 1; \
	done

golden: $(STAMP)  ## tests/golden: logs of small runs, made anew when a decision is meant to change
	$(BIN)/python tests/golden/golden_logs.py

what-if-pairs: $(STAMP)  ## what-ifs under 150 ms more beside runs recorded so, 20 pairs; some minutes
	$(BIN)/python -m pytest tests/what_if -m campaign

worker-kills: $(STAMP)  ## kills 500 workers of sweeps at random moments; a quarter of an hour
	$(BIN)/python tests/runs/worker_kills.py --kills 500

faults: $(STAMP)  ## docs/faults.md: every fault against every process in three seeded passes; half an hour; resumes where it was interrupted
	$(BIN)/python tests/faults/fault_table.py --passes 3 --write docs/faults.md

resumes: $(STAMP)  ## a thousand random resumes after stops, deaths and outages, in virtual time; some minutes
	$(BIN)/python -m pytest tests/simulation/test_resumes.py -m campaign

recovery: $(STAMP)  ## kills 200 recorders, cuts off 200 logs and damages 200: what is recovered, and is the rest named? some minutes
	$(BIN)/python tests/log/recovery_campaign.py

fuzz: $(STAMP)  ## 5,000 mutations of every kind of file and message that passafe reads, then FUZZ_S=60 s of each guided by coverage
	$(BIN)/python -m pytest tests/fuzz tests/dashboard/test_dashboard_http_schema.py -m campaign
	for target in $$(ls tests/fuzz/corpus); do $(BIN)/python tests/fuzz/coverage_guided.py $$target $(FUZZ_S) || exit 1; done

soak: $(STAMP)  ## a demo of half an hour: memory, file handles and threads of every process stay level
	$(BIN)/python tests/system/soak.py

mutation: $(STAMP)  ## changes the core one thing at a time: does a test notice? an hour or two; resumes where it was interrupted
	$(BIN)/python benchmarks/mutation.py

delay-atlas: $(STAMP)  ## the delay-margin atlas of docs/measurements.md; resumes where it was interrupted
	$(BIN)/passafe experiment delay-margin --keep none --out runs/delay-margin
	cp runs/delay-margin/boundaries.svg docs/pictures/delay-margin.svg

wheel: $(STAMP)  ## dist/: a wheel with the loop compiled, for long sweeps; takes a C compiler and a minute
	HATCH_BUILD_HOOK_ENABLE_CUSTOM=true $(BIN)/python -m pip wheel --quiet --disable-pip-version-check --no-deps --no-build-isolation --wheel-dir dist .
	@ls dist/passafe-*

wheel-test: $(STAMP)  ## the wheel and all that it requires, installed fresh for each of PYTHONS='python3.12 python3.13'
	@for python in $(PYTHONS); do $(BIN)/python -m pytest tests/system/test_wheel.py --interpreter $$python -o timeout=900 || exit 1; done

container-test: $(STAMP)  ## builds the image and runs docker-compose.yml with Debian's podman; as root, some minutes
	$(BIN)/python -m pytest -m container tests/deploy/test_container.py -o timeout=1200

network-test: $(STAMP)  ## the system over hosts with other clocks and a bad network between; as root, minutes
	$(BIN)/python -m pytest tests/network -m campaign

lock: $(STAMP)  ## pin what is installed now
	$(BIN)/python -m pip freeze --all --exclude pip --exclude-editable | grep -v ' @ ' > constraints.txt

clean:  ## remove everything generated
	rm -rf $(VENV) .venv-compiled .build dist .mypy_cache .ruff_cache .pytest_cache .hypothesis runs
