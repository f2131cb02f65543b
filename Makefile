# deepgbuffer: two single-header libraries, their examples and their tests. `make help` lists the targets.
#
# Sources are found by name: a new tests/unit/test_NAME.c or examples/NAME.c needs no change here.

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
flags := $(flags_$(config))
$(if $(flags),,$(error config=$(config): choose debug, release, sanitize, fastmath or coverage))

# Third-party headers come in as system headers: their warnings are not ours.
packages := egl epoxy glfw3 imgui cmocka glm CLI11 stb tinygltf vulkan
third_party := $(patsubst -I%,-isystem %,$(foreach p,$(packages),$(shell pkg-config --cflags-only-I $(p) 2>/dev/null)))
vulkan := $(shell pkg-config --exists vulkan 2>/dev/null && echo vulkan)
imgui := $(shell pkg-config --exists imgui 2>/dev/null && echo imgui)
libs = $(if $(1),$(shell pkg-config --libs $(1))) -lm

warnings := -Wall -Wextra -Wshadow -Wconversion -Werror
CPPFLAGS += -I. -Iexamples -Itests/support -Itests/reference -Itests/bench $(third_party)
CFLAGS   := -std=c99 -pedantic $(warnings) -ffp-contract=off $(flags)
CXXFLAGS := -std=c++17 $(warnings) -ffp-contract=off $(flags)
export CC CXX

# >> sources and programs

objects = $(patsubst %,$(B)/obj/%.o,$(basename $(1)))
program_names = $(basename $(notdir $(1)))

