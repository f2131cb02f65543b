# deepgbuffer: two single-header libraries, their examples and their tests. `make help` lists the targets.
#
# Sources are found by name: a new tests/unit/test_NAME.c or examples/integrations/NAME.c needs no change here.

config ?= release
B := build/$(config)

ifeq ($(MAKELEVEL),0)
MAKEFLAGS += -j$(shell nproc 2>/dev/null || echo 2) --no-print-directory
endif

# >> compilers and flags

sanitizers := -fsanitize=address,undefined,float-cast-overflow,float-divide-by-zero -fno-sanitize-recover=all

flags_debug    := -O0 -g
flags_release  := -O2
flags_sanitize := -O1 -g -fno-omit-frame-pointer $(sanitizers)
flags_fastmath := -O2 -ffast-math
flags_coverage := -O0 -g --coverage
flags_fuzz     := $(flags_sanitize) -fsanitize=fuzzer-no-link
flags := $(flags_$(config))
$(if $(flags),,$(error config=$(config): choose debug, release, sanitize, fastmath, coverage or fuzz))

# libFuzzer is clang's.
ifeq ($(config),fuzz)
CC  := clang
CXX := clang++
endif

# Third-party headers come in as system headers: their warnings are not ours.
packages := egl epoxy glfw3 sdl2 imgui cmocka glm CLI11 stb tinygltf vulkan
third_party := $(patsubst -I%,-isystem %,$(foreach p,$(packages),$(shell pkg-config --cflags-only-I $(p) 2>/dev/null)))
vulkan := $(shell pkg-config --exists vulkan 2>/dev/null && echo vulkan)
imgui := $(shell pkg-config --exists imgui 2>/dev/null && echo imgui)
sdl2 := $(shell pkg-config --exists sdl2 2>/dev/null && echo sdl2)
libs = $(if $(1),$(shell pkg-config --libs $(1))) -lm

warnings := -Wall -Wextra -Wshadow -Wconversion -Werror
CPPFLAGS += -I. -Iexamples -Iexamples/integrations -Itests/support -Itests/reference -Itests/bench $(third_party)
CFLAGS   := -std=c99 -pedantic $(warnings) -ffp-contract=off $(flags)
CXXFLAGS := -std=c++17 $(warnings) -ffp-contract=off $(flags)
export CC CXX

# >> sources and programs

objects = $(patsubst %,$(B)/obj/%.o,$(basename $(1)))
programs = $(patsubst examples/%,$(B)/%,$(basename $(1)))

