/* The library in C++: an owner that can be moved and not copied, errors as exceptions with the library's own sentence.
   build  make build/release/integrations/raii
   run    build/release/integrations/raii FILE.ppm     the picture of ao_depth, and the errors of wrong calls
   copy   the class between `>> deepgbuffer` and `<< deepgbuffer`, 50 lines; give it the effects and calls that you use */
#include "engine.h"

#include <cstdio>
#include <type_traits>
#include <utility>

/* >> deepgbuffer */
#define DEEPGBUFFER_IMPLEMENTATION
#include "deepgbuffer.h"
#include "deepgbuffer_gl.h"

#include <memory>
#include <stdexcept>
#include <string>

class DeepGBuffer {
public:
    class Error : public std::runtime_error {
    public:
        Error(dgb_result why, const std::string& sentence) : std::runtime_error(sentence), result(why) {}
        dgb_result result;
    };

    DeepGBuffer(dgbgl_get_proc_fn get_proc, dgb_desc desc) : state_(new State) {
        dgbgl_desc gl_desc{};
        gl_desc.get_proc = get_proc;
        gl_desc.message = [](void* state, const char* text) { static_cast<State*>(state)->sentence = text; };
        gl_desc.message_user = state_.get();
        check(dgbgl_init(&state_->gl, &gl_desc));
        desc.backend = &state_->gl.backend;
        desc.log = [](void* state, dgb_result, dgb_log_item, const char* sentence) {
            static_cast<State*>(state)->sentence = sentence;
        };
        desc.log_user = state_.get();
        check(dgb_init(&state_->context, &desc));
    }

    void set_layers(const dgb_view& view, const dgb_layers& layers) {
        check(dgb_set_layers(&state_->context, &view, &layers));
    }
    void shade(const dgb_params& params) { check(dgb_shade(&state_->context, &params)); }
    GLuint texture(dgb_slot slot) const { return dgbgl_texture_name(dgb_get_texture(&state_->context, slot)); }

private:
    struct State { // on the heap, since the context and the log keep its address when the owner moves
        dgbgl_backend gl{};
        dgb_context context{};
        std::string sentence;
        ~State() { dgb_shutdown(&context), dgbgl_shutdown(&gl); }
    };

    void check(dgb_result result) const {
        if (result != DGB_OK) { throw Error(result, std::string(dgb_result_name(result)) + ": " + state_->sentence); }
    }

    std::unique_ptr<State> state_;
};
/* << deepgbuffer */

namespace {

static_assert(!std::is_copy_constructible_v<DeepGBuffer>);
static_assert(!std::is_copy_assignable_v<DeepGBuffer>);
static_assert(std::is_nothrow_move_constructible_v<DeepGBuffer>);
static_assert(std::is_nothrow_move_assignable_v<DeepGBuffer>);

dgb_desc occlusion(int width, int height) {
    dgb_desc desc{};
    desc.width = width, desc.height = height, desc.layers = 1;
    desc.source = DGB_SOURCE_ENGINE;
    desc.effects = DGB_EFFECT_AO;
    return desc;
}

template <class Function>
void expect_error(Function wrong) {
    try {
        wrong();
        std::printf("no error\n");
    } catch (const DeepGBuffer::Error& error) { std::printf("error: %s\n", error.what()); }
}

void draw(const char* path) {
    DeepGBuffer first(engine_get_proc, occlusion(ENGINE_WIDTH, ENGINE_HEIGHT)), second = std::move(first);
    first = std::move(second); // and back: the context does not notice

    const dgb_view camera = {ENGINE_VIEW, ENGINE_PROJECTION, {}, false, false, {}};
    dgb_layers layers{};
    layers.depth[0] = dgbgl_texture(engine_draw_depth());
    first.set_layers(camera, layers);
    first.shade(dgb_preset(DGB_PRESET_BALANCED));
    engine_show(first.texture(DGB_AO));
    engine_save(path);

    expect_error([] { DeepGBuffer(engine_get_proc, occlusion(-1, ENGINE_HEIGHT)); });
    expect_error([] { DeepGBuffer(engine_get_proc, occlusion(64, 64)).shade(dgb_preset(DGB_PRESET_BALANCED)); });
}

} // namespace

int main(int argc, char** argv) {
    if (argc != 2) { engine_fail("give the FILE.ppm to write"); }
    engine_start(false);
    try {
        draw(argv[1]);
    } catch (const std::exception& error) { engine_fail(error.what()); }
    engine_stop();
}
