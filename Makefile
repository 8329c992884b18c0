# The front door: make help. Everything is built by Meson in $(BUILD).
BUILD ?= build
ASAN ?= build-asan
TSAN ?= build-tsan
CLANG ?= build-clang
FUZZ ?= build-fuzz
FUZZ_CC ?= clang-14
DEMO = $(BUILD)/demo
FOLDERS = include/. $(wildcard src/*/.) $(wildcard cli/*/.) tests/. $(wildcard tests/*/.) bench/. fuzz/. web/. web/src/.
MESON_FILES = meson.build $(wildcard */meson.build)

.PHONY: help setup setup-tests build install python site demo paper test check long ten time picture bench bench-short bench-doc sanitize race memcheck memcheck-python sanitize-units sanitize-python clang-units package-check container-check faults fuzz attack clean

help:
	@echo "make demo      build, compute the atlas of examples/elementary and draw it"
	@echo "make paper     build and make the figures of the article, docs/gallery.md"
	@echo "make test      build and run the whole test suite"
	@echo "make check     the part of it that takes a minute, for before a commit"
	@echo "make long      the whole suite in its long form: every case of what \`make test\` takes a sample of"
	@echo "make ten       the suite TIMES=10 times in a row beside BUSY=2 busy processes: none may be red"
	@echo "make bench     build and measure the speed; make bench-short: in half a minute"
	@echo "make time      what is promised about time, on a machine that does nothing else"
	@echo "make build     build the program and the library in $(BUILD)/"
	@echo "make install   build and install all of it below PREFIX=/usr/local, or below DESTDIR for a package"
	@echo "make python    build, install what the Python package needs, and leave it ready in python/"
	@echo "make site      build the documentation site in $(BUILD)/site/, with the notebooks run (Debian: pandoc)"
	@echo "make sanitize  build with address and undefined-behaviour checks in $(ASAN)/ and run the suite"
	@echo "make sanitize-units  the same of the test programs alone"
	@echo "make clang-units  build all with clang in $(CLANG)/, every warning an error, and run the test programs"
	@echo "make race      build with checks for data races in $(TSAN)/ and run what has threads"
	@echo "make memcheck  run the test programs and all commands under valgrind (Debian: valgrind)"
	@echo "make memcheck-python  run the tests of the Python package under valgrind"
	@echo "make sanitize-python  the same with the library of $(ASAN)/, as make sanitize does, too"
	@echo "make package-check    build the packages for Debian, and install, use and remove them in a clean root (Debian: mmdebstrap; as root)"
	@echo "make container-check  the steps of the Dockerfile in clean roots, without Docker (Debian: mmdebstrap; as root)"
	@echo "make faults    let every allocation and every writing call of a run fail once"
	@echo "make attack    judge the atlases of 2,000 random structures, ATTACK='-n 60 --seed 1' for fewer"
	@echo "make fuzz      build the fuzzing harnesses in $(FUZZ)/ and run each for SECONDS=60 (Debian: clang-14, libclang-rt-14-dev)"
	@echo "make picture   take the screenshot of ricochet view that the documentation shows"
	@echo "make setup     install the packages that are missing (all of the above do it, too)"
	@echo "make clean     remove $(BUILD)/, $(ASAN)/, $(TSAN)/, $(CLANG)/ and $(FUZZ)/"

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
	$(call configure,$(BUILD),$(FRESH))

# -O1 takes the compiler half as long as -O2 beside these checks, and makes the tests hardly slower.
$(ASAN)/build.ninja: $(FOLDERS) $(MESON_FILES) | setup
	$(call configure,$(ASAN),-Dbuildtype=debug -Doptimization=1 -Db_sanitize=address$(comma)undefined -Db_lundef=false)

$(TSAN)/build.ninja: $(FOLDERS) $(MESON_FILES) | setup
	$(call configure,$(TSAN),-Dbuildtype=debugoptimized -Db_sanitize=thread -Db_lundef=false)

comma := ,

build: $(BUILD)/build.ninja
	@ninja -C $(BUILD) --quiet

# Program, library, header, manual pages, completions, documents and examples.
install: build
	@$(if $(PREFIX),meson configure $(BUILD) -Dprefix=$(abspath $(PREFIX)) && ninja -C $(BUILD) --quiet)
	@meson install -C $(BUILD) --no-rebuild --quiet $(if $(DESTDIR),--destdir $(abspath $(DESTDIR)))

