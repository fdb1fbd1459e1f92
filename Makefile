# `make run` sets up whatever is missing and serves; `make test` checks everything that needs no PyTorch.

SHELL := /bin/bash
.SHELLFLAGS := -euo pipefail -c
.DEFAULT_GOAL := help
.DELETE_ON_ERROR:

LISTEN ?= 127.0.0.1:8080
DATA ?= data
TOILE := target/release/toile
VENV := .venv
MODEL_VENV := .venv-model
PIP := bin/pip --disable-pip-version-check --quiet
NPM_CI := npm ci --no-audit --no-fund --loglevel=error
# One profile for everything, so that dependencies compile once.
CARGO_TEST := cargo test --release --locked

RUNTIME := $(VENV)/.runtime
TEST_TOOLS := $(VENV)/.test-tools
MODEL_TOOLS := $(MODEL_VENV)/.model-tools
TEACHER_TOOLS := $(MODEL_VENV)/.teacher-tools
WEB_MODULES := web/node_modules/.installed
WEB_PAGE := web/dist/index.html
VALIDATOR := tests/validator/node_modules/.installed
BROWSER_MODULES := tests/browser/node_modules/.installed
WEB_SOURCES := $(shell find web/src web/public web/index.html web/vite.config.ts web/tsconfig.json -type f 2>/dev/null)

.PHONY: help run build binary test test-model lint lint-rust lint-model lint-web bench train train-simulated export clean tools bake hero \
	train-garnet evaluate-garnet train-pixel evaluate-pixel \
	test-rust test-python test-web test-e2e test-browser test-teacher evaluate thumbnails pictures chromium

help:
	@echo "make run         serve on http://$(LISTEN), with everything set up first"
	@echo "make build       build $(TOILE) and the try-on page"
	@echo "make test        lint, and all tests that need no PyTorch"
	@echo "make test-model  the tests that need PyTorch"
	@echo "make test-teacher  the tests that need the simulator"
	@echo "make lint        formatting, lints and type checks"
	@echo "make bench       how long every stage takes"
	@echo "make evaluate    the draping's figures, against simulated drapes too"
	@echo "make bake OUTFIT=id  refine one outfit of a running server, in minutes"
	@echo "make hero OUTFIT=file  teach pixel cloth one outfit with UVs, at a running server, in an hour or two"
	@echo "make train       generate outfits and train the networks"
	@echo "make train-simulated  simulate drapes and train the network on with them, in hours"
	@echo "make train-garnet  make GarNet's drapes and train it on them, in hours"
	@echo "make evaluate-garnet  GarNet's tables, of what has been trained"
	@echo "make train-pixel  make the T-shirt's drapes and train pixel cloth on them, in hours"
	@echo "make evaluate-pixel  pixel cloth's tables, of what has been made and trained"
	@echo "make export      write the trained networks as ONNX"
	@echo "make thumbnails  draw the pictures of the demo outfits again"
	@echo "make pictures    draw the README's pictures again"
	@echo "make clean       remove everything that was built (not $(DATA)/)"

# Large blocks go back to the system: glibc would keep what every static pass freed (docs/benchmarks.md, Memory).
run: export MALLOC_MMAP_THRESHOLD_ = 1048576
run: export MALLOC_TRIM_THRESHOLD_ = 1048576
run: build
	exec $(TOILE) serve --listen $(LISTEN) --data $(DATA)

build: tools $(RUNTIME) $(WEB_PAGE) binary

binary: tools
	cargo build --release --locked --quiet --package toile-server

