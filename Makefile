# `make demo` and `make test` are the two commands of the README; each does all set-up by itself.

PYTHON ?= python3

# Where a ROS 2 is sourced, its rclpy is used; elsewhere locked wheels bring one, of the distribution that ROS names:
# jazzy, or kilted (make test ROS=kilted). Two distributions cannot share an environment.
ifdef ROS_DISTRO
VENV := .venv
VENV_OPTIONS := --system-site-packages
ROS_WHEELS :=
LOCKED := $(ROS_DISTRO)
else
ROS ?= jazzy
VENV := .venv$(if $(filter-out jazzy,$(ROS)),-$(ROS))
VENV_OPTIONS :=
ROS_WHEELS := $(ROS),
LOCKED := $(ROS)
endif
ifneq ($(filter-out jazzy kilted $(ROS_DISTRO),$(ROS)),)
$(error ROS=$(ROS): wheels exist for jazzy and kilted; to use another ROS 2, source its setup file instead)
endif
HELD := $(filter-out $(LOCKED),$(foreach one,jazzy kilted,\
  $(if $(wildcard $(VENV)/lib/python3*/site-packages/ros_$(one)_rclpy-*),$(one))))
ifneq ($(and $(HELD),$(filter-out clean,$(or $(MAKECMDGOALS),setup))),)
$(error $(VENV) holds the rclpy of $(HELD), and $(LOCKED) is asked for: remove it with make clean, and repeat)
endif
BIN := $(VENV)/bin
READY := $(VENV)/.ready
TESTED := $(VENV)/.tested
# of the commands: nodes, live page, compiled search; the tests, the site and the mutants add theirs
EXTRAS := $(ROS_WHEELS)dashboard,fast
TEST_EXTRAS := $(EXTRAS),cluster,mujoco,test
MUTANTS_EXTRAS := $(TEST_EXTRAS),mutants
# of pytest-xdist
WORKERS := --numprocesses 5 --dist loadscope --no-loadscope-reorder
DOCS_EXTRAS := $(EXTRAS),docs

# where it is set, each of the thousand processes that the tests start compiles every module again
unexport PYTHONDONTWRITEBYTECODE

.PHONY: setup constraints demo figures test test-dds soak bench fingerprint bits mutants lint lint-js pages docs clean

setup: $(READY)

# what the packages of setup.py pull in has its version from a file in constraints/, where there is one
define install
@echo 'installing into $(VENV), a dot every 5 seconds: a minute or less, five on a slow machine'
@(while sleep 5 >/dev/null 2>&1; do printf .; done) & dots=$$!; trap "kill $$dots; echo" EXIT; trap 'exit 1' INT TERM; \
  versions=constraints/$(LOCKED)-$$($(BIN)/python -c 'import sys; print("%d.%d" % sys.version_info[:2])').txt; \
  if [ ! -f $$versions ]; then echo "no $$versions: the newest versions that fit are installed"; versions=/dev/null; fi; \
  $(BIN)/python -m pip install --quiet --disable-pip-version-check --use-pep517 --constraint $$versions \
    --editable '.[$(1)]'
@touch $@
endef

# the last file that venv writes
$(BIN)/activate:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 10))' || \
	  { echo "$(PYTHON) is older than 3.10; name a newer one: make PYTHON=python3.11"; exit 2; }
	@echo 'making the environment $(VENV): half a minute or less'
	@$(PYTHON) -m venv $(VENV_OPTIONS) $(VENV)

$(READY): setup.py setup.cfg package.xml $(wildcard constraints/*) | $(BIN)/activate
	$(call install,$(EXTRAS))

$(TESTED): setup.py setup.cfg package.xml $(wildcard constraints/*) | $(BIN)/activate
	$(call install,$(TEST_EXTRAS))
	@touch $(READY)

# lock what setup.py pulls in, on both distributions and all Pythons. A version that still fits stays, which CI checks;
# UPGRADE=--upgrade takes the newest
constraints: $(VENV)/.locking
	@for ros in jazzy kilted; do for python in 3.10 3.11 3.12; do \
	  $(BIN)/uv pip compile --quiet $(UPGRADE) --no-header --no-annotate --python-version $$python --extra $$ros \
	    $(foreach extra,cluster cuda dashboard docs fast locking mujoco mutants test,--extra $(extra)) \
	    setup.py -o constraints/$$ros-$$python.txt || exit; done; done

# not after `setup`, which a pin that has changed makes fail until the files are written again
$(VENV)/.locking: setup.py | $(BIN)/activate
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --use-pep517 --editable '.[locking]'
	@touch $@

demo: setup
	$(BIN)/mrc experiment --duration 16 --output runs/demo --overwrite
	@echo 'the report: open $(CURDIR)/runs/demo/report.html in a browser'
	@echo 'the robot live: $(BIN)/mrc dashboard, then open http://127.0.0.1:8080/'

figures: setup
	PYTHONPATH=examples/chapter $(BIN)/python -m chapter_figures.index --output runs/figures

test: $(TESTED)
	$(BIN)/python -m pytest $(WORKERS)

# the tests over DDS alone: those that another distribution could change; ONLY='FILE...' for some of them
test-dds: $(TESTED)
	$(BIN)/python -m pytest $(WORKERS) -m "dds and not soak" $(ONLY)

# one test at a time, each with the machine for itself; a line a test says how far it is; ONLY='FILE...' for some
soak: $(TESTED)
	$(BIN)/python -m pytest -m soak --capture no -vv --durations 0 -o faulthandler_timeout=0 \
	  $(ONLY)

# one table of ratios, each to something measured in the same run; ONLY='lockstep memory' for some of it
bench: $(TESTED)
	@PYTHONPATH=test $(BIN)/python -m bench $(ONLY)

# whether small computations have the bits of the repository: compiled, plain, without FMA, on other Pythons, and where
# BITS_ALSO leads, such as BITS_ALSO='qemu-aarch64 -L ROOT ROOT/usr/bin/python3'
bits: $(TESTED)
	@$(BIN)/python test/bits.py --everywhere

# one checksum an output, to compare two checkouts: see test/fingerprint.py
fingerprint: $(TESTED)
	@$(BIN)/python test/fingerprint.py

# do the tests notice small changes of what moves the robot? see test/mutants.py; 40 minutes
mutants: $(VENV)/.mutants
	$(BIN)/python test/mutants.py

$(VENV)/.mutants: $(TESTED)
	$(call install,$(MUTANTS_EXTRAS))

lint: $(TESTED)
	$(BIN)/python -m pytest $(WORKERS) test/lint

# the types of the scripts that run in a browser; it needs Node.js, and tools/package.json pins the checker
lint-js: tools/node_modules/.package-lock.json
	cd tools && npm run --silent check

tools/node_modules/.package-lock.json: tools/package.json tools/package-lock.json
	cd tools && npm ci --no-fund --no-audit

# the generated parts of docs/: the table is in tools/pages.py; ONLY=docs/robots.md for those of a file. Where the
# tracks or searches behind the table of the laws have changed, the benchmark runs again: some seven hours
pages: $(TESTED)
	$(BIN)/python tools/pages.py $(ONLY)

# docs/ and the API as a site; a warning is an error
docs: $(VENV)/.docs
	$(BIN)/python -m sphinx -W --keep-going -E -q -b html docs docs/_build
	@echo 'site: $(CURDIR)/docs/_build/index.html'

$(VENV)/.docs: $(READY)
	$(call install,$(DOCS_EXTRAS))

clean:
	rm -rf .venv .venv-* build install log docs/_build *.egg-info
