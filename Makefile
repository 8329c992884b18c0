# The front door: make help. Everything is built by Meson in $(BUILD).
BUILD ?= build
ASAN ?= build-asan
FUZZ ?= build-fuzz
FUZZ_CC ?= clang-14
DEMO = $(BUILD)/demo
FOLDERS = include/. src/. cli/. tests/. bench/. fuzz/. web/. web/src/.
MESON_FILES = meson.build $(wildcard */meson.build)

.PHONY: help setup setup-tests build demo paper test picture bench sanitize fuzz clean

help:
	@echo "make demo      build, compute the atlas of examples/elementary and draw it"
	@echo "make paper     build and make the figures of the article, docs/gallery.md"
	@echo "make test      build and run the whole test suite"
	@echo "make bench     build and measure the speed"
	@echo "make build     build the program and the library in $(BUILD)/"
	@echo "make sanitize  build with address and undefined-behaviour checks in $(ASAN)/ and run the suite"
	@echo "make fuzz      build the fuzzing harnesses in $(FUZZ)/ and run each for SECONDS=60 (Debian: clang-14, libclang-rt-14-dev)"
	@echo "make picture   take the screenshot of ricochet view that the documentation shows"
	@echo "make setup     install the packages that are missing (all of the above do it, too)"
	@echo "make clean     remove $(BUILD)/, $(ASAN)/ and $(FUZZ)/"

setup:
	@tools/setup

# What only the tests need.
setup-tests:
	@tools/setup tests

# A new or a removed file changes its folder: configure again.
define configure
	@mkdir -p $(1)
	@meson setup $(if $(wildcard $(1)/build.ninja),--reconfigure,$(2)) $(1) >$(1)/configure.log || { cat $(1)/configure.log; exit 1; }
	@touch $(1)/build.ninja
endef

$(BUILD)/build.ninja: $(FOLDERS) $(MESON_FILES) | setup
	$(call configure,$(BUILD),)

$(ASAN)/build.ninja: $(FOLDERS) $(MESON_FILES) | setup
	$(call configure,$(ASAN),-Dbuildtype=debugoptimized -Db_sanitize=address$(comma)undefined -Db_lundef=false)

comma := ,

build: $(BUILD)/build.ninja
	@ninja -C $(BUILD) --quiet

demo: build
	@mkdir -p $(DEMO)
	$(BUILD)/ricochet run examples/elementary/study.yaml -o $(DEMO)/elementary.ricochet
	$(BUILD)/ricochet plot fep $(DEMO)/elementary.ricochet --break 2.2 -o $(DEMO)/elementary.svg
	$(BUILD)/ricochet plot fep $(DEMO)/elementary.ricochet --break 2.2 -o $(DEMO)/elementary.png
	@echo
	@$(BUILD)/ricochet junctions $(DEMO)/elementary.ricochet
	@echo
	@echo "atlas    $(DEMO)/elementary.ricochet"
	@echo "picture  $(DEMO)/elementary.svg  $(DEMO)/elementary.png"

paper: build
	@tools/paper $(BUILD)

test:
	@tools/setup tests
	@$(MAKE) --no-print-directory build
	@tools/run-tests $(BUILD)

picture: setup-tests build
	@mkdir -p $(DEMO)
	sed 's/multiply: 1/multiply: 2/' examples/elementary/study.yaml >$(DEMO)/view.yaml
	$(BUILD)/ricochet run $(DEMO)/view.yaml -o $(DEMO)/view.ricochet
	node tools/screenshot.mjs $(BUILD)/ricochet $(DEMO)/view.ricochet docs/view.png

bench: build
	@$(BUILD)/ricochet-bench

sanitize: setup-tests $(ASAN)/build.ninja
	@ninja -C $(ASAN) --quiet
	@ASAN_OPTIONS=detect_leaks=1 UBSAN_OPTIONS=halt_on_error=1:print_stacktrace=1 tools/run-tests $(ASAN)

SECONDS ?= 60
$(FUZZ)/build.ninja: export CC = $(FUZZ_CC)
$(FUZZ)/build.ninja: $(FOLDERS) $(MESON_FILES) | setup
	$(call configure,$(FUZZ),-Dfuzz=true -Dmpi=disabled -Dbuildtype=debugoptimized -Db_sanitize=address$(comma)undefined -Db_lundef=false)

fuzz: $(FUZZ)/build.ninja
	@ninja -C $(FUZZ) --quiet
	@tools/fuzz.sh $(FUZZ) $(SECONDS)

clean:
	rm -rf $(BUILD) $(ASAN) $(FUZZ)