python: build
	@tools/setup python
	@ln -sfn $(abspath $(BUILD))/src/libricochet.so python/ricochet/libricochet.so
	@tools/python -c 'import ricochet; print("ricochet", ricochet.__version__, "is ready: PYTHONPATH=python python3, or pip install .")'

site: python
	@tools/setup site
	@rm -rf $(BUILD)/notebooks
	@tools/notebooks $(BUILD) $(BUILD)/notebooks
	@python3 -B tools/site/site.py $(BUILD)/site $(BUILD)/notebooks
	@python3 -B tools/site/check.py $(BUILD)/site

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

# A new folder is built with every warning an error, which saves to compile all once more for it; STRICT=false does not.
STRICT ?= true
test:
	@tools/setup tests
	@$(MAKE) --no-print-directory build FRESH=-Dstrict=$(STRICT)
	@tools/run-tests $(BUILD)

check: setup-tests build
	@tools/run-tests $(BUILD) --no-suite slow

# ONLY='cli_gallery power' names some.
long: export RICOCHET_TEST_LONG = 1
long: setup-tests build
	@tools/run-tests $(BUILD) --timeout-multiplier 40 $(ONLY)

TIMES ?= 10
BUSY ?= 2
ten: setup-tests build
	@tools/ten -n $(TIMES) -b $(BUSY) $(BUILD)

time: setup-tests build
	@RICOCHET=$(BUILD)/ricochet bash bench/time.sh
	@ninja -C $(BUILD) --quiet tests/test_shooting
	@RICOCHET_TEST_TIME=1 $(BUILD)/tests/test_shooting
	@for part in saved million; do \
		RICOCHET_TEST_TIME=1 PART=$$part RICOCHET=$(BUILD)/ricochet bash tests/cli/cli_view_page.sh || [ $$? = 77 ] || exit 1; done

picture: setup-tests build
	@mkdir -p $(DEMO)
	sed 's/multiply: 1/multiply: 2/' examples/elementary/study.yaml >$(DEMO)/view.yaml
	$(BUILD)/ricochet run $(DEMO)/view.yaml -o $(DEMO)/view.ricochet
	node tools/screenshot.mjs $(BUILD)/ricochet $(DEMO)/view.ricochet docs/view.png

# The same rows in half a minute, of shorter measurements, and without proofs and forced orbits.
bench-short: build
	@$(BUILD)/ricochet-bench -t 0.1 -o $(BUILD)/bench-short.txt
	@$(BUILD)/ricochet run examples/elementary/study.yaml -o $(BUILD)/bench-elementary.ricochet --quiet
	@tools/atlas-bytes $(BUILD)/bench-elementary.ricochet

bench: build
	@$(BUILD)/ricochet-bench
	@for name in elementary cascade beam-midspan two-springs; do \
		$(BUILD)/ricochet run examples/$$name/study.yaml -o $(BUILD)/bench-$$name.ricochet --quiet || exit 1; done
	@sed 's/impacts: 22/impacts: 48/; s/10000]/1000000]/; /^names/,$$d' examples/paper/path.yaml >$(BUILD)/bench-long.yaml
	@$(BUILD)/ricochet run $(BUILD)/bench-long.yaml -o $(BUILD)/bench-long.ricochet --quiet
	@$(BUILD)/ricochet-bench-prove $(BUILD)/bench-elementary.ricochet $(BUILD)/bench-cascade.ricochet \
		$(BUILD)/bench-beam-midspan.ricochet $(BUILD)/bench-two-springs.ricochet $(BUILD)/bench-long.ricochet \
		| tee $(BUILD)/bench-prove.txt
	@tools/atlas-bytes $(BUILD)/bench-elementary.ricochet $(BUILD)/bench-cascade.ricochet \
		$(BUILD)/bench-beam-midspan.ricochet $(BUILD)/bench-two-springs.ricochet | tee $(BUILD)/bench-bytes.txt
	@if [ -x $(BUILD)/ricochet-bench-forced ]; then $(BUILD)/ricochet-bench-forced -o $(BUILD)/bench-forced.txt; fi

# What was measured last, into docs/performance.md.
bench-doc:
	@sed -i -e '/^```text bench/,/^```$$/{//!d}' -e '/^```text bench/r $(BUILD)/bench.txt' docs/performance.md