# What several programs share is an archive: a program takes in only the parts it uses.
example_parts   := $(sort $(wildcard examples/scene*.cpp) $(wildcard examples/image.cpp examples/headless.c))
viewer_sources  := $(wildcard examples/viewer*.cpp)
example_sources := $(filter-out $(example_parts) $(viewer_sources),$(wildcard examples/*.c examples/*.cpp))
integration_parts   := examples/headless.c $(addprefix examples/integrations/,engine.c rhi_gl.c rhi_shaders.c)
integration_sources := $(filter-out $(integration_parts) $(if $(sdl2),,%/sdl2.c),$(wildcard examples/integrations/*.c*))
integrations    := $(call programs,$(integration_sources))
examples        := $(call programs,$(example_sources)) $(integrations) $(if $(imgui),$(B)/viewer)
support         := $(wildcard tests/support/*.c)
reference       := $(filter-out tests/reference/test_%,$(wildcard tests/reference/*.cpp))

# The programs of one test folder in one configuration: $(call tests_in,unit,sanitize).
tests_in = $(patsubst %.c,build/$(2)/%,$(wildcard tests/$(1)/test_*.c))
core_tests  = $(foreach folder,unit backends,$(call tests_in,$(folder),$(1)))
gl_tests   := $(call tests_in,gl,$(config))
gpu_cost   := $(B)/tests/gpu_cost/gpu_cost
benchmarks := $(patsubst %,$(B)/%,$(basename $(wildcard tests/bench/*.c tests/bench/*.cpp)))

# Programs that compare with rays: tests/reference, and the benchmarks that include its header.
reference_tests       = $(patsubst %.cpp,build/$(1)/%,$(wildcard tests/reference/test_*.cpp))
reference_benchmarks := $(patsubst %.cpp,$(B)/%,$(shell grep -l '"reference.hpp"' tests/bench/*.cpp))

# Programs that test parts of the examples which need no GPU.
scene_tests = $(patsubst %.cpp,build/$(1)/%,$(wildcard tests/examples/test_*.cpp))

# Fuzz targets: with libFuzzer, where clang has it, in config=fuzz, else with a driver that reads files.
fuzz_targets = $(patsubst %,build/$(1)/%,$(basename $(wildcard tests/fuzz/fuzz_*.c tests/fuzz/fuzz_*.cpp)))
fuzzer       = $(shell echo 'int LLVMFuzzerTestOneInput(void) { return 0; }' | \
    clang -fsanitize=fuzzer -x c - -o /dev/null 2>/dev/null && echo yes)

source_tests  := tests/compile/compile.sh tests/compile/package.sh tests/shaders/embed.sh tests/shaders/lint.sh
shader_tests  := tests/shaders/check.sh
gpu_tests     := tests/gpu_cost/check.sh
fuzz_tests    := tests/fuzz/fuzz.sh
example_tests := $(wildcard tests/examples/*.sh)

# >> targets

# What the examples cannot do without is named before the first of them is compiled.
ifneq ($(filter all examples,$(or $(MAKECMDGOALS),all)),)
$(foreach p,egl epoxy glfw3,$(if $(shell pkg-config --exists $(p) 2>/dev/null && echo yes),, \
    $(error the package $(p) is missing: `make setup` installs what there is to install, or names it)))
endif

.PHONY: all help setup demo pictures test test-full check check-core check-gl check-reference coverage mutate examples \
        bench fuzz gpu-cost core-tests gl-tests gpu-tests reference-tests scene-tests fuzz-targets trade budget \
        install uninstall embed embed-check shaders-check format format-fix tidy clean
.DEFAULT_GOAL := all
.DELETE_ON_ERROR:
.SECONDARY:

all: examples

help: ## list the targets
	@echo "make TARGET [config=debug|release|sanitize|fastmath|coverage]"
	@awk -F ':.*## ' '/^[a-z-]+:.*## / { printf "    %-14s %s\n", $$1, $$2 }' Makefile

setup: ## install what the examples and the tests need and this machine lacks
	@.ci/setup test

# What `make demo` renders, a command a line.
define demo_commands
build/release/render --out build/demo/atrium --preset quality --samples 60 --ao-samples 40
build/release/render --out build/demo/moving --size 640x360 --orbit 1
build/release/render --out build/demo/bounces --size 480x270 --preset quality --compare-bounces 1,2,100 \
    --camera -15,7.2,-7,0,6.5,-7,70 --sun 0.3,0.5,0.6,12 --sky 0.01,0.015,0.02 --radius 12
endef

demo: ## set up, build and render the atrium into build/demo
	@.ci/setup demo
	@$(MAKE) config=release build/release/render
	@mkdir -p build/demo
	$(demo_commands)

pictures: ## make the README's pictures anew; SCENE_DIR=DIR has the scenes that are files
	@$(MAKE) config=release build/release/render $(if $(imgui),build/release/viewer)
	@$(if $(SCENE_DIR),SCENE_DIR='$(SCENE_DIR)') examples/pictures/make.sh

test: setup ## set up, build and run every test
	@$(MAKE) config=release examples core-tests gl-tests gpu-tests reference-tests build/release/trade
	@$(MAKE) config=sanitize core-tests scene-tests fuzz-targets
	@$(MAKE) config=fastmath core-tests
	@$(if $(fuzzer),$(MAKE) config=fuzz fuzz-targets)
	@tests/run $(source_tests) $(shader_tests) $(gpu_tests) \
	    $(foreach c,release sanitize fastmath,$(call core_tests,$(c))) $(call tests_in,gl,release) \
	    $(call reference_tests,release) $(call scene_tests,sanitize) $(fuzz_tests) tests/trade/trade.sh $(example_tests)

# Loops that CI takes samples of, whole; the OpenGL backend under valgrind, where there is one; other OpenGLs. Under an hour.
full_tests := build/sanitize/tests/backends/test_gl_faults \
    build/release/tests/gl/test_guest build/release/tests/gl/test_furnace
valgrind := $(shell command -v valgrind)
test-full: ## what is too long for `make test`: every fault, state by more seeds, 2000 frames, valgrind, other OpenGLs
	@$(MAKE) config=sanitize build/sanitize/tests/backends/test_gl_faults
	@$(MAKE) config=release gl-tests
	@$(MAKE) config=debug build/debug/tests/backends/test_gl_faults
	@DGB_FULL=1 TEST_TIMEOUT=7200 tests/run $(full_tests)
	@$(if $(valgrind),$(valgrind) --quiet --error-exitcode=1 --leak-check=full build/debug/tests/backends/test_gl_faults, \
	    echo "test-full: valgrind is missing")
	@tests/gl/opinions.sh

check: ## the tests that need no GPU and no package: compilation, symbols, embedded shaders
	@tests/run $(source_tests)

check-core: core-tests ## the tests of the core, which need no GPU
	@tests/run $(call core_tests,$(config))

check-gl: gl-tests ## the tests of the OpenGL backend
	@tests/run $(gl_tests)

check-reference: reference-tests ## the tests of the ray-traced reference
	@tests/run $(call reference_tests,$(config))

# Percentages of lines and of branches that the tests must reach.
coverage_goals := deepgbuffer.h:98:90 deepgbuffer_gl.h:95:85

coverage: ## what lines and branches of the headers the tests reach (gcov); fails below the goals
	@$(MAKE) config=coverage CC=gcc CXX=g++ core-tests gl-tests
	@find build/coverage -name '*.gcda' -delete
	@tests/run $(call core_tests,coverage) $(call tests_in,gl,coverage)
	@tests/coverage build/coverage/obj/tests/support/deepgbuffer.gcda $(coverage_goals)

COUNT ?= 200
SEED ?= 1
mutate: core-tests ## how many of COUNT=200 mistakes, by SEED=1, in the core's mathematics tests/unit notices (>= 90 %)
	@OBJECTS=$(B) COUNT=$(COUNT) SEED=$(SEED) tests/mutate/mutate.sh

examples: $(examples) ## build every example
	@$(if $(imgui),:,echo "examples: viewer left out: Dear ImGui is missing (Debian, Ubuntu: libimgui-dev)")
	@$(if $(sdl2),:,echo "examples: integrations/sdl2 left out: SDL2 is missing (Debian, Ubuntu: libsdl2-dev)")

bench: $(benchmarks) ## build and run the benchmarks, quickly; SCENES="FILE@CAMERA ..." adds scenes
	@set -e; for program in $^; do $$program --quick $(SCENES); done

SECONDS ?= 20
fuzz: ## run each fuzz target for SECONDS=20 on inputs that libFuzzer makes up; an hour each finds more
	@$(MAKE) config=sanitize fuzz-targets
	@$(if $(fuzzer),$(MAKE) config=fuzz fuzz-targets)
	@TEST_TIMEOUT=0 FUZZ_SECONDS=$(SECONDS) tests/run $(fuzz_tests)

gpu-cost: gpu-tests ## what the shaders cost on a GPU, compiled offline: a table, and build/gpu_cost.csv
	@$(if $(vulkan),$(gpu_cost),echo "gpu-cost: skipped: libvulkan is missing (Debian, Ubuntu: libvulkan-dev)")

trade: $(B)/trade ## measure errors and costs of all settings; QUICK=1, SCENES="FILE@CAMERA ..." in place of ours
	@$< $(if $(QUICK),--quick) $(SCENES)

budget: $(B)/trade ## measure the settings of which dgb_preset_for picks, and write its table; SCENES="FILE@CAMERA ..."
	@$< --budget $(SCENES)

# Where `make install` puts what, below DESTDIR. The headers are the same for every machine, and so is what says where
# they are.
prefix     ?= /usr/local
includedir  = $(prefix)/include
pkgconfigdir = $(prefix)/share/pkgconfig
headers    := deepgbuffer.h deepgbuffer_gl.h
version     = $(shell sed -n 's/^\#define DGB_VERSION_STRING "\(.*\)"/\1/p' deepgbuffer.h)

define pkg_config_file
includedir=$(includedir)

Name: deepgbuffer
Description: Layered G-buffers and the shading they make possible: single-header libraries
Version: $(version)
Cflags: -I$${includedir}
Libs: -lm
endef

install: export text = $(pkg_config_file)
install: ## copy the headers and a pkg-config file below prefix=/usr/local (and DESTDIR)
	@install -d '$(DESTDIR)$(includedir)' '$(DESTDIR)$(pkgconfigdir)'
	@install -m 644 $(headers) '$(DESTDIR)$(includedir)'
	@echo "$$text" >'$(DESTDIR)$(pkgconfigdir)/deepgbuffer.pc'

uninstall: ## remove them again; give the same prefix and DESTDIR
	@cd '$(DESTDIR)$(includedir)' && rm -f $(headers)
	@rm -f '$(DESTDIR)$(pkgconfigdir)/deepgbuffer.pc'

embed: build/embed ## write shaders_embedded/*.glsl into deepgbuffer_gl.h
	@build/embed deepgbuffer_gl.h $(sort $(wildcard shaders_embedded/*.glsl))

embed-check: build/embed ## fail when deepgbuffer_gl.h differs from shaders_embedded/
	@build/embed --check deepgbuffer_gl.h $(sort $(wildcard shaders_embedded/*.glsl))

shaders-check: ## validate every shader variant with glslangValidator
	@tests/run $(shader_tests)

our_c   := $(wildcard examples/*.c examples/*/*.c tests/*/*.c shaders_embedded/*.c)
our_cpp := $(wildcard examples/*.cpp examples/*/*.cpp tests/*/*.cpp)
our_h   := $(wildcard *.h examples/*.h examples/*/*.h examples/*.hpp tests/*/*.h tests/*/*.hpp)

format: ## fail when a source is not formatted
	@clang-format --dry-run -Werror $(our_h) $(our_c) $(our_cpp)

format-fix: ## format the sources
	@clang-format -i $(our_h) $(our_c) $(our_cpp)

tidy: private our_c := $(filter-out $(if $(vulkan),,tests/gpu_cost/%) $(if $(sdl2),,%/sdl2.c),$(our_c))
tidy: private our_cpp := $(filter-out $(if $(imgui),,$(viewer_sources)),$(our_cpp))
tidy: ## run clang-tidy on the headers, the examples and the tests
	@clang-tidy --quiet $(our_c) -- -std=c99 $(CPPFLAGS)
	@clang-tidy --quiet $(our_cpp) -- -std=c++17 $(CPPFLAGS)

clean: ## remove build/
	@rm -rf build

core-tests: $(call core_tests,$(config))
gl-tests: $(gl_tests)
gpu-tests: $(if $(vulkan),$(gpu_cost))
reference-tests: $(call reference_tests,$(config))
scene-tests: $(call scene_tests,$(config))
fuzz-targets: $(call fuzz_targets,$(config))

# >> rules: objects, archives, programs

say = @mkdir -p $(@D) && echo "  $(1) $@"

$(B)/obj/%.o: %.c Makefile
	$(call say,cc  )
	@$(CC) $(CPPFLAGS) $(CFLAGS) -MMD -MP -c $< -o $@

$(B)/obj/%.o: %.cpp Makefile
	$(call say,c++ )
	@$(CXX) $(CPPFLAGS) $(CXXFLAGS) -MMD -MP -c $< -o $@

# Where tinygltf comes as headers only, this file compiles it.
ifeq ($(shell pkg-config --libs-only-l tinygltf 2>/dev/null),)
$(B)/obj/examples/scene_gltf.o: CPPFLAGS += -DTINYGLTF_IMPLEMENTATION -DSTB_IMAGE_IMPLEMENTATION
gltf :=
else
gltf := tinygltf $(shell pkg-config --exists stb && echo stb)
endif

$(B)/examples.a: $(call objects,$(example_parts))
$(B)/integrations.a: $(call objects,$(integration_parts))
$(B)/support.a: $(call objects,$(support))
$(B)/reference.a: $(call objects,$(reference))
$(B)/%.a:
	$(call say,ar  )
	@rm -f $@ && $(AR) rcs $@ $^

link = @$(1) $(flags) $(LDFLAGS) $^ $(call libs,$(2)) -o $@

c_examples   := $(call programs,$(filter %.c,$(example_sources)))
cpp_examples := $(call programs,$(filter %.cpp,$(example_sources)))

$(c_examples): $(B)/%: $(B)/obj/examples/%.o $(B)/examples.a
	$(call say,link)
	$(call link,$(CC),egl epoxy glfw3)

$(cpp_examples): $(B)/%: $(B)/obj/examples/%.o $(B)/examples.a
	$(call say,link)
	$(call link,$(CXX),egl epoxy $(gltf))

$(integrations): $(B)/%: $(B)/obj/examples/%.o $(B)/integrations.a
	$(call say,link)
	$(call link,$(CXX),egl epoxy $(sdl2))

$(B)/viewer: $(call objects,$(viewer_sources)) $(B)/examples.a
	$(call say,link)
	$(call link,$(CXX),imgui glfw3 epoxy $(gltf))

scene_loader := $(call objects,examples/scene_gltf.cpp examples/scene_pose.cpp)

$(call scene_tests,$(config)): $(B)/%: $(B)/obj/%.o $(scene_loader)
	$(call say,link)
	$(call link,$(CXX),cmocka $(gltf))

# What a fuzz target may call: the library, the recording backend, the loader of scenes. The driver stands in for
# libFuzzer.
fuzzed := $(call objects,tests/fuzz/fuzz.c tests/support/deepgbuffer.c tests/support/record_backend.c \
    $(if $(filter-out fuzz,$(config)),tests/fuzz/driver.c)) $(scene_loader)

$(call fuzz_targets,$(config)): $(B)/%: $(B)/obj/%.o $(fuzzed)
	$(call say,link)
	$(call link,$(CXX) $(if $(filter fuzz,$(config)),-fsanitize=fuzzer),cmocka $(gltf))

$(call core_tests,$(config)): $(B)/%: $(B)/obj/%.o $(B)/support.a
	$(call say,link)
	$(call link,$(CC),cmocka)

$(gl_tests): $(B)/%: $(B)/obj/%.o $(B)/support.a $(B)/obj/examples/headless.o
	$(call say,link)
	$(call link,$(CC),cmocka egl epoxy)

$(gpu_cost): $(call objects,$(wildcard tests/gpu_cost/*.c))
	$(call say,link)
	$(call link,$(CC),vulkan)

$(filter-out $(reference_benchmarks),$(benchmarks)): $(B)/%: $(B)/obj/%.o $(B)/support.a $(B)/examples.a
	$(call say,link)
	$(call link,$(CXX),egl epoxy $(gltf))

# Embree comes without a pkg-config file.
embree = -lembree$(if $(shell $(CXX) -E -include embree4/rtcore.h -x c++ /dev/null >/dev/null 2>&1 && echo yes),4,3)

$(reference_benchmarks): $(B)/%: $(B)/obj/%.o $(B)/reference.a $(B)/support.a $(B)/examples.a
	$(call say,link)
	$(call link,$(CXX),egl epoxy $(gltf)) $(embree) -pthread

$(B)/trade: $(call objects,$(wildcard tests/trade/*.cpp)) $(B)/reference.a $(B)/support.a $(B)/examples.a
	$(call say,link)
	$(call link,$(CXX),egl epoxy $(gltf)) $(embree) -pthread

$(call reference_tests,$(config)): $(B)/%: $(B)/obj/%.o $(B)/reference.a $(B)/support.a $(B)/examples.a
	$(call say,link)
	$(call link,$(CXX),cmocka egl epoxy $(gltf)) $(embree) -pthread

build/embed: shaders_embedded/embed.c
	$(call say,cc  )
	@$(CC) -std=c99 -pedantic $(warnings) -O1 $< -o $@

-include $(wildcard $(B)/obj/*/*.d $(B)/obj/*/*/*.d)
