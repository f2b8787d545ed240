# `make demo` and `make test` are the two commands of the README; each does all set-up by itself.

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
READY := $(VENV)/.ready

# Where a ROS 2 is sourced, its rclpy is used; elsewhere the pinned wheels bring one.
ifdef ROS_DISTRO
VENV_OPTIONS := --system-site-packages
EXTRAS := pinned,test
else
VENV_OPTIONS :=
EXTRAS := wheels,pinned,test
endif

.PHONY: setup demo figures test soak bench lint readme clean

setup: $(READY)

$(READY): setup.py setup.cfg package.xml
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 10))' || \
	  { echo "$(PYTHON) is older than 3.10; name a newer one: make PYTHON=python3.11"; exit 2; }
	$(PYTHON) -m venv $(VENV_OPTIONS) $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[$(EXTRAS)]'
	@touch $@

demo: setup
	$(BIN)/experiment --duration 16 --output runs/demo --overwrite

figures: setup
	$(BIN)/python -m mobile_robot_control.reporting.chapter.index --output runs/figures

test: setup
	$(BIN)/python -m pytest

# one test at a time, each with the machine for itself; a line a test says how far it is
soak: setup
	$(BIN)/python -m pytest -m soak --numprocesses 0 --capture no --verbose --durations 0

# one table of ratios, each to something measured in the same run; ONLY='lockstep memory' for some of it
bench: setup
	@PYTHONPATH=test $(BIN)/python -m bench $(ONLY)

lint: setup
	$(BIN)/python -m pytest test/lint

readme: setup
	$(BIN)/python -m mobile_robot_control.reporting.parameter_table README.md docs/nodes/*.md
	$(BIN)/python -m mobile_robot_control.reporting.chapter.claims_table README.md
	$(BIN)/python -m mobile_robot_control.reporting.chapter.readme_pictures docs/images

clean:
	rm -rf $(VENV) build install log *.egg-info