sanitize: setup-tests $(ASAN)/build.ninja
	@ninja -C $(ASAN) --quiet
	@ASAN_OPTIONS=detect_leaks=1 UBSAN_OPTIONS=halt_on_error=1:print_stacktrace=1 tools/run-tests $(ASAN) --timeout-multiplier 10
	@tools/memcheck-python -address $(ASAN) || [ $$? = 77 ]

# The same of the test programs alone, of those that ONLY names, or with QUICK=1 of those that `make check` takes but for DEAR, each of which
# takes 8 s and more under these checks; and of them and the library as clang makes them.
UNITS = $(sort $(patsubst test_%,%,$(basename $(notdir $(wildcard tests/unit/test_*.c tests/article/test_*.c)))))
SLOW = $(shell sed -n '/^slow = /,/\]/s/[^a-z0-9_]/ /gp' tests/meson.build)
DEAR = article attractors census claims equal_modes force_stability forced study
SANITIZED = $(or $(ONLY),$(if $(QUICK),$(filter-out $(SLOW) $(DEAR),$(UNITS)),$(UNITS)))
sanitize-units: setup-tests $(ASAN)/build.ninja
	@ninja -C $(ASAN) --quiet $(addprefix tests/test_,$(SANITIZED))
	@ASAN_OPTIONS=detect_leaks=1 UBSAN_OPTIONS=halt_on_error=1:print_stacktrace=1 tools/run-tests $(ASAN) --timeout-multiplier 10 $(SANITIZED)

$(CLANG)/build.ninja: export CC = clang
$(CLANG)/build.ninja: $(FOLDERS) $(MESON_FILES) | setup
	$(call configure,$(CLANG),-Dstrict=true)

clang-units: setup-tests $(CLANG)/build.ninja
	@ninja -C $(CLANG) --quiet
	@tools/run-tests $(CLANG) --suite unit --suite article

# The same of the Python package alone: the library is loaded into a Python that has no checks, behind that of the sanitizer.
sanitize-python: setup-tests $(ASAN)/build.ninja
	@ninja -C $(ASAN) --quiet ricochet $$(ninja -C $(ASAN) -t targets all | sed -n 's/^\(src\/libricochet.so[0-9.]*\): .*LINKER$$/\1/p')
	@tools/memcheck-python -address $(ASAN)

# The programs of tests/unit/test_*.c have one thread, but for `threads`; these tests have ricochet start several. Open MPI, which knows nothing of the sanitizer, is left out
# by race.supp.
THREADED ?= threads cli_workers cli_regions cli_hunt cli_view cli_view_page cli_mpi
race: setup-tests $(TSAN)/build.ninja
	@ninja -C $(TSAN) --quiet
	@TSAN_OPTIONS=halt_on_error=1:suppressions=$(CURDIR)/tools/race.supp tools/run-tests $(TSAN) --timeout-multiplier 40 $(THREADED)

memcheck: setup-tests build
	@command -v valgrind >/dev/null || { echo 'valgrind is missing (Debian: valgrind)'; exit 1; }
	@tools/memcheck.sh $(BUILD)

memcheck-python: setup-tests build
	@tools/memcheck-python -valgrind $(BUILD)

package-check: setup-tests
	@tools/package-check

container-check:
	@tools/container-check

faults: setup-tests build
	@FAULTS_ALL=1 RICOCHET=$(BUILD)/ricochet bash tests/cli/cli_faults.sh

ATTACK ?= -n 2000 --least 300 --unconfirmed 1 --points 40 --seed 1 -j 2 --quiet --brute --compare step,order,workers --folder $(BUILD)/attack --log $(BUILD)/attack.json
attack: setup-tests build
	@tools/attack/attack --program $(BUILD)/ricochet $(ATTACK)

SECONDS ?= 60
$(FUZZ)/build.ninja: export CC = $(FUZZ_CC)
$(FUZZ)/build.ninja: $(FOLDERS) $(MESON_FILES) | setup
	$(call configure,$(FUZZ),-Dfuzz=true -Dmpi=disabled -Dbuildtype=debugoptimized -Db_sanitize=address$(comma)undefined -Db_lundef=false)

fuzz: $(FUZZ)/build.ninja
	@ninja -C $(FUZZ) --quiet
	@tools/fuzz.sh $(FUZZ) $(SECONDS)

clean:
	rm -rf $(BUILD) $(ASAN) $(TSAN) $(CLANG) $(FUZZ)
