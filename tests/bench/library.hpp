// A context that a benchmark drives itself, with a clock for its passes.
#pragma once

#include "bench.hpp"

#include "deepgbuffer.h"
#include "deepgbuffer_gl.h"

#include <glm/gtc/type_ptr.hpp>

#include <chrono>
#include <ctime>
#include <map>

// ---- Clocks ---------------------------------------------------------------------------------------------

inline double wall_ms() {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

// Does not mind a busy machine, but counts all threads.
inline double process_ms() {
    timespec now{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return double(now.tv_sec) * 1e3 + double(now.tv_nsec) * 1e-6;
}

// The clock that decides: where the renderer is software, the process's.
inline double deciding_ms() {
    static const bool software = is_software_rasteriser();
    return software ? process_ms() : wall_ms();
}

// A stopwatch for passes that follow one another: the work itself, until the GPU is idle.
class PassClock {
public:
    void begin() {
        glFinish();
        start_ = deciding_ms();
    }
    void end(const std::string& pass) {
        glFinish();
        milliseconds_[pass].push_back(deciding_ms() - start_);
    }
    void forget() { milliseconds_.clear(); }
    const std::map<std::string, std::vector<double>>& milliseconds() const { return milliseconds_; }

private:
    double start_ = 0.0;
    std::map<std::string, std::vector<double>> milliseconds_; // one value a frame
};

// ---- Library --------------------------------------------------------------------------------------------

// A backend and a context. Neither may move: the context points to the backend, both point to `complaint`.
class Library {
public:
    // clock: of the passes; null: they are not timed. counts: DGB_REFLECTION_HIT holds lookups in place of lengths.
    explicit Library(dgb_desc desc, PassClock* clock = nullptr, bool counts = false,
                     dgbgl_get_proc_fn get_proc = headless_get_proc) {
        dgbgl_desc gl_desc{};
        gl_desc.get_proc = get_proc;
        gl_desc.no_timers = true; // a timer query may make a tiler flush
        gl_desc.message = [](void* user, const char* text) { static_cast<std::string*>(user)->append(text); };
        gl_desc.message_user = &complaint_;
        check(dgbgl_init(&backend_.gl, &gl_desc));
        backend_.clock = clock;
        backend_.gl.backend.marker = clock != nullptr ? mark : nullptr;
        backend_.create = backend_.gl.backend.program_create;
        if (counts) { backend_.gl.backend.program_create = create_counting; }
        desc.backend = &backend_.gl.backend;
        desc.log = [](void* user, dgb_result, dgb_log_item, const char* sentence) {
            static_cast<std::string*>(user)->append(sentence);
        };
        desc.log_user = &complaint_;
        check(dgb_init(&context_, &desc));
    }
    Library(const Library&) = delete;
    Library& operator=(const Library&) = delete;
    ~Library() {
        dgb_shutdown(&context_);
        dgbgl_shutdown(&backend_.gl);
    }

    const dgb_context* context() const { return &context_; }
    GLuint texture(dgb_slot slot) const { return dgbgl_texture_name(dgb_get_texture(&context_, slot)); }

    void build(const dgb_view& view, const dgb_params& params, dgb_draw_fn draw, void* user) {
        check(dgb_build(&context_, &view, &params, draw, user));
    }
    void set_layers(const dgb_view& view, const dgb_layers& layers) {
        check(dgb_set_layers(&context_, &view, &layers));
    }
    void shade(const dgb_params& params) { check(dgb_shade(&context_, &params)); }

    // Of a 2D texture, without guard band, bottom row first. format: GL_RED, GL_RG or GL_RGBA.
    std::vector<float> read(dgb_slot slot, GLenum format) const {
        const dgb_desc& desc = context_.desc;
        const size_t channels = format == GL_RED ? 1 : format == GL_RG ? 2 : 4;
        std::vector<float> pixels(channels * size_t(desc.width) * size_t(desc.height));
        const GlObject framebuffer = make_framebuffer();
        glBindFramebuffer(GL_READ_FRAMEBUFFER, framebuffer.name());
        glFramebufferTexture2D(GL_READ_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, texture(slot), 0);
        glReadBuffer(GL_COLOR_ATTACHMENT0);
        glReadPixels(desc.guard_band, desc.guard_band, desc.width, desc.height, format, GL_FLOAT, pixels.data());
        return pixels;
    }

private:
    struct TimedBackend {
        dgbgl_backend gl; // first: the callbacks get its address
        PassClock* clock;
        dgb_result (*create)(void*, const dgb_program_desc*, dgb_program*);
    };

    static void mark(void* user, dgb_pass_id pass, bool begin) {
        PassClock* clock = static_cast<const TimedBackend*>(user)->clock;
        begin ? clock->begin() : clock->end(dgb_pass_name(pass));
    }

    static dgb_result create_counting(void* user, const dgb_program_desc* desc, dgb_program* program) {
        dgb_program_desc counting = *desc;
        if (desc->pass == DGB_PASS_REFLECT) { counting.defines[counting.define_count++] = {"DGB_COUNT_LOOKUPS", 1}; }
        return static_cast<const TimedBackend*>(user)->create(user, &counting, program);
    }

    void check(dgb_result result) const {
        if (result != DGB_OK) { throw std::runtime_error(std::string(dgb_result_name(result)) + ": " + complaint_); }
    }

    std::string complaint_;
    TimedBackend backend_{};
    dgb_context context_{};
};

inline dgb_view to_dgb_view(const glm::mat4& view, const glm::mat4& projection) {
    dgb_view result{};
    std::copy_n(glm::value_ptr(view), 16, result.view);
    std::copy_n(glm::value_ptr(projection), 16, result.projection);
    return result;
}
