/* SDL2 in place of GLFW: the context, the loader, the size in pixels.
   build  make build/release/integrations/sdl2     (needs SDL2: on Debian and Ubuntu libsdl2-dev)
   run    build/release/integrations/sdl2 [FILE.ppm]     the picture of ao_depth in a window, or in the file as well
   copy   what stands between `>> deepgbuffer` and `<< deepgbuffer`, 30 lines, and the attributes of open_window */
#include "engine.h"

#include <SDL.h>

/* >> deepgbuffer */
#define DEEPGBUFFER_IMPLEMENTATION
#include "deepgbuffer.h"
#include "deepgbuffer_gl.h"

static dgbgl_backend gl;
static dgb_context dgb;

/* After SDL_GL_CreateContext: the addresses are those of the current context. */
static bool create_ao(SDL_Window* window) {
    const dgbgl_desc gl_desc = {.get_proc = SDL_GL_GetProcAddress, .message = engine_on_message};
    dgb_desc desc = {.layers = 1, .effects = DGB_EFFECT_AO, .source = DGB_SOURCE_ENGINE, .backend = &gl.backend};
    SDL_GL_GetDrawableSize(window, &desc.width, &desc.height); /* pixels; SDL_GetWindowSize may count points */
    return dgbgl_init(&gl, &gl_desc) == DGB_OK && dgb_init(&dgb, &desc) == DGB_OK;
}

static GLuint shade_ao(GLuint depth_texture, const dgb_view* view) {
    const dgb_params params = dgb_preset(DGB_PRESET_BALANCED);
    const dgb_layers layers = {.depth = {dgbgl_texture(depth_texture)}};
    dgb_set_layers(&dgb, view, &layers);
    dgb_shade(&dgb, &params);
    return dgbgl_texture_name(dgb_get_texture(&dgb, DGB_AO));
}

static void destroy_ao(void) { /* before SDL_GL_DeleteContext */
    dgb_shutdown(&dgb);
    dgbgl_shutdown(&gl);
}
/* << deepgbuffer */

static const dgb_view camera = {.view = ENGINE_VIEW, .projection = ENGINE_PROJECTION};

static SDL_Window* open_window(void) {
    SDL_Window* window;
    if (SDL_Init(SDL_INIT_VIDEO)) engine_fail(SDL_GetError());
    SDL_GL_SetAttribute(SDL_GL_CONTEXT_MAJOR_VERSION, 3);
    SDL_GL_SetAttribute(SDL_GL_CONTEXT_MINOR_VERSION, 3);
    SDL_GL_SetAttribute(SDL_GL_CONTEXT_PROFILE_MASK, SDL_GL_CONTEXT_PROFILE_CORE);
    window = SDL_CreateWindow("deepgbuffer", SDL_WINDOWPOS_UNDEFINED, SDL_WINDOWPOS_UNDEFINED, ENGINE_WIDTH,
                              ENGINE_HEIGHT, SDL_WINDOW_OPENGL);
    if (!window) engine_fail(SDL_GetError());
    return window;
}

static bool quits(void) {
    SDL_Event event;
    while (SDL_PollEvent(&event))
        if (event.type == SDL_QUIT) return true;
    return false;
}

int main(int argc, char** argv) {
    SDL_Window* window;
    SDL_GLContext context;
    if (argc > 2) engine_fail("give no arguments, or the FILE.ppm to write");
    window = open_window();
    context = SDL_GL_CreateContext(window);
    if (!context) engine_fail(SDL_GetError());
    if (!create_ao(window)) engine_fail("this OpenGL will not do");
    do {
        GLuint depth = engine_draw_depth();
        engine_show(shade_ao(depth, &camera));
        glDeleteTextures(1, &depth);
        if (argc == 2) engine_save(argv[1]);
        SDL_GL_SwapWindow(window);
    } while (argc == 1 && !quits());
    destroy_ao();
    SDL_GL_DeleteContext(context);
    SDL_DestroyWindow(window);
    SDL_Quit();
    return 0;
}
