# Two commands: `make` builds, packages and unfolds the wing; `make test` checks everything.
# `make help` lists the rest.

SHELL   := /bin/sh
PYTHON  ?= python3
CARGO   ?= cargo
TARGET  := $(or $(CARGO_TARGET_DIR),target)
VENV    ?= $(TARGET)/venv
PEERS   ?= $(TARGET)/venv-peers
DASK    ?= $(TARGET)/venv-dask
CASADI  ?= $(TARGET)/venv-casadi
OPTIONAL ?= $(TARGET)/venv-optional
IMPORTERS ?= $(TARGET)/venv-importers
SITE    ?= $(TARGET)/venv-site
RELEASE ?= $(TARGET)/venv-release
MODELS  := $(wildcard examples/models/*.toml)

MINIMUM_RUST   := $(shell sed -n 's/^rust-version *= *"\(.*\)"/\1/p' Cargo.toml)
MINIMUM_PYTHON := 3.9

# The tests need more packages than the deployment: an environment of their own keeps `make` small.
TEST_VENV   ?= $(TARGET)/venv-test
TEST_PYTHON := $(TEST_VENV)/bin/python
# The feature `import` makes bindings from the official headers with libclang, which is one of those packages.
IMPORT      := LIBCLANG_PATH="$$($(TEST_PYTHON) -c 'import clang; print(clang.__path__[0] + "/native")')" \
               BINDGEN_EXTRA_CLANG_ARGS="-I$$($(or $(CC),cc) -print-file-name=include)"
RUNNER      := $(TARGET)/runner/foldwing
PYTEST_WORKERS ?= 3
TEST_TIMES  ?= $(TARGET)/test-times

VENV_PYTHON := $(VENV)/bin/python
COMMAND     := $(TARGET)/release/foldwing
FMU         := $(TARGET)/fmu/FoldingWing.fmu
TUNNEL_FMU  := $(TARGET)/fmu/folding_wing_in_tunnel.fmu
DEPLOYMENT  := $(TARGET)/deployment
PLATFORMS   := $(TARGET)/platforms
# platforms of the libraries of `make platforms`, `make fmu-all` and `make test-platforms`; also: aarch64-linux darwin64 aarch64-darwin
FMU_PLATFORMS ?= linux64 win64
# The Python package is tested from its wheel, in an environment of its own.
PACKAGE_VENV   ?= $(TARGET)/venv-package
PACKAGE_PYTHON := $(PACKAGE_VENV)/bin/python
WHEELS         := $(TARGET)/wheels
# what `make dist` ships; `make fmu-all dist DIST_FMUS=target/fmu-all` for FMUs that run on Linux and Windows
DIST_FMUS   ?= $(TARGET)/fmu

.PHONY: audit all build check package dist venv test-venv runner deploy test long assertions format lint unit documents pytest validate validate-tests validate-random-1 validate-random-2 validate-pytest validate-figures validate-clients validate-pages validate-mutants reference differential tunnel turbine wind-tunnel notebook aircraft bench bench-own bench-sweep bench-latency bench-python bench-viewer bench-live bench-peers profile instructions linear-cost importers wasm-fmu shear-cost gradient-cost bless licenses msrv robust valgrind mutants python-lock site live-site platforms fmu-all test-platforms wheel wheels python package-venv release-check clean help toolchain
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

dist: package ## Make the archive of a release: $(TARGET)/dist/foldwing-VERSION-TARGET.tar.gz
	@$(PYTHON) tools/make_distribution.py --foldwing $(COMMAND) --fmus $(DIST_FMUS) --output $(TARGET)/dist

platforms: toolchain ## Build the libraries for Linux (glibc 2.17 and later) and Windows in $(TARGET)/platforms, for others with FMU_PLATFORMS: docs/PLATFORMS.md
	@$(PYTHON) tools/create_venv.py $(PLATFORMS)/venv --requirements python/platforms.txt
	@$(PYTHON) tools/build_platforms.py --venv $(PLATFORMS)/venv --output $(PLATFORMS) $(FMU_PLATFORMS)

wheels: wheel ## Make the Python package for Linux (manylinux2014) and Windows in $(TARGET)/platforms
	@$(PYTHON) tools/create_venv.py $(PLATFORMS)/venv --requirements python/platforms.txt
	@$(PYTHON) tools/build_platforms.py --venv $(PLATFORMS)/venv --output $(PLATFORMS) --wheels $(WHEELS)/*.whl

fmu-all: build platforms ## Make the FMUs for the platforms of FMU_PLATFORMS (Linux and Windows) in one, in $(TARGET)/fmu-all
	@mkdir -p $(TARGET)/fmu-all
	@set -e; for model in $(MODELS); do \
	    $(COMMAND) package $$model -o $(TARGET)/fmu-all/$$(basename $$model .toml).fmu \
	        $(foreach platform,$(FMU_PLATFORMS),--library $(platform)=$$(ls $(PLATFORMS)/$(platform)/*foldwing_fmu.*)); \
	done
	@echo "packaged $(words $(MODELS)) FMUs in $(TARGET)/fmu-all"

test-platforms: fmu-all package test-venv ## Check the libraries of `make fmu-all`, those for Windows and ARM64 Linux by Wine and QEMU
	FOLDWING=$(abspath $(COMMAND)) FOLDWING_FMUS=$(abspath $(TARGET)/fmu) FOLDWING_PLATFORMS=$(abspath $(PLATFORMS)) \
	    $(TEST_PYTHON) -m pytest -q -rs tests/fmi/test_platforms.py tests/fmi/test_cross_built.py $(PYTEST_ARGUMENTS)

msrv: ## Compile with the oldest Rust that Cargo.toml declares, if rustup has it
	@sh tools/check_minimum_rust.sh "$(MINIMUM_RUST)" $(TARGET)/msrv

venv: toolchain ## Create the Python environment from pinned packages
	@$(PYTHON) tools/create_venv.py $(VENV) --requirements python/requirements.txt

test-venv: toolchain
	@$(PYTHON) tools/create_venv.py $(TEST_VENV) --requirements python/requirements-test.txt

WITH_IMPORT := --release --locked --features foldwing/import

runner: test-venv build ## Build a `foldwing` that runs any FMU (feature `import`): target/runner/foldwing
	@# the second build puts the command that ships back in its place; nothing is compiled for it
	$(IMPORT) $(CARGO) build $(WITH_IMPORT) --bin foldwing
	@mkdir -p $(dir $(RUNNER)) && cp $(TARGET)/release/foldwing $(RUNNER)
	@$(CARGO) build --release --locked --quiet

deploy: package venv ## Unfold the wing without air, in air at rest and at 10 and 20 m/s: latch time, peak strain, CSV and plots
	@$(VENV_PYTHON) examples/deploy.py --fmu $(FMU) --tunnel $(TUNNEL_FMU) --output $(DEPLOYMENT)

test: toolchain format ## Check everything: what ships, as `make` built it
	@MAKE="$(MAKE)" $(PYTHON) tools/run_stages.py --times $(TEST_TIMES) test-venv+package-venv+package unit lint pytest python

# one in how many similar cases the tests of `make long` take
LONG_SHARE ?= 1

long: test-venv package-venv package runner wheel ## Run the tests that `make test` leaves out for their time; CI runs them at every landing
	@FOLDWING_SHARE=$(LONG_SHARE) CARGO="$(CARGO)" $(PYTHON) tools/run_rust_tests.py --long --times $(TEST_TIMES)/long.csv --release --locked --lib \
	    --test verification --test random --test robustness --test command
	$(MAKE) pytest PYTEST_ARGUMENTS="-m long"
	$(MAKE) python PYTEST_ARGUMENTS="-m long"

check: toolchain test-venv ## Check what is not committed, or else the last commit: format, clippy and quick tests of what it may break
	@CARGO="$(CARGO)" $(TEST_PYTHON) tools/check_changes.py $(CHECK_ARGUMENTS)

# the packages and programs of `make assertions`; CI selects some
ASSERTIONS ?=
# and one in how many similar cases their tests take
ASSERTIONS_SHARE ?= 3

assertions: test-venv ## Run the Rust tests on a build with assertions and checks for overflow, and with the feature `import`
	FOLDWING_SHARE=$(ASSERTIONS_SHARE) $(IMPORT) $(CARGO) test $(ASSERTIONS) --locked --features foldwing/import,foldwing-fmu/import --no-fail-fast

format:
	$(CARGO) fmt --check

# in the release profile, so that build scripts and macros are those of `make build`
lint: test-venv
	$(IMPORT) $(CARGO) clippy --release --workspace --all-targets --locked --features foldwing/import,foldwing-fmu/import -- -D warnings
	# with the compiler of clippy, so that rustdoc reads what the check above has written: otherwise each package is checked again
	$(IMPORT) RUSTC_WORKSPACE_WRAPPER="$$(rustc --print sysroot)/bin/clippy-driver" CLIPPY_ARGS="-D__CLIPPY_HACKERY__warnings__CLIPPY_HACKERY__" \
	    RUSTDOCFLAGS="-D warnings" $(CARGO) doc --release --no-deps --workspace --locked --quiet --features foldwing/import,foldwing-fmu/import

# CI runs `make long` too, and sets --long-follows
UNIT_ARGUMENTS ?=

# The documents quote what `foldwing run` says, which only the feature `import` compiles. `python` runs GR-82 and keeps its models.
unit: build documents
	@FOLDWING_SHARE=3 CARGO="$(CARGO)" $(PYTHON) tools/run_rust_tests.py $(UNIT_ARGUMENTS) --times $(TEST_TIMES)/rust.csv --release --locked --lib --bins --examples \
	    --test verification --test random --test robustness --test command -- --skip gr82_
	@# the engine of pages, which `make` does not build
	$(CARGO) test --release --locked --package foldwing-web
	$(CARGO) test --release --locked --doc

documents: test-venv build
	$(IMPORT) CARGO="$(CARGO)" $(PYTHON) tools/run_rust_tests.py --times $(TEST_TIMES)/documents.csv $(WITH_IMPORT) \
	    --package foldwing --package foldwing-import --lib --test documents
	@$(CARGO) build --release --locked --quiet

pytest: package runner
	FOLDWING=$(abspath $(COMMAND)) FOLDWING_FMUS=$(abspath $(TARGET)/fmu) FOLDWING_RUNNER=$(abspath $(RUNNER)) \
	    FOLDWING_PLATFORMS=$(abspath $(PLATFORMS)) FOLDWING_SITE=$(abspath $(SITE)) \
	    FOLDWING_LIVE=$(abspath $(TARGET)/live) \
	    $(TEST_PYTHON) -m pytest -q -n $(PYTEST_WORKERS) --dist loadfile --junitxml=$(TEST_TIMES)/fmi.xml tests/fmi tests/tooling $(PYTEST_ARGUMENTS)

package-venv: toolchain
	@$(PYTHON) tools/create_venv.py $(PACKAGE_VENV) --requirements python/requirements-package.txt

wheel: build package-venv ## Build the Python package for this machine: $(TARGET)/wheels; `pip install .` does the same
	@rm -rf $(WHEELS)
	PATH="$(abspath $(PACKAGE_VENV))/bin:$$PATH" CARGO="$(CARGO)" FOLDWING_LIBRARY="$(abspath $(firstword $(wildcard $(TARGET)/release/*foldwing_fmu.so $(TARGET)/release/*foldwing_fmu.dylib)))" \
	    $(PACKAGE_PYTHON) -m pip wheel --quiet --no-deps --no-build-isolation --wheel-dir $(WHEELS) .

python: wheel ## Test the Python package from its wheel: what it computes, its documentation, its types
	@$(PACKAGE_PYTHON) -m pip install --quiet --no-deps --force-reinstall $(WHEELS)/*.whl
	@rm -rf $(TARGET)/gradients
	FOLDWING_MACHINES=12 FOLDWING_MODELS=$(abspath $(TARGET)/gradients) $(CARGO) test --locked --release --test random -- --quiet gr82_
	FOLDWING=$(abspath $(COMMAND)) FOLDWING_GRADIENTS=$(abspath $(TARGET)/gradients) $(abspath $(PACKAGE_PYTHON)) -m pytest -q --junitxml=$(abspath $(TEST_TIMES))/python.xml tests/python $(PYTEST_ARGUMENTS)

release-check: wheel test-venv ## Check what a release uploads: every crate builds from its archive, the wheels pass twine; minutes, needs the network
	@$(PYTHON) tools/create_venv.py $(RELEASE) --requirements python/requirements-release.txt
	$(IMPORT) $(CARGO) package --workspace --locked --exclude foldwing-benches --exclude foldwing-python --exclude foldwing-web --target-dir $(TARGET)/release-check $(RELEASE_ARGUMENTS)
	@$(PYTHON) tools/check_release.py --crates $(TARGET)/release-check/package --wheels $(WHEELS) $(wildcard $(PLATFORMS)/*.whl)
	$(RELEASE)/bin/twine check --strict $(WHEELS)/*.whl $(wildcard $(PLATFORMS)/*.whl)

bench: bench-own bench-sweep bench-latency bench-python bench-viewer bench-peers ## Measure the cost of everything and compare with other programs; docs/BENCHMARKS.md

bench-own: build ## Measure the recursions, the C functions, memory, other methods and the lattice
	$(CARGO) bench --locked --bench kernels
	$(CARGO) bench --locked --bench calls
	$(CARGO) bench --locked --bench memory
	$(CARGO) bench --locked --bench conventional
	$(CARGO) bench --locked --bench lattice
	$(CARGO) bench --locked --bench gradient
	@$(PYTHON) studies/lattice_cost.py --foldwing $(COMMAND)

profile: toolchain ## Count the instructions of the deployment by part of the program; needs valgrind
	CARGO_PROFILE_RELEASE_STRIP=none CARGO_PROFILE_RELEASE_DEBUG=1 \
	    $(CARGO) build --release --locked --bin foldwing --target-dir $(TARGET)/profile
	@$(PYTHON) tools/profile_run.py --foldwing $(TARGET)/profile/release/foldwing \
	    --output gauge.root.strain --output fold.latch_time
	@$(PYTHON) tools/profile_run.py --foldwing $(TARGET)/profile/release/foldwing \
	    --model examples/models/folding_wing_constant.toml --output gauge.root.strain --output fold.latch_time

instructions: build ## Count the instructions of typical work beside another build: BASELINE=path/to/foldwing; needs valgrind
	@$(PYTHON) tools/count_instructions.py --foldwing $(COMMAND) --baseline $(BASELINE)

shear-cost: toolchain ## Count the instructions of an element with shear beside one without; needs valgrind
	$(CARGO) build --release --locked --package foldwing-engine --example shear_cost
	@$(PYTHON) tools/shear_cost.py --program $(TARGET)/release/examples/shear_cost

gradient-cost: toolchain ## Count the instructions of gradients of the shipped wing's run; needs valgrind
	$(CARGO) build --release --locked --package foldwing-engine --example gradient_cost
	@$(PYTHON) tools/gradient_cost.py --program $(TARGET)/release/examples/gradient_cost

linear-cost: build ## Count the instructions of random machines with more and more elements: the cost is linear; needs valgrind
	FOLDWING_MACHINES=40 FOLDWING_MODELS=$(abspath $(TARGET)/linear-cost) $(CARGO) test --locked --test random -- writes_model_files
	@$(PYTHON) tools/linear_cost.py --foldwing $(COMMAND) --models $(TARGET)/linear-cost

bench-sweep: build ## Measure variants per second of `foldwing sweep` with one thread and two
	@$(PYTHON) studies/sweep_throughput.py --foldwing $(COMMAND)

bench-latency: build ## Measure single steps of 1 ms in real-time mode under turbulence; alone on its core where the system permits
	@for model in folding_wing folding_wing_constant; do \
	  { cat examples/models/$$model.toml; printf '\n[solver]\nmode = "real_time"\n'; } > $(TARGET)/$$model-real-time.toml; \
	  echo "$$model"; \
	  $$(chrt -f 80 true 2>/dev/null && echo chrt -f 80) $(COMMAND) latency $(TARGET)/$$model-real-time.toml --paced; \
	done

bench-python: wheel ## Measure what Python costs beside the command and the engine, and the gain of a sweep on two cores
	@$(PACKAGE_PYTHON) -m pip install --quiet --no-deps --force-reinstall $(WHEELS)/*.whl
	@$(PACKAGE_PYTHON) studies/python_cost.py --foldwing $(COMMAND)

bench-viewer: build venv ## Measure painting times, draw calls and triangles of the page of `--view`; needs Chromium
	@$(VENV_PYTHON) studies/painting_time.py --foldwing $(COMMAND)

bench-live: live-site test-venv ## Measure times from a key to the picture in the pages that run models; needs Chromium and Node
	@$(TEST_PYTHON) studies/live_times.py --live $(TARGET)/live

bench-peers: build ## Compare with Exudyn and Ptera Software in turn: docs/tables/exudyn.md, takes minutes
	@$(PYTHON) tools/create_venv.py $(PEERS) --requirements python/requirements-peers.txt
	$(PEERS)/bin/python studies/compare_exudyn.py --foldwing $(COMMAND)
	$(PEERS)/bin/python studies/compare_lattice.py
	$(PEERS)/bin/python studies/plot_lattice_cost.py --foldwing $(COMMAND)

# Each stage can be run by itself, `make validate STAGES=validate-random-1`: the table keeps the last run of each.
STAGES ?= validate-tests validate-chains long assertions validate-random-1 validate-random-2 validate-pytest validate-figures validate-clients validate-pages robust validate-mutants

validate: toolchain ## Run everything: whole studies, 2000 random models, all figures, the list of faults; hours. docs/tables/validate.md has its last results
	@MAKE="$(MAKE)" $(PYTHON) tools/run_stages.py --times $(TARGET)/validate-times --keep-going --record docs/tables/validate.md $(STAGES)

validate-tests: package
	@rm -f $(TARGET)/agreement.csv
	FOLDWING_WHOLE=1 FOLDWING_AGREEMENT=$(abspath $(TARGET))/agreement.csv $(CARGO) test --locked --release --test verification --test command -- --nocapture --include-ignored --skip p122_
	@$(PYTHON) studies/agreement.py --rows $(TARGET)/agreement.csv --table docs/tables/agreement.md
	@$(PYTHON) studies/structure.py --table docs/tables/structure.md

# an hour on two cores
validate-chains: toolchain
	$(CARGO) test --locked --release --test verification -- --nocapture --include-ignored p122_

validate-random-1: toolchain
	FOLDWING_MACHINES=1000 $(CARGO) test --locked --release --test random -- --nocapture

validate-random-2: toolchain
	FOLDWING_MACHINES=1000..2000 $(CARGO) test --locked --release --test random -- --nocapture

validate-pytest: package
	FOLDWING_WHOLE=1 $(MAKE) pytest

validate-figures: package venv wheel
	$(VENV_PYTHON) studies/dependences.py --foldwing $(COMMAND) --table docs/tables/dependences.md
	$(VENV_PYTHON) studies/output_convergence.py --foldwing $(COMMAND) --table docs/tables/outputs.md --csv $(TARGET)/verification/outputs.csv
	$(VENV_PYTHON) studies/plot_conventional.py $(TARGET)/verification docs/pictures
	$(VENV_PYTHON) studies/plot_input_derivatives.py $(TARGET)/verification docs/pictures
	$(VENV_PYTHON) examples/damp_latched_wing.py --foldwing $(COMMAND) --fmu $(FMU) --picture docs/pictures/damped_latched_wing.png
	$(VENV_PYTHON) examples/damp_wing_in_tunnel.py --foldwing $(COMMAND) --fmu $(TUNNEL_FMU) --picture docs/pictures/damped_wing_in_tunnel.png
	$(VENV_PYTHON) examples/fold_from_csv.py --foldwing $(COMMAND) --fmu $(FMU) --picture docs/pictures/fold_from_csv.png
	$(VENV_PYTHON) examples/soft_fold.py --foldwing $(COMMAND) --fmu $(FMU) --picture docs/pictures/soft_fold.png
	$(VENV_PYTHON) examples/gust.py --foldwing $(COMMAND) --picture docs/pictures/gust.png
	$(VENV_PYTHON) examples/identify_damping.py --fmu $(FMU) --picture docs/pictures/identified_damping.png
	$(VENV_PYTHON) studies/plot_models.py --foldwing $(COMMAND) --output docs/pictures
	$(VENV_PYTHON) studies/plot_failures.py --foldwing $(COMMAND) --output docs/pictures
	$(VENV_PYTHON) studies/pitch_link_study.py --foldwing $(COMMAND) --output docs/pictures --table docs/tables/pitch_link.md
	$(VENV_PYTHON) studies/pitch_link_5mw_study.py --foldwing $(COMMAND) --output docs/pictures --table docs/tables/pitch_link_5mw.md
	@$(PACKAGE_PYTHON) -m pip install --quiet --no-deps --force-reinstall $(WHEELS)/*.whl
	$(PACKAGE_PYTHON) studies/identify_wing.py --table $(TARGET)/verification/identification.md
	$(PACKAGE_PYTHON) studies/plot_tutorial.py --foldwing $(COMMAND) --output docs/pictures
	$(VENV_PYTHON) studies/picture_models.py --foldwing $(COMMAND) --output docs/pictures/models
	$(VENV_PYTHON) studies/plot_tunnel.py --foldwing $(COMMAND) --output docs/pictures
	$(VENV_PYTHON) studies/shoot_viewer.py --foldwing $(COMMAND) --output docs/pictures

validate-clients: package wheel
	@$(PYTHON) tools/create_venv.py $(DASK) --requirements python/requirements-dask.txt
	$(DASK)/bin/python examples/sweep_dask.py --fmu $(FMU) --foldwing $(COMMAND)
	@$(PYTHON) tools/create_venv.py $(CASADI) --requirements python/requirements-casadi.txt
	$(CASADI)/bin/python examples/fastest_unfolding.py --foldwing $(COMMAND) --twice --picture docs/pictures/fastest_unfolding.png
	$(CASADI)/bin/python studies/casadi_model_exchange.py --foldwing $(COMMAND)
	FOLDWING_WHOLE=1 FOLDWING=$(abspath $(COMMAND)) $(CASADI)/bin/python -m pytest -q tests/fmi/test_casadi.py
	$(CASADI)/bin/python studies/model_exchange_integrators.py --foldwing $(COMMAND) --table docs/tables/model_exchange.md
	@$(PYTHON) tools/create_venv.py $(OPTIONAL) --requirements python/requirements-optional.txt
	@$(OPTIONAL)/bin/python -m pip install --quiet --no-deps --force-reinstall $(WHEELS)/*.whl
	FOLDWING=$(abspath $(COMMAND)) $(OPTIONAL)/bin/python -m pytest -q -rs tests/python/test_differentiable.py \
	    tests/python/test_run.py::test_films_are_decoded_with_their_length

# Apart from the other tests, which run without a compiler for WebAssembly: where there is none, this stage alone fails, and names the packages.
validate-pages: live-site
	@command -v node >/dev/null || { echo "node is not installed (Debian: nodejs): it runs the engine of pages without a browser"; exit 1; }
	$(MAKE) pytest PYTEST_ARGUMENTS="-rs -k live_site"

# The matrix of all faults, MUTANTS_ARGUMENTS=--matrix, runs each test once per fault that it reaches.
validate-mutants: toolchain
	$(MAKE) mutants
	$(MAKE) mutants MUTANTS_ARGUMENTS="--as-built --matrix --draw 10"

REFERENCE_COMMIT ?= 45f5929
REFERENCE        := $(TARGET)/reference/$(REFERENCE_COMMIT)/foldwing

$(REFERENCE):
	@rm -rf $(TARGET)/reference/source && mkdir -p $(TARGET)/reference/source $(dir $(REFERENCE))
	git archive $(REFERENCE_COMMIT) | tar -x -C $(TARGET)/reference/source
	$(CARGO) build --release --locked -p foldwing-command -p foldwing-fmu --manifest-path $(TARGET)/reference/source/Cargo.toml --target-dir $(TARGET)/reference/build
	@cp $(TARGET)/reference/build/release/libfoldwing_fmu.so $(dir $(REFERENCE)) # beside the command: it packages FMUs
	@cp $(TARGET)/reference/build/release/foldwing $(REFERENCE)

reference: toolchain $(REFERENCE) ## Build the command of an earlier commit once: $(TARGET)/reference; REFERENCE_COMMIT names another

differential: build reference ## Run shipped and 200 random models with the command of the earlier commit and with this one: target/differential.csv, .md
	FOLDWING_MACHINES=200 FOLDWING_MODELS=$(abspath $(TARGET)/differential/models) $(CARGO) test --locked --test random -- writes_model_files
	@$(PYTHON) tools/differential.py --old $(REFERENCE) --new $(COMMAND) --models $(TARGET)/differential/models --output $(TARGET)/differential

audit: build venv ## Repeat the audit of physics and numerics: studies/audit, docs/validation/audit.md
	@set -e; for script in $(filter-out %/machine.py,$(wildcard studies/audit/*.py)); do \
	    echo "== $$script"; FOLDWING=$(abspath $(COMMAND)) $(abspath $(VENV_PYTHON)) $$script; \
	done

importers: build ## Have importers that are not ours run the shipped models: docs/tables/importers.md
	$(CARGO) build --release --locked --manifest-path tools/second_importer/Cargo.toml --target-dir $(TARGET)/second_importer
	@$(PYTHON) tools/create_venv.py $(IMPORTERS) --requirements python/requirements-importers.txt
	@$(PYTHON) studies/importers.py --foldwing $(COMMAND) --second-importer $(TARGET)/second_importer/release/second_importer \
	    --python $(IMPORTERS)/bin/python --table docs/tables/importers.md

wasm-fmu: build ## FMUs with the WebAssembly component of FMI-LS-WASM in wasmtime, beside the native library: docs/tables/wasm_component.md
	@$(PYTHON) tools/create_venv.py $(IMPORTERS) --requirements python/requirements-importers.txt
	@$(PYTHON) studies/wasm_component.py --foldwing $(COMMAND) --python $(IMPORTERS)/bin/python --cargo "$(CARGO)" --target $(TARGET)/wasm_fmu \
	    --table docs/tables/wasm_component.md

# with the checks for overflow and the assertions that a release build leaves out; a single step may take its 10⁶ internal
# steps, a minute and more in this build
robust: toolchain valgrind ## A million random calls on each face, 30000 mutated models, a million steps, 100 killed importers
	FOLDWING_CALLS=1000000 FOLDWING_WATCHDOG=900 $(CARGO) test --locked --test robustness -- --nocapture --skip valgrind random_calls::
	FOLDWING_MUTATIONS=30000 $(CARGO) test --locked --test robustness -- --nocapture mutated_inputs::
	FOLDWING_STEPS=1000000 FOLDWING_KILLS=50 $(CARGO) test --locked --test robustness -- --nocapture endurance::

valgrind: toolchain ## Random calls on each face under valgrind: no error, no leak
	FOLDWING_VALGRIND_CALLS=3000 $(CARGO) test --locked --test robustness -- --nocapture --include-ignored rc02

# in a folder of its own: what is shipped has no switches. MUTANTS_ARGUMENTS: numbers of faults, --find, --matrix
mutants: toolchain test-venv ## Plant small faults in a copy of the sources, one at a time: each has to be found by its test
	$(IMPORT) $(TEST_PYTHON) tools/mutants.py --cargo "$(CARGO)" --target $(TARGET) --features import $(MUTANTS_ARGUMENTS)

notebook: package venv ## Run examples/deployment.ipynb and store in it what it shows
	FOLDWING=$(abspath $(COMMAND)) FOLDWING_FMUS=$(abspath $(TARGET)/fmu) \
	    $(VENV_PYTHON) tools/run_notebook.py examples/deployment.ipynb

tunnel: package venv ## Change one choice of the wind tunnel at a time: docs/tables/tunnel.md, takes minutes
	$(VENV_PYTHON) studies/tunnel_study.py --foldwing $(COMMAND) --table docs/tables/tunnel.md

wind-tunnel: build venv ## Wings that were measured, at every measured point: docs/tables/wind_tunnel.md, docs/pictures; takes minutes
	nice $(VENV_PYTHON) studies/wind_tunnel_study.py --foldwing $(COMMAND) --output $(TARGET)/wind_tunnel --table docs/tables/wind_tunnel.md
	$(VENV_PYTHON) studies/plot_wind_tunnel.py --points $(TARGET)/wind_tunnel/points.json --output docs/pictures

aircraft: package venv ## Couple two wings with an aircraft by several ways: docs/tables/aircraft.md, takes minutes
	$(VENV_PYTHON) studies/aircraft_study.py --foldwing $(COMMAND) --fmu $(FMU) --table docs/tables/aircraft.md --pictures docs/pictures

turbine: build venv ## Close the loop around the turbine's FMU for ten minutes, find its operating points, draw its Campbell diagram, reduce it as the paper does, time its steps
	@mkdir -p $(TARGET)/campbell
	$(VENV_PYTHON) examples/turbine/closed_loop.py --foldwing $(COMMAND) --picture docs/pictures/turbine_closed_loop.png
	$(VENV_PYTHON) examples/turbine/closed_loop.py --foldwing $(COMMAND) --points --table docs/tables/turbine.md
	$(COMMAND) modes examples/turbine/nrel_5mw.toml --state undeformed --vary rotor_speed_rpm=0:18:19 --count 13 \
	    --plot $(TARGET)/campbell --csv $(TARGET)/campbell/campbell.csv
	cp $(TARGET)/campbell/campbell.png docs/pictures/campbell.png
	$(VENV_PYTHON) studies/reduced_turbine_study.py --foldwing $(COMMAND) --table docs/tables/reduced_turbine.md --output docs/pictures
	$(VENV_PYTHON) examples/turbine/closed_loop.py --foldwing $(COMMAND) --real-time $(TARGET)/turbine_real_time.toml
	$(COMMAND) latency $(TARGET)/turbine_real_time.toml --steps 100000 --step 5e-3

# what the tests of the site build it with
site-venv:
	@$(PYTHON) tools/create_venv.py $(SITE) --requirements python/requirements-site.txt

site: site-venv ## Build the documentation with typeset equations in $(TARGET)/site: it opens from the disk and loads nothing from a network
	@$(SITE)/bin/python tools/build_site.py --output $(TARGET)/site --rustdoc $(TARGET)/doc --live $(TARGET)/live

live-site: toolchain ## Compile the engine as WebAssembly in $(TARGET)/live, so that models run in the pages of `make site`
	@CARGO="$(CARGO)" $(PYTHON) tools/live_site.py --output $(TARGET)/live --target $(TARGET)/wasm

bless: toolchain ## Rewrite modelDescription/, the schema and the pages written from the program, after a deliberate change
	FOLDWING_BLESS=1 $(CARGO) test --locked --test robustness --test documents --no-fail-fast -- model_file:: model_description:: guide::
	$(PYTHON) tools/name_table.py

licenses: toolchain ## Renew licenses/THIRD_PARTY.txt after a change of Cargo.lock
	CARGO="$(CARGO)" $(PYTHON) tools/collect_licenses.py

python-lock: venv ## Renew the pinned requirements in python/ from the .in files
	$(VENV_PYTHON) tools/lock_python.py python/requirements.in python/requirements.txt
	$(VENV_PYTHON) tools/lock_python.py python/requirements-test.in python/requirements-test.txt
	$(VENV_PYTHON) tools/lock_python.py python/requirements-package.in python/requirements-package.txt 3.10
	$(VENV_PYTHON) tools/lock_python.py python/requirements-peers.in python/requirements-peers.txt 3.11
	$(VENV_PYTHON) tools/lock_python.py python/platforms.in python/platforms.txt
	$(VENV_PYTHON) tools/lock_python.py python/requirements-dask.in python/requirements-dask.txt 3.10
	$(VENV_PYTHON) tools/lock_python.py python/requirements-importers.in python/requirements-importers.txt 3.11
	$(VENV_PYTHON) tools/lock_python.py python/requirements-casadi.in python/requirements-casadi.txt 3.10
	$(VENV_PYTHON) tools/lock_python.py python/requirements-optional.in python/requirements-optional.txt 3.11
	$(VENV_PYTHON) tools/lock_python.py python/requirements-site.in python/requirements-site.txt 3.11
	$(VENV_PYTHON) tools/lock_python.py python/requirements-release.in python/requirements-release.txt 3.10

clean: ## Remove everything that was built
	$(CARGO) clean
	rm -rf $(VENV)

help: ## List the targets
	@sed -n 's/^\([a-z-]*\):.*## \(.*\)/\1\t\2/p' $(firstword $(MAKEFILE_LIST)) | expand -t 14
