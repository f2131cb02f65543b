#include "gl_session.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

static void on_message(void* user, const char* text) {
    (void)text;
    ++((gl_session*)user)->messages;
}

static void on_log(void* user, dgb_result result, dgb_log_item item, const char* sentence) {
    gl_session* s = (gl_session*)user;
    (void)result, (void)sentence;
    ++s->logs;
    s->logged = item;
}

/* Whether the call went well. `item`: what it logs when it fails; NONE where it has messages only. */
static bool went_well(gl_session* s, const char* call, dgb_result result, dgb_log_item item, dgb_log_item or_item) {
    const int logs = s->logs, messages = s->messages;
    s->logs = s->messages = 0;
    if (s->after && !s->is_lost) s->after(s->user, call);
    if (result == DGB_OK) {
        if (logs) fail_msg("%s goes well and logs %s", call, dgb_log_item_name(s->logged));
        return true;
    }
    ++s->failures;
    s->failed = call;
    s->result = result;
    if (s->is_lost) return false;
    if (result != DGB_OUT_OF_MEMORY && result != DGB_DEVICE) fail_msg("%s: %s", call, dgb_result_name(result));
    if (item && (logs != 1 || (s->logged != item && s->logged != or_item)))
        fail_msg("%s: %s, %d logged, %s", call, dgb_result_name(result), logs, dgb_log_item_name(s->logged));
    if (!item && !messages) fail_msg("%s: %s, and no message", call, dgb_result_name(result));
    return false;
}

static bool start_backend(gl_session* s, dgbgl_backend* gl) {
    s->gl.message = on_message;
    s->gl.message_user = s;
    return went_well(s, "dgbgl_init", dgbgl_init(gl, &s->gl), DGB_LOG_NONE, DGB_LOG_NONE);
}

static bool start_context(gl_session* s, dgbgl_backend* gl, dgb_context* c) {
    s->desc.backend = &gl->backend;
    s->desc.log = on_log;
    s->desc.log_user = s;
    return went_well(s, "dgb_init", dgb_init(c, &s->desc), DGB_LOG_TEXTURE, DGB_LOG_PROGRAM);
}

/* dgbgl_attach_program tells by its result alone. */
static unsigned int make_program(gl_session* s, const dgb_context* c) {
    unsigned int program = s->make_program ? s->make_program(s->user, c) : 1;
    if (program) return program;
    ++s->failures;
    s->failed = "dgbgl_attach_program";
    return s->is_lost ? 0 : s->make_program(s->user, c);
}

static void run_frame(gl_session* s, dgb_context* c, int frame) {
    static const float projection[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, -1.002f, -1, 0, 0, -0.2002f, 0};
    const dgb_params q = dgb_preset((dgb_preset_id)(frame % DGB_PRESET_COUNT));
    dgb_view view;
    bool built;
    memset(&view, 0, sizeof view);
    memcpy(view.projection, projection, sizeof projection);
    view.view[0] = view.view[5] = view.view[10] = view.view[15] = 1.0f;
    view.view[12] = 0.05f * (float)frame;
    view.view[13] = -1.7f;
    view.view[14] = -5.0f;
    if (s->layers)
        built = went_well(s, "dgb_set_layers", dgb_set_layers(c, &view, s->layers), DGB_LOG_INPUT, DGB_LOG_INPUT);
    else
        built = went_well(s, "dgb_build", dgb_build(c, &view, &q, s->draw, s->user), DGB_LOG_PASS, DGB_LOG_PASS);
    if (built) (void)went_well(s, "dgb_shade", dgb_shade(c, &q), DGB_LOG_PASS, DGB_LOG_PASS);
}

static bool resize(gl_session* s, dgb_context* c) {
    const dgb_result result = dgb_resize(c, s->desc.width + 7, s->desc.height + 3);
    return went_well(s, "dgb_resize", result, DGB_LOG_TEXTURE, DGB_LOG_TEXTURE);
}

static void run_context(gl_session* s, dgb_context* c) {
    const unsigned int program = make_program(s, c);
    int frame;
    if (!program) return;
    for (frame = 0; frame < 3; ++frame) run_frame(s, c, frame);
    if (!resize(s, c) && !s->is_lost) assert_true(resize(s, c));
    for (; frame < 6; ++frame) run_frame(s, c, frame);
    if (s->end_of_frames) s->end_of_frames(s->user, c);
    if (s->delete_program) s->delete_program(s->user, program);
}

void gl_session_run(gl_session* s) {
    dgbgl_backend gl;
    dgb_context c;
    s->failures = s->logs = s->messages = 0;
    s->failed = "";
    memset(&c, 0, sizeof c);
    if (!start_backend(s, &gl)) {
        if (s->is_lost) return;
        assert_true(start_backend(s, &gl));
    }
    if (start_context(s, &gl, &c) || (!s->is_lost && start_context(s, &gl, &c))) run_context(s, &c);
    dgb_shutdown(&c);
    (void)went_well(s, "dgb_shutdown", DGB_OK, DGB_LOG_NONE, DGB_LOG_NONE);
    dgbgl_shutdown(&gl);
    (void)went_well(s, "dgbgl_shutdown", DGB_OK, DGB_LOG_NONE, DGB_LOG_NONE);
    if (!s->is_lost) assert_true(s->failures <= 1);
}