# Everything that cannot be installed from here, named all at once.
tools:
	@missing=0; \
	need() { if ! eval "$$2" >/dev/null 2>&1; then echo "missing: $$1. $$3" >&2; missing=1; fi; }; \
	need "cargo (Rust 1.88 or newer)" "command -v cargo" "Get it from https://rustup.rs"; \
	need "a C and a C++ compiler" "command -v cc && command -v c++" "On Debian or Ubuntu: apt-get install build-essential"; \
	need "python3 (3.11 or newer)" "python3 -c 'import sys; sys.exit(sys.version_info < (3, 11))'" \
		"On Debian or Ubuntu: apt-get install python3; or from https://www.python.org"; \
	need "python3's venv" "python3 -c 'import venv, ensurepip'" "On Debian or Ubuntu: apt-get install python3-venv"; \
	need "node (20.19 or newer)" "node -e 'const [a, b] = process.versions.node.split(\".\").map(Number); process.exit(a > 20 || (a === 20 && b >= 19) ? 0 : 1)'" \
		"Get it from https://nodejs.org"; \
	need "npm" "command -v npm" "It comes with node: https://nodejs.org"; \
	exit $$missing

$(RUNTIME): model/requirements.txt | tools
	@echo "setting up $(VENV) with ONNX Runtime"
	python3 -m venv $(VENV)
	$(VENV)/$(PIP) install -r model/requirements.txt
	touch $@

$(TEST_TOOLS): model/requirements-test.txt $(RUNTIME)
	$(VENV)/$(PIP) install -r model/requirements-test.txt
	touch $@

$(MODEL_TOOLS): model/requirements-model.txt model/requirements-test.txt model/requirements.txt | tools
	@echo "setting up $(MODEL_VENV) with PyTorch"
	python3 -m venv $(MODEL_VENV)
	$(MODEL_VENV)/$(PIP) install -r model/requirements-model.txt
	touch $@

$(TEACHER_TOOLS): model/requirements-teacher.txt $(MODEL_TOOLS)
	$(MODEL_VENV)/$(PIP) install -r model/requirements-teacher.txt
	touch $@

$(WEB_MODULES): web/package-lock.json | tools
	cd web && $(NPM_CI)
	touch $@

$(WEB_PAGE): $(WEB_MODULES) $(WEB_SOURCES)
	@echo "building the try-on page"
	cd web && npm run --silent build
	touch $@

$(VALIDATOR): tests/validator/package-lock.json | tools
	cd tests/validator && $(NPM_CI)
	touch $@

$(BROWSER_MODULES): tests/browser/package-lock.json | tools
	cd tests/browser && $(NPM_CI)
	touch $@

test: lint test-rust test-python test-web test-e2e test-browser
	@echo "all tests passed"

lint: lint-rust lint-model lint-web

lint-rust: tools
	cargo fmt --all --check
	cargo clippy --release --locked --workspace --all-targets --quiet -- -D warnings

lint-model: $(TEST_TOOLS)
	$(VENV)/bin/ruff check model

lint-web: $(WEB_MODULES)
	cd web && npm run --silent lint && npm run --silent typecheck

test-rust: tools $(RUNTIME)
	$(CARGO_TEST) --workspace --exclude toile-tests

test-python: $(TEST_TOOLS)
	cd model && ../$(VENV)/bin/python -m pytest tests

test-web: $(WEB_MODULES)
	cd web && npm test --silent

test-e2e: build $(VALIDATOR)
	TOILE_BIN=$(TOILE) $(CARGO_TEST) --package toile-tests

test-browser: build chromium $(BROWSER_MODULES)
	tests/with-server.sh $(TOILE) bash -c 'cd tests/browser && npm test --silent'

