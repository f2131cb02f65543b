/* Ambient occlusion for an engine that has a depth buffer and nothing else: no normals, no second layer.
   build  make build/release/integrations/ao_depth
   run    build/release/integrations/ao_depth FILE.ppm     writes the ambient visibility as a grey picture
   copy   what stands between `>> deepgbuffer` and `<< deepgbuffer`: all that the engine adds, in 30 lines */
#include "engine.h"

/* >> deepgbuffer */
#define DEEPGBUFFER_IMPLEMENTATION
#include "deepgbuffer.h"
#include "deepgbuffer_gl.h"

static dgbgl_backend gl;
static dgb_context dgb;

static bool create_ao(int width, int height) {
    const dgbgl_desc gl_desc = {.get_proc = engine_get_proc, .message = engine_on_message};
    dgb_desc desc = {.width = width, .height = height, .layers = 1, .backend = &gl.backend};
    desc.source = DGB_SOURCE_ENGINE; /* and normals derived from depth: the default */
    desc.effects = DGB_EFFECT_AO;
    return dgbgl_init(&gl, &gl_desc) == DGB_OK && dgb_init(&dgb, &desc) == DGB_OK;
}

/* The name of a GL_TEXTURE_2D that holds ambient visibility, 1 = open. The library owns it. */
static GLuint shade_ao(GLuint depth_texture, const dgb_view* view) {
    const dgb_params params = dgb_preset(DGB_PRESET_BALANCED);
    const dgb_layers layers = {.depth = {dgbgl_texture(depth_texture)}};
    dgb_set_layers(&dgb, view, &layers);
    dgb_shade(&dgb, &params);
    return dgbgl_texture_name(dgb_get_texture(&dgb, DGB_AO));
}

static void destroy_ao(void) {
    dgb_shutdown(&dgb);
    dgbgl_shutdown(&gl);
}
/* << deepgbuffer */

static const dgb_view camera = {.view = ENGINE_VIEW, .projection = ENGINE_PROJECTION};

int main(int argc, char** argv) {
    if (argc != 2) engine_fail("give the FILE.ppm to write");
    engine_start(false);
    if (!create_ao(ENGINE_WIDTH, ENGINE_HEIGHT)) engine_fail("this OpenGL will not do");
    engine_show(shade_ao(engine_draw_depth(), &camera));
    engine_save(argv[1]);
    destroy_ao();
    engine_stop();
    return 0;
}