# What several programs share is an archive: a program takes in only the parts it uses.
example_parts   := $(sort $(wildcard examples/scene*.cpp) $(wildcard examples/image.cpp examples/headless.c))
viewer_sources  := $(wildcard examples/viewer*.cpp)
example_sources := $(filter-out $(example_parts) $(viewer_sources),$(wildcard examples/*.c examples/*.cpp))
examples        := $(addprefix $(B)/,$(call program_names,$(example_sources)) $(if $(imgui),viewer))
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

source_tests  := tests/compile/compile.sh tests/shaders/embed.sh
shader_tests  := tests/shaders/check.sh
gpu_tests     := tests/gpu_cost/check.sh
example_tests := $(wildcard tests/examples/*.sh)

# >> targets

.PHONY: all help setup demo test test-full check check-core check-gl check-reference examples bench gpu-cost core-tests gl-tests \
        gpu-tests reference-tests trade budget embed embed-check shaders-check format format-fix tidy clean
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

test: setup ## set up, build and run every test
	@$(MAKE) config=release examples core-tests gl-tests gpu-tests reference-tests build/release/trade
	@$(MAKE) config=sanitize core-tests
	@$(MAKE) config=fastmath core-tests
	@tests/run $(source_tests) $(shader_tests) $(gpu_tests) \
	    $(foreach c,release sanitize fastmath,$(call core_tests,$(c))) $(call tests_in,gl,release) \
	    $(call reference_tests,release) tests/trade/trade.sh $(example_tests)

# Loops that CI takes samples of, whole; and the OpenGL backend under valgrind, where there is one. Half an hour.
full_tests := build/sanitize/tests/backends/test_gl_faults build/release/tests/gl/test_guest
valgrind := $(shell command -v valgrind)
test-full: ## what is too long for `make test`: every fault in turn, state by more seeds, valgrind
	@$(MAKE) config=sanitize build/sanitize/tests/backends/test_gl_faults
	@$(MAKE) config=release build/release/tests/gl/test_guest
	@$(MAKE) config=debug build/debug/tests/backends/test_gl_faults
	@DGB_FULL=1 TEST_TIMEOUT=7200 tests/run $(full_tests)
	@$(if $(valgrind),$(valgrind) --quiet --error-exitcode=1 --leak-check=full build/debug/tests/backends/test_gl_faults, \
	    echo "test-full: valgrind is missing")

check: ## the tests that need no GPU and no package: compilation, symbols, embedded shaders
	@tests/run $(source_tests)

check-core: core-tests ## the tests of the core, which need no GPU
	@tests/run $(call core_tests,$(config))

check-gl: gl-tests ## the tests of the OpenGL backend
	@tests/run $(gl_tests)

check-reference: reference-tests ## the tests of the ray-traced reference
	@tests/run $(call reference_tests,$(config))

examples: $(examples) ## build every example
	@$(if $(imgui),:,echo "examples: viewer left out: Dear ImGui is missing (Debian, Ubuntu: libimgui-dev)")

bench: $(benchmarks) ## build and run the benchmarks, quickly; SCENES="FILE@CAMERA ..." adds scenes
	@set -e; for program in $^; do $$program --quick $(SCENES); done

gpu-cost: gpu-tests ## what the shaders cost on a GPU, compiled offline: a table, and build/gpu_cost.csv
	@$(if $(vulkan),$(gpu_cost),echo "gpu-cost: skipped: libvulkan is missing (Debian, Ubuntu: libvulkan-dev)")

trade: $(B)/trade ## measure errors and costs of all settings; QUICK=1, SCENES="FILE@CAMERA ..." in place of the procedural ones
	@$< $(if $(QUICK),--quick) $(SCENES)

budget: $(B)/trade ## measure the settings of which dgb_preset_for picks, and write its table; SCENES="FILE@CAMERA ..."
	@$< --budget $(SCENES)

embed: build/embed ## write shaders_embedded/*.glsl into deepgbuffer_gl.h
	@build/embed deepgbuffer_gl.h $(sort $(wildcard shaders_embedded/*.glsl))

embed-check: build/embed ## fail when deepgbuffer_gl.h differs from shaders_embedded/
	@build/embed --check deepgbuffer_gl.h $(sort $(wildcard shaders_embedded/*.glsl))

shaders-check: ## validate every shader variant with glslangValidator
	@tests/run $(shader_tests)

our_c   := $(wildcard examples/*.c tests/*/*.c shaders_embedded/*.c)
our_cpp := $(wildcard examples/*.cpp tests/*/*.cpp)
our_h   := $(wildcard *.h examples/*.h examples/*.hpp tests/*/*.h tests/*/*.hpp)

format: ## fail when a source is not formatted
	@clang-format --dry-run -Werror $(our_h) $(our_c) $(our_cpp)

format-fix: ## format the sources
	@clang-format -i $(our_h) $(our_c) $(our_cpp)

tidy: ## run clang-tidy on the headers, the examples and the tests
	@$(if $(our_c),clang-tidy --quiet $(filter-out $(if $(vulkan),,tests/gpu_cost/%),$(our_c)) -- -std=c99 $(CPPFLAGS))
	@$(if $(our_cpp),clang-tidy --quiet $(filter-out $(if $(imgui),,$(viewer_sources)),$(our_cpp)) -- -std=c++17 $(CPPFLAGS))

clean: ## remove build/
	@rm -rf build

core-tests: $(call core_tests,$(config))
gl-tests: $(gl_tests)
gpu-tests: $(if $(vulkan),$(gpu_cost))
reference-tests: $(call reference_tests,$(config))

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
$(B)/support.a: $(call objects,$(support))
$(B)/reference.a: $(call objects,$(reference))
$(B)/%.a:
	$(call say,ar  )
	@rm -f $@ && $(AR) rcs $@ $^

link = @$(1) $(flags) $(LDFLAGS) $^ $(call libs,$(2)) -o $@

c_examples   := $(addprefix $(B)/,$(call program_names,$(filter %.c,$(example_sources))))
cpp_examples := $(addprefix $(B)/,$(call program_names,$(filter %.cpp,$(example_sources))))

$(c_examples): $(B)/%: $(B)/obj/examples/%.o $(B)/examples.a
	$(call say,link)
	$(call link,$(CC),egl epoxy glfw3)

$(cpp_examples): $(B)/%: $(B)/obj/examples/%.o $(B)/examples.a
	$(call say,link)
	$(call link,$(CXX),egl epoxy $(gltf))

$(B)/viewer: $(call objects,$(viewer_sources)) $(B)/examples.a
	$(call say,link)
	$(call link,$(CXX),imgui glfw3 epoxy $(gltf))

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
