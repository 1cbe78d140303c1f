# The commands of the README. Each sets up what it needs; `make` alone lists them.

SHELL := bash
.SHELLFLAGS := -euo pipefail -c
.ONESHELL:
.DEFAULT_GOAL := help
.PHONY: help frame study test bench doc fmt toolchain

# Size of the picture of `make frame`, and frames of which it is the last, for example `make frame SIZE=1280x720 FRAMES=64`.
SIZE ?= 640x360
FRAMES ?= 16

# cargo where rustup puts it, also in shells that read no profile; the lock file binds in CI.
export PATH := $(PATH):$(HOME)/.cargo/bin
export CARGO_TERM_COLOR ?= auto
ifeq ($(origin CXX),default)
CXX := c++
endif
locked := $(if $(CI),--locked)
pt := cargo run $(locked) -p pt-app

help: ## list these commands
	@sed -nE 's/^([a-z]+):.*## (.*)/make \1\t\2/p' Makefile | expand -t 16

frame: toolchain ## render the built-in gallery to out/frame.png and out/frame.exr
	@scripts/setup-vulkan.sh
	mkdir -p out
	# The profile of the tests: built sooner than --release, and the time goes into kernels, which the driver compiles. Without
	# the decoders of compressed glTF files, which the gallery does not need.
	echo "building (the first time takes minutes) and rendering the gallery, $(SIZE), $(FRAMES) frames"
	$(pt) --no-default-features -- render gallery --size $(SIZE) --frames $(FRAMES) --profile realtime -o out/frame.png -o out/frame.exr
	echo "pictures: $$PWD/out/frame.png (display), $$PWD/out/frame.exr (linear scene radiance)"

study: toolchain ## run a small study of the frame's stages; the last line is the path of its results
	@scripts/setup-vulkan.sh
	mkdir -p out
	# A study goes on only with results of the same revision; references are kept by content.
	rm -rf out/study
	# Drivers of CPU devices compile kernels faster with it, and the frames are tiny.
	export GALLIVM_PERF=$${GALLIVM_PERF-nopt}
	$(pt) --no-default-features -- study studies/frame.toml -o out/study --cache out/references

test: toolchain ## everything CI asks: format, lints, documentation, all tests
	@start=$$SECONDS
	begin() { printf '\n== %s s: %s\n' $$((SECONDS - start)) "$$*"; }
	begin set-up
	scripts/setup-vulkan.sh --tests
	# Before anything is compiled: build scripts look for it.
	scripts/setup-xvfb.sh
	# The rest is mostly downloads: it goes on beside the lints. A failed lint does not cut off an installation.
	trap wait EXIT
	{
		scripts/setup-python.sh
		scripts/setup-browser.sh
		[[ -z "$${CI-}" ]] || scripts/setup-slurm.sh
	} &
	downloads=$$!
	cargo fmt --version >/dev/null 2>&1 && cargo clippy --version >/dev/null 2>&1 ||
		{ echo "rustfmt or clippy is missing: rustup component add rustfmt clippy" >&2; exit 2; }
	begin format
	cargo fmt --all --check $(if $(CI),-- --color never)
	begin lints
	cargo clippy $(locked) --workspace --all-targets -- -D warnings
	begin documentation
	# Called as cargo clippy calls clippy (each argument ends with the marker), so that the kernels are not compiled once more for it.
	RUSTC_WORKSPACE_WRAPPER=$$(rustc --print sysroot)/bin/clippy-driver CLIPPY_ARGS=-D__CLIPPY_HACKERY__warnings__CLIPPY_HACKERY__ \
		RUSTDOCFLAGS=-Dwarnings cargo doc $(locked) --workspace --no-deps
	wait $$downloads
	begin tests
	scripts/test.sh $(locked) --workspace --no-fail-fast

bench: toolchain ## rays per second of every trace backend, then the benchmarks of every kernel
	@scripts/setup-vulkan.sh
	$(pt) -q --release -- bench trace gallery
	cargo bench $(locked) --workspace

doc: toolchain ## the book, in target/book, and the crates' documentation, in target/doc
	@mdbook=$$(scripts/setup-book.sh)
	"$$mdbook" build docs
	# READMEs show these pictures, too, so that they are not within the book.
	cp docs/*.svg docs/*.png target/book/
	RUSTDOCFLAGS=-Dwarnings cargo doc $(locked) --workspace --no-deps
	echo "the book: $$PWD/target/book/index.html"

fmt: toolchain ## format all Rust code
	@cargo fmt --all

# One clear line instead of a build that fails late.
toolchain:
	@oldest=$$(sed -n 's/^rust-version = "\(.*\)"/\1/p' Cargo.toml)
	command -v cargo >/dev/null ||
		{ echo "cargo is missing: install Rust $$oldest or newer, https://rustup.rs" >&2; exit 2; }
	have=$$(cargo --version | cut -d' ' -f2)
	printf '%s\n' "$$oldest" "$$have" | sort -VC ||
		{ echo "cargo $$have is too old: install Rust $$oldest or newer, https://rustup.rs" >&2; exit 2; }
	command -v $(firstword $(CXX)) >/dev/null ||
		{ echo "the C++ compiler $(CXX) is missing; on Debian or Ubuntu: apt-get install build-essential" >&2; exit 2; }
