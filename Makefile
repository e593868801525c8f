# Every target sets up what it needs in .venv, once; `make` alone lists them.

# Each start of Python would compile all modules again.
unexport PYTHONDONTWRITEBYTECODE

VENV := .venv
PY := $(VENV)/bin/python
PIP := $(PY) -m pip --quiet --quiet --disable-pip-version-check

# The ROS wheels exist for CPython 3.10 to 3.13; `make PYTHON=...` chooses another interpreter.
PYTHON ?= $(shell for python in python3 python3.13 python3.12 python3.11 python3.10; do \
	$$python -c 'import sys; sys.exit(not (3, 10) <= sys.version_info < (3, 14))' 2>/dev/null \
	&& echo $$python && break; done)

# A sourced ROS 2 of the machine is used as it is; otherwise the extra `ros` brings Jazzy's wheels.
SOURCED := $(shell test -n "$$ROS_DISTRO" && $(PYTHON) -c 'import rclpy' 2>/dev/null && echo yes)
ROS := $(if $(SOURCED),,[ros])
ALL := $(if $(SOURCED),,ros,)environment,gym,plot,spice,sweep,tables,watch

# numba 0.58, the oldest that we name, has wheels up to CPython 3.11.
OLD := $(VENV)-oldest
OLD_PYTHON = $(shell for python in python3.11 python3.10 $(PYTHON); do \
	$$python -c 'import sys; sys.exit(sys.version_info[:2] not in ((3, 10), (3, 11)))' 2>/dev/null \
	&& echo $$python && break; done)
# What the libraries are used for most: propagation, closed forms, the Earth, bags, YAML, pictures,
# a node.
OLD_TESTS := test/integrate/test_propagation.py test/integrate/test_batch.py test/integrate/test_bits.py \
	test/trace test/exact/test_elliptic.py \
	test/exact/test_flow.py test/environment test/run/test_environment.py test/run/test_orbits.py \
	test/run/test_simulation.py test/messages test/rosbag2 test/bag/test_verify.py \
	test/report/test_plot.py test/ros/test_stream.py

# Tests run in processes of their own ROS domain, each with some 800 MB of memory.  Half of their
# time they wait for a node or a subscriber: four are not too many for two cores.  What the tests
# of a file share, such as a node and a page, is there once.
SIDE_BY_SIDE := --numprocesses 4 --dist loadfile --no-loadscope-reorder

# What `make test` leaves to the longer proofs, in five parts of like length: .ci/run runs the one
# that the commit says, `make everything` all.
PARTS := part-1 part-2 part-3 part-4 part-5
LONG_TESTS_2 := test/cli test/exact test/exchange test/messages test/report test/sweep test/test_*.py
LONG_TESTS_3 := test/ros
LONG_TESTS_4 := test/actuators test/bag test/controllers test/kernel test/rosbag2 test/watch
LONG_TESTS_5 := test/base test/dynamics test/environment test/guidance test/gym test/integrate test/orbits test/run test/sensors \
	test/theory test/torques test/trace

.PHONY: everything $(PARTS) help demo test test-all pages torture reference oldest lint colcon figures docs bench release clean

help:
	@echo 'make demo     a satellite live for 20 s: the node, a subscriber, a request, a bag;'
	@echo '              with WATCH=1 for 10 min, and a page to watch it'
	@echo 'make test     the tests that prove an installation and a change (six minutes)'
	@echo 'make test-all the longer tests, which make test leaves out'
	@echo 'make everything  what make test leaves out, colcon, the oldest libraries and short benchmarks'
	@echo 'make pages    what README, docs and CONTRIBUTING show to run, in a clone of its own'
	@echo 'make lint     ruff and mypy'
	@echo 'make colcon   build the package in a colcon workspace of its own and try what it installs'
	@echo 'make figures  draw the pictures of the documentation again'
	@echo 'make docs     the site, in build/docs'
	@echo 'make bench    the benchmarks against their peers; writes benchmark/RESULTS.md;'
	@echo '              with QUICK=1 two minutes that only show that they run'
	@echo 'make torture  the long forms of the tests (hours): every flipped bit, mutated bags and YAML,'
	@echo '              random programs, requests of four clients, kills, restarts, a simulated day'
	@echo 'make reference  recompute the reference cases to 50 digits and compare (some minutes)'
	@echo 'make oldest   tests with the oldest libraries that setup.py names (Python 3.10 or 3.11)'
	@echo 'make release  build sdist and wheel in dist/, check them, and try the wheel elsewhere, as a'
	@echo '              stranger would (two to six minutes)'
	@echo 'make clean    remove .venv and everything that was built'

demo: $(VENV)/.run $(if $(WATCH),$(VENV)/.watch)
	@WATCH=$(WATCH) $(PY) examples/demo.py

test: $(VENV)/.test
	@$(PY) -m pytest $(SIDE_BY_SIDE) --costs

test-all: $(VENV)/.test $(VENV)/.cesium
	@NODE_PATH=$(abspath $(VENV))/cesium/node_modules $(PY) -m pytest $(SIDE_BY_SIDE) --costs -m 'long and not torture' $(TESTS)

everything: $(PARTS)

part-1: oldest

