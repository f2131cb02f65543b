#define EGL_NO_X11
#include "headless.h"

#include <EGL/egl.h>
#include <EGL/eglext.h>

#include <stdio.h>
#include <string.h>

/* Whole words only: one extension name may be the beginning of another. */
static bool has_extension(EGLDisplay display, const char* name) {
    const char* list = eglQueryString(display, EGL_EXTENSIONS);
    const size_t length = strlen(name);
    while (list != NULL && (list = strstr(list, name)) != NULL) {
        if (list[length] == ' ' || list[length] == '\0') { return true; }
        list += length;
    }
    return false;
}

static EGLDisplay platform_display(EGLenum platform, void* native) {
    PFNEGLGETPLATFORMDISPLAYEXTPROC get_platform_display =
        (PFNEGLGETPLATFORMDISPLAYEXTPROC)eglGetProcAddress("eglGetPlatformDisplayEXT");
    return get_platform_display != NULL ? get_platform_display(platform, native, NULL) : EGL_NO_DISPLAY;
}

static EGLDisplay surfaceless_display(void) {
    if (!has_extension(EGL_NO_DISPLAY, "EGL_MESA_platform_surfaceless")) { return EGL_NO_DISPLAY; }
    return platform_display(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY);
}

static EGLDisplay default_display(void) { return eglGetDisplay(EGL_DEFAULT_DISPLAY); }

static EGLDisplay first_device_display(void) {
    PFNEGLQUERYDEVICESEXTPROC query_devices = (PFNEGLQUERYDEVICESEXTPROC)eglGetProcAddress("eglQueryDevicesEXT");
    EGLDeviceEXT device;
    EGLint count = 0;
    if (query_devices == NULL || !query_devices(1, &device, &count) || count == 0) { return EGL_NO_DISPLAY; }
    return platform_display(EGL_PLATFORM_DEVICE_EXT, device);
}

/* Returns the first display that initializes, or EGL_NO_DISPLAY. */
static EGLDisplay open_display(void) {
    EGLDisplay (*const candidates[])(void) = {surfaceless_display, default_display, first_device_display};
    for (size_t i = 0; i < sizeof candidates / sizeof *candidates; ++i) {
        EGLDisplay display = candidates[i]();
        if (display != EGL_NO_DISPLAY && eglInitialize(display, NULL, NULL)) { return display; }
    }
    return EGL_NO_DISPLAY;
}

static EGLContext open_context(EGLDisplay display, int major, int minor, bool gles, bool debug) {
    const EGLint config_attributes[] = {EGL_SURFACE_TYPE, EGL_DONT_CARE, EGL_RENDERABLE_TYPE,
                                        gles ? EGL_OPENGL_ES3_BIT : EGL_OPENGL_BIT, EGL_NONE};
    EGLConfig config;
    EGLint config_count = 0;
    if (!eglChooseConfig(display, config_attributes, &config, 1, &config_count) || config_count == 0) {
        return EGL_NO_CONTEXT;
    }
    /* The profile stands last, where OpenGL ES, which has no profiles, ends the list early. */
    const EGLint context_attributes[] = {EGL_CONTEXT_MAJOR_VERSION,
                                         major,
                                         EGL_CONTEXT_MINOR_VERSION,
                                         minor,
                                         EGL_CONTEXT_OPENGL_DEBUG,
                                         debug ? EGL_TRUE : EGL_FALSE,
                                         gles ? EGL_NONE : EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                         EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                         EGL_NONE};
    return eglCreateContext(display, config, EGL_NO_CONTEXT, context_attributes);
}

/* For use by headless_create: reports and undoes what was done so far. */
static bool give_up(headless* h, char* error, size_t error_size, const char* what) {
    snprintf(error, error_size, "%s (EGL error 0x%04x)", what, (unsigned)eglGetError());
    headless_destroy(h);
    return false;
}

bool headless_create(headless* h, int major, int minor, bool gles, bool debug, char* error, size_t error_size) {
    h->context = EGL_NO_CONTEXT;
    h->display = open_display();
    if (h->display == EGL_NO_DISPLAY) {
        return give_up(
            h, error, error_size,
            "no EGL display can be opened: a driver is missing. Without a GPU Mesa's software rasteriser will do "
            "(Debian, Ubuntu: libegl-mesa0 libgl1-mesa-dri)");
    }
    if (!has_extension(h->display, "EGL_KHR_surfaceless_context")) {
        return give_up(h, error, error_size, "EGL_KHR_surfaceless_context is missing");
    }
    if (!eglBindAPI(gles ? EGL_OPENGL_ES_API : EGL_OPENGL_API)) {
        return give_up(h, error, error_size, "EGL does not offer this OpenGL API");
    }
    h->context = open_context(h->display, major, minor, gles, debug);
    if (h->context == EGL_NO_CONTEXT) {
        return give_up(h, error, error_size,
                       "no context of this OpenGL version can be created: a newer driver, or LIBGL_ALWAYS_SOFTWARE=1, "
                       "may offer it");
    }
    if (!headless_make_current(h)) { return give_up(h, error, error_size, "the context cannot be made current"); }
    return true;
}

bool headless_make_current(const headless* h) {
    return eglMakeCurrent(h->display, EGL_NO_SURFACE, EGL_NO_SURFACE, h->context) == EGL_TRUE;
}

/* Displays are shared by the whole process. Terminating one would take away the contexts that others
   still have on it, so only the context goes. */
void headless_destroy(headless* h) {
    if (h->context != EGL_NO_CONTEXT) {
        if (eglGetCurrentContext() == h->context) {
            eglMakeCurrent(h->display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
        }
        eglDestroyContext(h->display, h->context);
    }
    h->display = EGL_NO_DISPLAY;
    h->context = EGL_NO_CONTEXT;
}

void* headless_get_proc(const char* name) {
    /* ISO C has no cast from a function pointer to void*, but POSIX gives both the same representation. */
    __eglMustCastToProperFunctionPointerType function = eglGetProcAddress(name);
    void* address;
    memcpy(&address, &function, sizeof address);
    return address;
}