# The page draws what it gets no picture of.
thumbnails: build chromium $(BROWSER_MODULES)
	rm -f model/artifacts/gallery/*.png
	tests/with-server.sh $(TOILE) node tests/browser/draw_thumbnails.js

pictures: build chromium $(BROWSER_MODULES)
	tests/with-server.sh $(TOILE) node tests/browser/draw_pictures.js
	tests/with-server.sh $(TOILE) node tests/browser/draw_normal_map.js

chromium:
	@command -v chromium >/dev/null || { \
		echo "installing chromium for the browser test"; \
		as_root=; if [ "$$(id -u)" != 0 ]; then as_root=sudo; fi; \
		$$as_root apt-get update -qq && $$as_root apt-get install -qq -y --no-install-recommends chromium >/dev/null \
		|| { echo "chromium cannot be installed from here; install it, for instance with: apt-get install chromium" >&2; exit 1; }; }

test-model: $(MODEL_TOOLS)
	cd model && ../$(MODEL_VENV)/bin/python -m pytest tests_model

test-teacher: $(TEACHER_TOOLS)
	cd model && ../$(MODEL_VENV)/bin/python -m pytest tests_teacher

bench: build
	$(TOILE) bench

# Small sets by default, in minutes; `make evaluate EVALUATE=full` is what docs/deepsd.md shows, in hours.
EVALUATE ?= small
small_TEACHER := --outfits 5 --bodies 1 --poses 2 --vertices 800 --out data/teacher_small
full_TEACHER := --out data/teacher
small_POSES := --poses 5
full_POSES := --poses 20
evaluate: build $(TEACHER_TOOLS)
	cd model && ../$(MODEL_VENV)/bin/python -m outfits.held_out --count 5 >/dev/null
	cd model && ../$(MODEL_VENV)/bin/python -m outfits.artist_like >/dev/null
	@echo "Outfits of kinds never trained on"
	$(TOILE) evaluate $($(EVALUATE)_POSES) model/data/held_out/0[0-4]_*.obj
	@echo "Outfits with the faults of artists' files"
	$(TOILE) evaluate $($(EVALUATE)_POSES) model/data/artist_like/*.obj
	@echo "Against simulated drapes"
	cd model && OMP_NUM_THREADS=1 ../$(MODEL_VENV)/bin/python -m teacher.drapes $($(EVALUATE)_TEACHER) | { grep steps || true; }
	cd model && ../$(MODEL_VENV)/bin/python -m teacher.compare --drapes $(lastword $($(EVALUATE)_TEACHER))

# One thread each: two runs side by side use both cores better than one.
train: $(MODEL_TOOLS)
	cd model && ../$(MODEL_VENV)/bin/python -m outfits.dataset --count 640 --validation 60 --out data/outfits
	cd model && OMP_NUM_THREADS=1 ../$(MODEL_VENV)/bin/python -m training_data
	cd model && export OMP_NUM_THREADS=1 && { ../$(MODEL_VENV)/bin/python -m relax --minutes 20 --seed 2 & \
		../$(MODEL_VENV)/bin/python -m relax --minutes 20; relaxed=$$?; wait; exit $$relaxed; }
	cd model && export OMP_NUM_THREADS=1 && { ../$(MODEL_VENV)/bin/python -m relax --minutes 44 --seed 1 & \
		../$(MODEL_VENV)/bin/python -m train_deepsd --minutes 50; trained=$$?; wait; exit $$trained; }
	cd model && ../$(MODEL_VENV)/bin/python -m distill_concat --minutes 7

# Goes on from what was trained last, or else from what is shipped, to the mean of the start and of two ends.
SIMULATED_RUN := --simulated data/simulated --minutes 10 --start 0.5 --rate 1e-3
train-simulated: build $(TEACHER_TOOLS)
	cd model && ../$(MODEL_VENV)/bin/python -m outfits.dataset --count 160 --validation 12 --out data/outfits
	cd model && OMP_NUM_THREADS=1 ../$(MODEL_VENV)/bin/python -m teacher.training_set
	cd model && if [ -f runs/deepsd.pt ]; then cp runs/deepsd.pt runs/start.pt; \
		else ../$(MODEL_VENV)/bin/python -m shipped --out runs/start.pt; fi
	cd model && export OMP_NUM_THREADS=1 && for seed in 0 1; do ../$(MODEL_VENV)/bin/python -m train_deepsd \
		--resume runs/start.pt $(SIMULATED_RUN) --seed $$seed --out runs/end$$seed.pt || exit; done
	cd model && ../$(MODEL_VENV)/bin/python -m average runs/start.pt runs/end0.pt runs/end1.pt
	cd model && ../$(MODEL_VENV)/bin/python -m distill_concat --minutes 7

GARMENTS := tee sweater dress jeans
train-garnet: $(MODEL_TOOLS)
	cd model && export OMP_NUM_THREADS=1 && { ../$(MODEL_VENV)/bin/python -m garnet_data --part 0 --parts 2 & \
		../$(MODEL_VENV)/bin/python -m garnet_data --part 1 --parts 2; made=$$?; wait; exit $$made; }
	cd model && for garment in $(GARMENTS); do for variant in naive global local; do \
		../$(MODEL_VENV)/bin/python -m train_garnet $$garment --variant $$variant --minutes 5; done; \
		../$(MODEL_VENV)/bin/python -m train_garnet $$garment --resume runs/garnet/$${garment}_local.pt --minutes 13 --rate 3e-3; \
		for curvature in rq mc; do \
		../$(MODEL_VENV)/bin/python -m train_garnet $$garment --curvature $$curvature --minutes 5; done; done

evaluate-garnet: $(MODEL_TOOLS)
	cd model && ../$(MODEL_VENV)/bin/python -m evaluate_garnet

# As what ships was trained: from relaxed drapes, then from simulated ones.
train-pixel: build $(TEACHER_TOOLS)
	cd model && export OMP_NUM_THREADS=1 && { ../$(MODEL_VENV)/bin/python -m pixel_data --minutes 120 --part 0 --parts 2 & \
		../$(MODEL_VENV)/bin/python -m pixel_data --minutes 120 --part 1 --parts 2; made=$$?; wait; exit $$made; }
	cd model && ../$(MODEL_VENV)/bin/python -m train_pixel
	cd model && OMP_NUM_THREADS=1 ../$(MODEL_VENV)/bin/python -m teacher.pixel_drapes
	cd model && export OMP_NUM_THREADS=1 && for seed in 0 1; do ../$(MODEL_VENV)/bin/python -m train_pixel --simulated \
		--resume runs/pixel/tee_l1.pt --rate 1e-3 --minutes 25 --seed $$seed --out runs/pixel/end$$seed || exit; done
	cd model && ../$(MODEL_VENV)/bin/python -m average_pixel runs/pixel/end0/tee_simulated_l1.pt runs/pixel/end1/tee_simulated_l1.pt

evaluate-pixel: $(MODEL_TOOLS)
	cd model && ../$(MODEL_VENV)/bin/python -m evaluate_pixel

SERVER ?= http://$(LISTEN)
bake: $(MODEL_TOOLS)
	@test -n "$(OUTFIT)" || { echo "say which outfit: make bake OUTFIT=id (GET /v1/outfits lists them)" >&2; exit 1; }
	cd model && OMP_NUM_THREADS=1 ../$(MODEL_VENV)/bin/python -m bake "$(OUTFIT)" --server "$(SERVER)"

MINUTES ?= 90
hero: build $(TEACHER_TOOLS)
	@test -n "$(OUTFIT)" || { echo "say which outfit: make hero OUTFIT=file.glb, or its id (GET /v1/outfits lists them)" >&2; exit 1; }
	outfit="$(OUTFIT)"; if [ -f "$$outfit" ]; then outfit=$$(realpath "$$outfit"); fi; \
		cd model && ../$(MODEL_VENV)/bin/python -m hero "$$outfit" --server "$(SERVER)" --minutes $(MINUTES)

export: $(MODEL_TOOLS)
	cd model && ../$(MODEL_VENV)/bin/python -m export
	cd model && ../$(MODEL_VENV)/bin/python -m goldens_deepsd

clean:
	rm -rf target $(VENV) $(MODEL_VENV) web/dist web/node_modules tests/validator/node_modules tests/browser/node_modules
