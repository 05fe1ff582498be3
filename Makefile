# Two commands: `make` builds, packages and unfolds the wing; `make test` checks everything.
# `make help` lists the rest.

SHELL   := /bin/sh
PYTHON  ?= python3
CARGO   ?= cargo
TARGET  := $(or $(CARGO_TARGET_DIR),target)
VENV    ?= $(TARGET)/venv
MODELS  := $(wildcard examples/models/*.toml)

MINIMUM_RUST   := $(shell sed -n 's/^rust-version *= *"\(.*\)"/\1/p' Cargo.toml)
MINIMUM_PYTHON := 3.9

VENV_PYTHON := $(VENV)/bin/python
COMMAND     := $(TARGET)/release/foldwing
FMU         := $(TARGET)/fmu/FoldingWing.fmu
TUNNEL_FMU  := $(TARGET)/fmu/folding_wing_in_tunnel.fmu
DEPLOYMENT  := $(TARGET)/deployment

.PHONY: all build package venv deploy test format lint unit pytest validate tunnel notebook aircraft bench bless robust valgrind python-lock clean help toolchain
.DEFAULT_GOAL := all

all: deploy ## Build, package, unfold the wing through FMPy

toolchain: ## Check what `make` needs
	@PYTHON="$(PYTHON)" sh tools/check_toolchain.sh "$(MINIMUM_RUST)" "$(MINIMUM_PYTHON)" "$(MAKE_VERSION)"

build: toolchain ## Build library and command, optimised
	$(CARGO) build --release --locked

package: build ## Make the FMU of every shipped model in $(TARGET)/fmu
	@mkdir -p $(TARGET)/fmu
	@set -e; for model in $(MODELS); do \
	    $(COMMAND) package $$model -o $(TARGET)/fmu/$$(basename $$model .toml).fmu; \
	done
	@cp $(TARGET)/fmu/folding_wing.fmu $(FMU)
	@echo "packaged $(FMU)"

venv: toolchain ## Create the Python environment from pinned packages
	@$(PYTHON) tools/create_venv.py $(VENV) --requirements python/requirements.txt

deploy: package venv ## Unfold the wing in still air and at 10 and 20 m/s: latch time, peak strain, CSV and plots
	@$(VENV_PYTHON) examples/deploy.py --fmu $(FMU) --tunnel $(TUNNEL_FMU) --output $(DEPLOYMENT)

test: toolchain format lint unit pytest ## Check everything

format:
	$(CARGO) fmt --check

lint: toolchain
	$(CARGO) clippy --all-targets --locked -- -D warnings

unit: toolchain
	$(CARGO) test --locked

pytest: package venv
	FOLDWING=$(abspath $(COMMAND)) FOLDWING_FMUS=$(abspath $(TARGET)/fmu) \
	    $(VENV_PYTHON) -m pytest -q tests/fmi tests/tooling $(PYTEST_ARGUMENTS)

bench: toolchain ## Measure the cost of the recursions and of other methods; docs/BENCHMARKS.md
	$(CARGO) bench --locked --bench kernels
	$(CARGO) bench --locked --bench conventional
	$(CARGO) bench --locked --bench lattice

validate: package venv ## Compare with the methods of the paper, flutter, damp the wing, unfold it in the tunnel: target/verification, docs/pictures
	$(CARGO) test --locked --test conventional -- --nocapture
	$(CARGO) test --locked --release --test coupling -- --ignored --nocapture
	$(VENV_PYTHON) tools/plot_conventional.py $(TARGET)/verification docs/pictures
	$(CARGO) test --locked --test capabilities -- --nocapture
	$(VENV_PYTHON) tools/plot_input_derivatives.py $(TARGET)/verification docs/pictures
	$(VENV_PYTHON) examples/damp_latched_wing.py --foldwing $(COMMAND) --fmu $(FMU) --picture docs/pictures/damped_latched_wing.png
	$(VENV_PYTHON) examples/fold_from_csv.py --foldwing $(COMMAND) --fmu $(FMU) --picture docs/pictures/fold_from_csv.png
	$(VENV_PYTHON) examples/soft_fold.py --foldwing $(COMMAND) --fmu $(FMU) --picture docs/pictures/soft_fold.png
	$(VENV_PYTHON) examples/gust.py --foldwing $(COMMAND) --picture docs/pictures/gust.png
	$(VENV_PYTHON) examples/identify_damping.py --fmu $(FMU) --picture docs/pictures/identified_damping.png
	$(VENV_PYTHON) tools/plot_tunnel.py --foldwing $(COMMAND) --output docs/pictures
	$(MAKE) robust

# with the checks for overflow and the assertions that a release build leaves out
robust: toolchain valgrind ## A million random calls, 30000 mutated models, a million steps, 100 killed importers
	FOLDWING_CALLS=1000000 $(CARGO) test --locked --test random_calls -- --nocapture c01
	FOLDWING_MUTATIONS=30000 $(CARGO) test --locked --test mutated_inputs -- --nocapture
	FOLDWING_STEPS=1000000 FOLDWING_KILLS=50 $(CARGO) test --locked --test endurance -- --nocapture

valgrind: toolchain ## Random calls under valgrind: no error, no leak
	FOLDWING_VALGRIND_CALLS=3000 $(CARGO) test --locked --test random_calls -- --nocapture c02

notebook: package venv ## Run examples/deployment.ipynb and store in it what it shows
	FOLDWING=$(abspath $(COMMAND)) FOLDWING_FMUS=$(abspath $(TARGET)/fmu) \
	    $(VENV_PYTHON) tools/run_notebook.py examples/deployment.ipynb

tunnel: package venv ## Change one choice of the wind tunnel at a time: docs/tables/tunnel.md, takes minutes
	$(VENV_PYTHON) tools/tunnel_study.py --foldwing $(COMMAND) --table docs/tables/tunnel.md

aircraft: package venv ## Couple two wings with an aircraft by several ways: docs/tables/aircraft.md, takes minutes
	$(VENV_PYTHON) tools/aircraft_study.py --foldwing $(COMMAND) --fmu $(FMU) --table docs/tables/aircraft.md --pictures docs/pictures

bless: toolchain ## Rewrite modelDescription/ after a deliberate change of the interface
	FOLDWING_BLESS=1 $(CARGO) test --locked --test model_description

python-lock: venv ## Renew python/requirements.txt from requirements.in
	$(VENV_PYTHON) tools/lock_python.py python/requirements.in python/requirements.txt

clean: ## Remove everything that was built
	$(CARGO) clean
	rm -rf $(VENV)

help: ## List the targets
	@sed -n 's/^\([a-z-]*\):.*## \(.*\)/\1\t\2/p' $(firstword $(MAKEFILE_LIST)) | expand -t 14