part-2: colcon
	@$(MAKE) --no-print-directory bench QUICK=1
	@$(MAKE) --no-print-directory test-all TESTS='$(LONG_TESTS_2)'

part-3 part-4 part-5: part-%:
	@$(MAKE) --no-print-directory test-all TESTS='$(LONG_TESTS_$*)'

pages:
	@$(PYTHON) scripts/run_pages.py

torture: $(VENV)/.test
	@$(PY) -m pytest -m torture --timeout=0

reference: $(VENV)/.test
	@nice $(PY) test/reference/generate.py

oldest: $(OLD)/.test
	@$(OLD)/bin/python -m pytest $(SIDE_BY_SIDE) $(OLD_TESTS)

lint: $(VENV)/.test
	@$(PY) -m ruff check
	@$(PY) -m ruff format --check
	@$(PY) -m mypy
	@$(PY) -m check_jsonschema --quiet --builtin-schema vendor.github-workflows .github/workflows/ci.yml

colcon: $(VENV)/.colcon
	@.ci/colcon

figures: $(VENV)/.test
	@$(PY) docs/figures.py

docs: $(VENV)/.docs
	@# Pages of the API that were written for modules that are no more.
	@rm -rf docs/reference/api
	@$(PY) -m sphinx -q -W --keep-going -b html docs build/docs
	@echo 'build/docs/index.html'

bench: $(VENV)/.bench
	@$(PY) benchmark/run.py $(if $(QUICK),--quick)

release: $(VENV)/.release
	@$(PY) scripts/release.py

clean:
	rm -rf $(VENV) $(OLD) build dist install log *.egg-info
	rm -rf .pytest_cache .mypy_cache .ruff_cache .hypothesis
	find . -name __pycache__ -prune -exec rm -rf {} +

$(PY):
	@test -n "$(PYTHON)" || { echo 'No Python 3.10 to 3.13 found; use make PYTHON=/path/to/python'; exit 1; }
	@echo "Making $(VENV) with $$($(PYTHON) --version)"
	@$(PYTHON) -m venv $(if $(SOURCED),--system-site-packages) $(VENV) || { rm -rf $(VENV); exit 1; }
	@touch $(VENV)/COLCON_IGNORE

$(OLD)/.test: setup.py
	@test -n "$(OLD_PYTHON)" || { echo 'make oldest needs Python 3.10 or 3.11: numba 0.58 has no wheel for later ones'; exit 1; }
	@echo 'Installing the oldest libraries that setup.py names (a minute)'
	@$(OLD_PYTHON) -m venv $(if $(SOURCED),--system-site-packages) $(OLD) && touch $(OLD)/COLCON_IGNORE
	@# Of lz4 4.0.2 there is no wheel for Python 3.11.
	@sed -n "/'lz4/d; s/^ .*'\([A-Za-z][A-Za-z0-9]*\)>=\([0-9.]*\)[',].*/\1==\2/p" setup.py > $(OLD)/constraints.txt
	@$(OLD)/bin/python -m pip --quiet --quiet --disable-pip-version-check install \
		--constraint $(OLD)/constraints.txt --editable '.[$(if $(SOURCED),,ros,)environment]' matplotlib \
		hypothesis mcap-ros2-support mpmath pytest pytest-timeout pytest-xdist rosbags
	@touch $@

$(VENV)/.run: setup.py | $(PY)
	@echo 'Installing satdyn_ros$(if $(SOURCED), beside the sourced ROS 2, and ROS 2 Jazzy) (a minute)'
	@$(PIP) install --editable '.$(ROS)'
	@echo 'Compiling (some seconds)'
	@$(PY) -c 'from satdyn_ros import Scenario; Scenario().motion().at(0.0)'
	@touch $@

$(VENV)/.test: $(VENV)/.run
	@echo 'Installing what the tests and pictures need (a minute)'
	@$(PIP) install --editable '.[$(ALL),docs,test,dev]'
	@$(PIP) install --editable '.[readers]' || echo 'Without Orekit and other readers, whose tests are skipped'
	@touch $@

$(VENV)/.cesium: | $(PY)
	@npm install --silent --prefix $(VENV)/cesium cesium >/dev/null 2>&1 \
		|| echo 'Without CesiumJS, whose test is skipped'
	@touch $@

$(VENV)/.watch: $(VENV)/.run
	@echo 'Installing what the live page needs'
	@$(PIP) install --editable '.[watch]'
	@touch $@

$(VENV)/.bench: $(VENV)/.run
	@echo 'Installing the peers to compare with (a minute)'
	@$(PIP) install --editable '.[bench]'
	@touch $@

$(VENV)/.docs: $(VENV)/.run
	@echo 'Installing Sphinx, and what the pages of the API import (a minute)'
	@$(PIP) install --editable '.[$(ALL),docs]'
	@touch $@

$(VENV)/.release: | $(PY)
	@echo 'Installing build and twine'
	@$(PIP) install build twine
	@touch $@

$(VENV)/.colcon: $(VENV)/.run
	@echo 'Installing colcon'
	@# colcon's --symlink-install asks for an option that setuptools 80 has no more.
	@$(PIP) install colcon-common-extensions 'setuptools<80'
	@touch $@
