# The daily commands. CI calls the same names and nothing else. `make help` lists them.
# Everything is built inside the clone; only Chromium (for the page's tests) is installed from the system's packages.

SHELL := bash
.SHELLFLAGS := -euo pipefail -c
.DEFAULT_GOAL := help
MAKEFLAGS += --no-builtin-rules

MISSION ?= western-states
# Flown, replayed and verified by `make flights`. `two-crew` is flown by tests of the command line and of the server: it ends when all of its
# agents are done, and not with the task of one.
MISSIONS := first-picture stand-off diagnosis structure-watch pipeline-inspection day-and-night western-states
SEED ?= 1
ROUNDS ?= 20
# Random worlds with about 13 trips each: a million trips that must not enter a zone.
TRAVEL_WORLDS ?= 100000
CARGO_CYCLONEDX := 0.5.9
# Tools of the LLVM that rustc has, for coverage: of rustup (llvm-tools) or of the system.
LLVM_TOOLS := $(wildcard $(shell rustc --print sysroot)/lib/rustlib/*/bin)
LLVM_COV ?= $(or $(wildcard $(LLVM_TOOLS)/llvm-cov),$(shell command -v llvm-cov-22))
LLVM_PROFDATA ?= $(or $(wildcard $(LLVM_TOOLS)/llvm-profdata),$(shell command -v llvm-profdata-22))
# Packages whose tests count for coverage; COVERAGE_PACKAGES="--package apex-executive .." measures fewer.
COVERAGE_PACKAGES ?= --workspace --exclude apex-benches
# Seeds of random mistakes of authors in `make nightly`: 200 mistakes each.
MISTAKE_SEEDS ?= 7002 7003 7004 7005 7006 7007 7008 7009 7010
# Seconds for each fuzz target; a planted bug must be found within FUZZ_PLANTED_SECONDS.
FUZZ_SECONDS ?= 60
FUZZ_PLANTED_SECONDS ?= 300
FUZZ_TARGETS := pdl inputs mission logs problems benchmarks records protocol http
# What libFuzzer needs to see of the code: edges and compared values. Only flags of the stable toolchain.
FUZZ_FLAGS := -Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=4 -Cllvm-args=-sanitizer-coverage-inline-8bit-counters \
  -Cllvm-args=-sanitizer-coverage-pc-table -Cllvm-args=-sanitizer-coverage-trace-compares -Cdebug-assertions -Coverflow-checks
# With `--target` the flags do not reach build scripts and macros of the compiler.
FUZZ_HOST := $(shell rustc -vV | sed -n 's/^host: //p')
FUZZ_BUILD = RUSTFLAGS="$(FUZZ_FLAGS)" cargo build --locked --quiet $(CI_PROFILE) --target $(FUZZ_HOST) --package apex-fuzz --bin apex-fuzz
# What has property tests.
PROPERTIES := $(addprefix --package apex-,model pdl executive geo metrics planning solvers portfolio logs)
# Newest version that the toolchain of this repository compiles.
CARGO_DENY := 0.20.2
TARGET := $(or $(CARGO_TARGET_DIR),target)
APEX := $(TARGET)/release/apex
# Tests run with release-like speed and with assertions on; one profile for lints, tests and flights, built once.
CI_PROFILE := --profile ci
# One selection of packages for tests, the command and the Python module: with another one, features of third parties
# differ and half of the workspace is compiled again.
CI_SELECTION := --workspace
# Lints come from the build: clippy's driver compiles the packages of the workspace, so that nothing is compiled for lints alone.
# It leaves programs of tests unoptimised.
CI_LINTS := RUSTC_WORKSPACE_WRAPPER=$(abspath .ci/driver) CLIPPY_ARGS=-D__CLIPPY_HACKERY__warnings__CLIPPY_HACKERY__
CI_CARGO := $(CI_LINTS) cargo
CI_BUILD := $(CI_CARGO) build --locked --quiet $(CI_PROFILE) $(CI_SELECTION) --lib --tests --examples --bench '*' --bin xtask
# Without a test, a build leaves out the features that tests ask of third parties, and these are compiled twice.
CI_SMALL_TEST := files
CI_APEX := $(TARGET)/ci/apex
# In the profile of all else: `cargo xtask` would compile its packages for development, too.
CI_XTASK := $(TARGET)/ci/xtask
FLIGHTS := $(TARGET)/flights
# Tests that write rows of the quality page.
MEASURED = APEX_QUALITY_FOLDER=$(abspath $(TARGET)/quality)
RECORD ?= $(MISSION).apex
EXTREMITY = $(TARGET)/extremity/bin/python -W ignore benches/peers/extremity_peer.py
WEB_SOURCES := $(shell find web -type f -not -path '*/node_modules/*' -not -path '*/dist/*' -not -path '*/test-results/*' -not -path '*/tests/*' 2>/dev/null)

.PHONY: audit coverage fuzz fuzz-planted help quality sbom build fly test quick check web python wheel bench bench-door bench-orienteering bench-planners bench-units bench-curves bench-hand-off bench-travel golden-travel spec sim properties deny nightly clean
# Not part of `test`: the pictures are committed, and times need a quiet machine.
.PHONY: pictures bench-page bench-record
.PHONY: rust-lints rust-tests web-checks web-tests python-checks python-tests flights page-tests chromium

help: ## List the commands.
	@grep -hE '^[a-z-]+:.*## ' $(MAKEFILE_LIST) | sed -E 's/^([a-z-]+):.*## (.*)/  make \1\t\2/' | expand -t 18

build: web ## Build the command with its web page: target/release/apex.
	cargo build --locked --release --package apex-cli

fly: build ## Fly MISSION=western-states and record it; OPEN=1 then shows it in Sherpa.
	$(APEX) fly missions/$(MISSION) --record $(RECORD)
	@if [ -n "$(OPEN)" ]; then $(APEX) serve $(RECORD) --open; \
	else echo "Look at it: $(APEX) serve $(RECORD)   or ask: $(APEX) trace $(RECORD) --type transition"; fi

quick: ## Check and test what the present change needs: format, rules of the repository, lints, tests of changed packages; dev profile.
	cargo xtask quick

check: rust-lints web-checks python-checks ## Format, lints, house rules; nothing is run.

test: ## Everything that CI runs: check, tests, spec pages, the Python package, flights with replay, the page in a browser.
	$(MAKE) --jobs=2 --output-sync=target web rust-rules
	# The browser and the tools of Python are fetched while the workspace is compiled.
	$(MAKE) --jobs=2 --output-sync=target rust-build web-checks web-tests chromium .venv/.tools
	# The flights fill the processor time that the last long tests leave.
	$(MAKE) --jobs=2 --output-sync=target rust-tests flights
	# The page's tests mostly wait for the browser; the checks of Python need one processor.
	$(MAKE) --jobs=2 --output-sync=target python-package page-tests

spec: ## Run the specification pages; UPDATE=1 rewrites their expected traces (review the diff).
	UPDATE=$(UPDATE) $(CI_CARGO) test --locked $(CI_PROFILE) --package apex-spec

bench: .venv/.peers ## Measure latency, throughput and load time; peers beside it in the same run, against the bars.
	rm -rf $(TARGET)/criterion $(TARGET)/bench-rows
	APEX_BENCH_ROWS=$(abspath $(TARGET))/bench-rows cargo bench --locked --package apex-benches
	APEX_BENCH_ROWS=$(abspath $(TARGET))/bench-rows cargo run --locked --quiet --release --package apex-benches --bin memory
	.venv/bin/python benches/peers/py_trees_peer.py > $(TARGET)/py_trees.json
	cargo run --locked --quiet --release --package apex-benches --bin report -- $(TARGET)/criterion $(TARGET)/bench-rows $(TARGET)/py_trees.json
	cargo run --locked --quiet --release --package apex-benches --bin monitoring -- traces $(TARGET)/monitoring-traces
	.venv/bin/python benches/peers/monitoring_peers.py $(TARGET)/monitoring-traces > $(TARGET)/monitoring-peers.json
	cargo run --locked --quiet --release --package apex-benches --bin monitoring -- report $(TARGET)/monitoring-peers.json

bench-orienteering: .venv/.peers ## Plan orienteering beside PyVRP and OR-Tools at equal processor time: about ten minutes of processor time.
	rm -rf $(TARGET)/orienteering
	cargo run --locked --quiet --release --package apex-benches --bin orienteering -- problems $(TARGET)/orienteering
	.venv/bin/python benches/peers/orienteering_peers.py $(TARGET)/orienteering pyvrp 1 10 > $(TARGET)/orienteering/pyvrp.json
	.venv/bin/python benches/peers/orienteering_peers.py $(TARGET)/orienteering ortools 1 10 > $(TARGET)/orienteering/ortools.json
	cargo run --locked --quiet --release --package apex-benches --bin orienteering -- ours 1 10 40 > $(TARGET)/orienteering/ours.json
	cargo run --locked --quiet --release --package apex-benches --bin orienteering -- report $(TARGET)/orienteering
	cargo run --locked --quiet --release --package apex-benches --bin orienteering -- proven 1 10

bench-door: ## Measure the wait of an operator's messages at the live port under 150,000 valid and 150,000 malformed lines a second.
	cargo build --locked --quiet --release --package apex-cli
	cargo run --locked --quiet --release --package apex-benches --bin live_door -- $(abspath $(APEX))

bench-planners: ## Planners of surveillance on missions FROM to TO - 1 of all 243 cells, a CPU second each: five minutes a mission.
	cargo run --locked --quiet --release --package apex-benches --bin planners -- pairs $(or $(FROM),0) $(or $(TO),1) 1000 1000 \
		> benches/data/pairs-$(or $(FROM),0)-$(or $(TO),1).csv
	cargo run --locked --quiet --release --package apex-benches --bin planners -- tally benches/data/pairs-*.csv

bench-travel: $(TARGET)/extremity/.installed ## Travel matrices among zones, beside extremitypathfinder: about two minutes of processor time.
	cargo run --locked --quiet --release --package apex-benches --bin travel -- world $(TARGET)/extremity/world.txt
	$(EXTREMITY) matrix $(TARGET)/extremity/world.txt > $(TARGET)/extremity/peer.json
	cargo run --locked --quiet --release --package apex-benches --bin travel -- report $(TARGET)/extremity/peer.json

golden-travel: $(TARGET)/extremity/.installed ## Ask extremitypathfinder for the committed lengths of shortest ways again.
	$(EXTREMITY) check crates/geo/src/travel/golden/extremity.txt

bench-units: ## What a unit of work takes: every planner, from 10 to 1,000 targets.
	cargo run --locked --quiet --release --package apex-benches --bin units

bench-hand-off: ## Hand-offs of a resource among 1,000 competitors of each kind: a table for docs/reference/executive-speed.md.
	cargo run --locked --quiet --release --package apex-benches --bin hand_off -- 1000

bench-curves: ## Value against processor time for all planners, and growth with targets: data and picture of docs/pictures/anytime-curves.
	cargo run --locked --quiet --release --package apex-benches --bin curves -- measure docs/pictures/anytime-curves.csv
	cargo run --locked --quiet --release --package apex-benches --bin curves -- draw docs/pictures/anytime-curves.csv docs/pictures/anytime-curves.svg

sim: $(CI_APEX) ## Fly all missions in the world of SEED=n and replay each.
	$(call fly_all,$(CI_APEX),$(FLIGHTS)/seed-$(SEED),--seed $(SEED))

properties: ## Run the property tests with ROUNDS=20 seeds of their own; a failure prints its case and its seed repeats it.
	for round in $$(seq $(ROUNDS)); do \
	  seed=$$(od -An -N4 -tu4 /dev/urandom | tr -d ' '); echo "PROPTEST_RNG_SEED=$$seed"; \
	  PROPTEST_RNG_SEED=$$seed $(CI_CARGO) test --locked --quiet $(CI_PROFILE) $(PROPERTIES); \
	done

deny: ## Check licences, sources, doubled versions and, where their database can be reached, advisories of third-party packages.
	cargo install --quiet --locked --root $(TARGET)/tools cargo-deny@$(CARGO_DENY)
	$(TARGET)/tools/bin/cargo-deny --locked check licenses bans sources
	if $(TARGET)/tools/bin/cargo-deny --locked fetch db; then $(TARGET)/tools/bin/cargo-deny --locked check --disable-fetch advisories; \
	else echo "The database of advisories cannot be reached: advisories are not checked."; fi

fuzz: ## Fuzz each target for FUZZ_SECONDS=60 from its corpus; counts go to target/fuzz/executions.tsv. Needs a C++ compiler.
	$(FUZZ_BUILD) --features libfuzzer --target-dir $(TARGET)/fuzz
	mkdir -p $(TARGET)/fuzz/new && rm -f $(TARGET)/fuzz/executions.tsv
	for target in $(FUZZ_TARGETS); do \
	  mkdir -p $(TARGET)/fuzz/new/$$target $(TARGET)/fuzz/artifacts; \
	  APEX_FUZZ_TARGET=$$target $(TARGET)/fuzz/$(FUZZ_HOST)/ci/apex-fuzz $(TARGET)/fuzz/new/$$target fuzz/corpus/$$target \
	    $$([ -f fuzz/dictionaries/$$target.dict ] && echo -dict=fuzz/dictionaries/$$target.dict) -max_total_time=$(FUZZ_SECONDS) \
	    -timeout=20 -rss_limit_mb=4096 -artifact_prefix=$(TARGET)/fuzz/artifacts/$$target- -print_final_stats=1 > $(TARGET)/fuzz/$$target.log 2>&1 \
	    || { tail -n 40 $(TARGET)/fuzz/$$target.log; echo "fuzz target $$target: repeat it with apex-fuzz $$target FILE"; exit 1; }; \
	  printf '%s\t%s\n' $$target $$(sed -n 's/^stat::number_of_executed_units: *//p' $(TARGET)/fuzz/$$target.log) >> $(TARGET)/fuzz/executions.tsv; \
	done
	cat $(TARGET)/fuzz/executions.tsv

fuzz-planted: ## Show that each fuzz target finds the bug planted in it.
	$(FUZZ_BUILD) --features libfuzzer,planted-bugs --target-dir $(TARGET)/fuzz-planted
	mkdir -p $(TARGET)/fuzz-planted/artifacts
	for target in $(FUZZ_TARGETS); do \
	  begin=$$(date +%s); \
	  if APEX_FUZZ_TARGET=$$target $(TARGET)/fuzz-planted/$(FUZZ_HOST)/ci/apex-fuzz fuzz/corpus/$$target -runs=-1 \
	    $$([ -f fuzz/dictionaries/$$target.dict ] && echo -dict=fuzz/dictionaries/$$target.dict) -max_total_time=$(FUZZ_PLANTED_SECONDS) \
	    -artifact_prefix=$(TARGET)/fuzz-planted/artifacts/$$target- > $(TARGET)/fuzz-planted/$$target.log 2>&1; \
	  then echo "fuzz target $$target: the planted bug was not found"; exit 1; \
	  else echo "fuzz target $$target: planted bug found after $$(($$(date +%s) - begin)) s"; fi; \
	done | tee $(TARGET)/fuzz-planted/found.txt

coverage: ## Coverage of lines and branches by tests: target/quality/coverage.json. Needs the tools of LLVM (Debian: llvm-22).
	@[ -n "$(LLVM_COV)" ] || { echo "coverage needs llvm-cov: install the package llvm-22, or the component llvm-tools of rustup" >&2; exit 1; }
	mkdir -p $(TARGET)/quality && rm -rf $(TARGET)/coverage/profiles
	RUSTC_BOOTSTRAP=1 RUSTFLAGS="-Cinstrument-coverage -Zcoverage-options=branch" LLVM_PROFILE_FILE=$(abspath $(TARGET))/coverage/profiles/%m.profraw \
	  cargo test --locked --quiet --target-dir $(TARGET)/coverage $(COVERAGE_PACKAGES) --lib --tests
	$(LLVM_PROFDATA) merge --sparse $(TARGET)/coverage/profiles/*.profraw --output $(TARGET)/coverage/all.profdata
	$(LLVM_COV) export --summary-only --instr-profile $(TARGET)/coverage/all.profdata \
	  $$(find $(TARGET)/coverage/debug/deps -maxdepth 1 -type f -executable -name 'apex*' | sed 's/^/--object /') > $(TARGET)/quality/coverage.json

sbom: ## Bills of materials (CycloneDX) of the command and of the page: target/quality/*.cdx.json.
	mkdir -p $(TARGET)/quality
	cargo install --quiet --locked --root $(TARGET)/tools cargo-cyclonedx@$(CARGO_CYCLONEDX)
	PATH="$(abspath $(TARGET))/tools/bin:$$PATH" cargo cyclonedx --quiet --manifest-path crates/cli/Cargo.toml --format json --override-filename apex.cdx
	mv crates/cli/apex.cdx.json $(TARGET)/quality/apex.cdx.json && find adapters benches crates fuzz python spec xtask -name apex.cdx.json -delete
	cd web && npm sbom --package-lock-only --sbom-format cyclonedx > $(abspath $(TARGET))/quality/web.cdx.json

audit: ## Known vulnerabilities of packages of Rust and of the page, where their databases can be reached.
	mkdir -p $(TARGET)/quality
	cargo install --quiet --locked --root $(TARGET)/tools cargo-deny@$(CARGO_DENY)
	{ if $(TARGET)/tools/bin/cargo-deny --locked check licenses bans sources > $(TARGET)/quality/deny.log 2>&1; \
	  then echo "Licences, sources and doubled versions (cargo-deny): pass."; else echo "Licences, sources and doubled versions (cargo-deny): FAIL."; fi; echo; \
	  if ! $(TARGET)/tools/bin/cargo-deny --locked fetch db > $(TARGET)/quality/advisories.log 2>&1; \
	  then echo "Advisories of RustSec: not checked, the database cannot be reached."; \
	  elif $(TARGET)/tools/bin/cargo-deny --locked check --disable-fetch advisories >> $(TARGET)/quality/advisories.log 2>&1; \
	  then echo "Advisories of RustSec: none applies."; else echo "Advisories of RustSec: FAIL."; fi; echo; \
	  if (cd web && npm audit --package-lock-only --json) > $(TARGET)/quality/npm-audit.json 2> /dev/null; then echo "npm audit: no known vulnerability."; \
	  elif grep -q '"vulnerabilities"' $(TARGET)/quality/npm-audit.json; then echo "npm audit: FAIL."; \
	  else echo "npm audit: not checked, the registry answers no audits."; fi; } > $(TARGET)/quality/audit.md
	cat $(TARGET)/quality/audit.md
	! grep -q FAIL $(TARGET)/quality/audit.md

quality: coverage audit sbom ## Measure coverage, packages and bills of materials, and write docs/reference/quality.md from all measurements.
	printf 'commit\t%s\ncompiler\t%s\ndate\t%s\ntests\t%s\n' "$$(git rev-parse --short=12 HEAD)" "$$(rustc --version)" "$$(date -u +%F)" \
	  "$(COVERAGE_PACKAGES)" > $(TARGET)/quality/measured.tsv
	[ ! -f $(TARGET)/fuzz/executions.tsv ] || cp $(TARGET)/fuzz/executions.tsv $(TARGET)/quality/fuzz.tsv
	[ ! -f $(TARGET)/fuzz-planted/found.txt ] || sed -n 's/^fuzz target \(.*\): planted bug found after \(.*\) s$$/\1\t\2/p' $(TARGET)/fuzz-planted/found.txt > $(TARGET)/quality/planted.tsv
	cargo xtask quality

nightly: test build ## What is too slow for every change: many seeds, replay across builds, properties with new cases, a million random programs, ten million conditions, planted bugs, the planners' profile, measurements.
	for seed in 1 2 3 4 5 6 7 8; do $(MAKE) sim SEED=$$seed; done
	APEX_GUARDED_SEEDS=200 APEX_GUARDED_MISSIONS=200 $(CI_CARGO) test --locked $(CI_PROFILE) --package apex-simulation --test guarded_flights
	APEX_LINK_SEEDS=200 $(CI_CARGO) test --locked $(CI_PROFILE) --package apex-simulation --test communication
	mkdir -p $(TARGET)/quality && rm -f $(TARGET)/quality/crashes.tsv
	$(MEASURED) APEX_FAULT_HOURS=50000 APEX_FAULT_SEED=100000 $(CI_CARGO) test --locked $(CI_PROFILE) --package apex-simulation --test fault_simulator
	$(MEASURED) APEX_KILL_POINTS=10000 APEX_POWER_CUTS=100000 $(CI_CARGO) test --locked $(CI_PROFILE) --package apex-runtime --test flights crash::
	for mission in $(MISSIONS); do $(APEX) replay $(FLIGHTS)/$$mission.apex; done
	$(MAKE) deny
	$(MAKE) fuzz fuzz-planted
	$(MAKE) quality
	$(MAKE) wheel
	$(MAKE) properties
	CONTENTION_PROGRAMS=2000 $(CI_CARGO) test --locked $(CI_PROFILE) --package apex-executive --test contention_twin
	MISTAKE_SEEDS="$(MISTAKE_SEEDS)" $(CI_CARGO) test --locked $(CI_PROFILE) --package apex-pdl --test mistakes
	$(CI_CARGO) run --locked $(CI_PROFILE) --package apex-random -- --count 1000000 --seed 1000000
	$(CI_CARGO) run --locked $(CI_PROFILE) --package apex-random --features planted-bugs -- --planted
	$(CI_CARGO) run --locked $(CI_PROFILE) --package apex-conditions-random -- --count 10000000 --seed 1000000
	$(CI_CARGO) test --locked $(CI_PROFILE) --package apex-conditions-random --features planted-bugs --test planted
	cargo run --locked --quiet --release --package apex-benches --bin monitoring -- soak 100000000
	$(APEX) profile build $(TARGET)/profile-subset.txt --cells subset --budgets 1ms,3ms,10ms,100ms
	$(APEX) profile compare $(TARGET)/profile-subset.txt
	$(APEX) profile compare --regret --missions 1
	APEX_BRUTE_FORCE_PROBLEMS=100000 APEX_BRUTE_FORCE_SEED=1000000 $(CI_CARGO) test --locked $(CI_PROFILE) --package apex-solvers --test brute_force
	PROPTEST_CASES=$(TRAVEL_WORLDS) $(CI_CARGO) test --locked $(CI_PROFILE) --package apex-geo --lib travel::tests::random::no_way
	$(MAKE) golden-travel
	$(MAKE) bench
	$(MAKE) bench-door
	$(MAKE) bench-orienteering
	$(MAKE) bench-travel

wheel: .venv/.tools web/dist/index.html ## Pack the Python package as a wheel: target/wheels.
	.venv/bin/maturin build --quiet --locked --release --manifest-path python/Cargo.toml --out $(TARGET)/wheels

web: web/dist/index.html ## Build the web page.

python: .venv/.apex ## Build the Python package into .venv: .venv/bin/python -c "import apex_autonomy".

clean: ## Remove everything that was built.
	rm -rf $(TARGET) web/dist web/node_modules web/test-results

# --- parts of the above -------------------------------------------------------------------------------------------

.venv/.peers: benches/peers/requirements.txt
	python3 -m venv .venv
	.venv/bin/pip install --quiet --requirement $<
	touch $@

$(TARGET)/extremity/.installed: benches/peers/extremity-requirements.txt
	python3 -m venv $(TARGET)/extremity
	$(TARGET)/extremity/bin/pip install --quiet --requirement $<
	touch $@

.venv/.tools: python/requirements.txt
	python3 -m venv .venv
	.venv/bin/pip install --quiet --requirement $<
	touch $@

# The module comes from the build of the tests: maturin would compile the workspace again with other settings. It is
# found in python/ through a path file, as after `maturin develop`.
.PHONY: .venv/.apex
.venv/.apex: .venv/.tools rust-build
	cp $(TARGET)/ci/lib_apex.so python/apex_autonomy/_apex.abi3.so
	echo "$(abspath python)" > "$$(.venv/bin/python -c 'import sysconfig; print(sysconfig.get_path("purelib"))')/apex_autonomy.pth"

python-checks: .venv/.apex
	cd python && ../.venv/bin/ruff format --check --quiet . && ../.venv/bin/ruff check --quiet .
	cd python && ../.venv/bin/mypy apex_autonomy && ../.venv/bin/python -m mypy.stubtest apex_autonomy._apex

python-tests: .venv/.apex
	cd python && ../.venv/bin/pytest

# One after the other, beside something else.
.PHONY: python-package
python-package:
	$(MAKE) python-checks
	$(MAKE) python-tests

web/node_modules/.installed: web/package.json web/package-lock.json
	cd web && npm ci --no-audit --no-fund --loglevel=error
	touch $@

web/dist/index.html: web/node_modules/.installed $(WEB_SOURCES)
	cd web && npm run --silent build
	touch $@

# The server embeds web/dist when it is compiled, so the page comes first.
rust-lints: rust-rules rust-build

.PHONY: rust-rules
rust-rules:
	cargo fmt --all --check
	$(CI_CARGO) build --locked --quiet $(CI_PROFILE) $(CI_SELECTION) --bin xtask --test $(CI_SMALL_TEST)
	$(CI_XTASK) tidy

# Libraries, the Python module among them, tests, measurements, and the command, which its tests run; their lints.
.PHONY: rust-build
rust-build: web/dist/index.html
	$(CI_BUILD)

# No package has documentation tests; looking for them would take a run of rustdoc for each.
rust-tests: rust-build
	MAKEFLAGS= $(CI_LINTS) $(CI_XTASK) test --locked --quiet $(CI_PROFILE) $(CI_SELECTION) --lib --tests --examples

web-checks: web/node_modules/.installed
	cd web && npm run --silent check

web-tests: web/node_modules/.installed
	cd web && npm test --silent

$(CI_APEX): rust-build

# $(call fly_all,APEX,FOLDER,OPTIONS): every mission is flown headless to the success of its initial task, then replayed
# and compared, two at a time.
define fly_all
	mkdir -p $(2)
	printf '%s\n' $(MISSIONS) | xargs -P 2 -I {} bash -c \
	  'set -euo pipefail; $(1) fly missions/{} --record $(2)/{}.apex --no-progress $(3) > $(2)/{}.txt \
	   || { echo "flight of {} failed:"; cat $(2)/{}.txt; exit 1; }; \
   grep -q "because the initial task is done" $(2)/{}.txt || { echo "{} did not reach its goal:"; cat $(2)/{}.txt; exit 1; }; \
   $(1) replay $(2)/{}.apex; $(1) verify $(2)/{}.apex'
endef

flights: $(CI_APEX)
	rm -rf $(FLIGHTS)
	$(call fly_all,$(CI_APEX),$(FLIGHTS),)

page-tests: $(CI_APEX) web/node_modules/.installed chromium
	[ -f $(FLIGHTS)/western-states.apex ] || $(MAKE) flights
	cd web && APEX_BINARY=$(abspath $(CI_APEX)) APEX_RECORD=$(abspath $(FLIGHTS)/western-states.apex) npm run --silent e2e

pictures: $(CI_APEX) web/node_modules/.installed chromium ## Take the pictures of Sherpa and of each of its panels in docs/pictures.
	[ -f $(FLIGHTS)/western-states.apex ] || $(MAKE) flights
	cd web && APEX_BINARY=$(abspath $(CI_APEX)) node scripts/picture.mjs $(abspath $(FLIGHTS)/western-states.apex) ../docs/pictures

bench-page: build chromium ## Measure the time to the next paint of Sherpa while a record of 200 targets and 1,000 tasks plays.
	cd web && node scripts/paint.mjs $(abspath $(APEX)) $(abspath $(TARGET))/paint.apex

bench-record: build ## Measure the server on a record of a million lives of tasks with ten clients; the record is made first, in minutes.
	cd web && node scripts/load.mjs $(abspath $(APEX)) $(abspath $(TARGET))/load.apex

# The package `chromium-headless-shell` is the same browser without its own windows, and needs a third less processor time for a page.
chromium:
	@if ! command -v chromium-headless-shell > /dev/null && ! command -v chromium > /dev/null; then \
	  if [ "$$(id -u)" = 0 ]; then \
	    apt-get update -qq; install="apt-get install -y -qq --no-install-recommends"; \
	    $$install chromium-headless-shell || $$install chromium; \
	  else echo "The page's tests need Chromium: install the package 'chromium-headless-shell' or 'chromium' and try again." >&2; exit 1; fi; fi
