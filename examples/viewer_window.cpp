#include "viewer_window.hpp"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

namespace {

constexpr float kRadiansAPoint = 0.004f; // of mouse motion, in the window's coordinates
constexpr float kPadSpeed = 2.0f;        // rad/s
constexpr float kPadRest = 0.15f;        // a stick that is let go does not quite return to 0
constexpr double kSplitReach = 8.0;      // how near to the line the mouse takes hold of it

std::string reason() {
    const char* text = nullptr;
    glfwGetError(&text);
    return text != nullptr ? text : "no reason given";
}

GLFWwindow* open_context(int width, int height, const char* title, int major, int minor) {
    glfwDefaultWindowHints();
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, major);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, minor);
    glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
    glfwWindowHint(GLFW_OPENGL_FORWARD_COMPAT, GLFW_TRUE); // macOS has no other
    glfwWindowHint(GLFW_DEPTH_BITS, 0);
    glfwWindowHint(GLFW_STENCIL_BITS, 0);
    return glfwCreateWindow(width, height, title, nullptr, nullptr);
}

Events* events_of(GLFWwindow* window) { return static_cast<Events*>(glfwGetWindowUserPointer(window)); }

float beyond_rest(float stick) { return std::abs(stick) > kPadRest ? stick : 0.0f; }

void read_gamepad(float seconds, Steering* steering) {
    GLFWgamepadstate pad;
    if (glfwGetGamepadState(GLFW_JOYSTICK_1, &pad) != GLFW_TRUE) { return; }
    const auto axis = [&](int i) { return beyond_rest(pad.axes[i]); };
    // triggers rest at -1
    const float rise = 0.5f * (pad.axes[GLFW_GAMEPAD_AXIS_RIGHT_TRIGGER] - pad.axes[GLFW_GAMEPAD_AXIS_LEFT_TRIGGER]);
    steering->fly += glm::vec3(axis(GLFW_GAMEPAD_AXIS_LEFT_X), rise, -axis(GLFW_GAMEPAD_AXIS_LEFT_Y));
    steering->look_yaw -= kPadSpeed * seconds * axis(GLFW_GAMEPAD_AXIS_RIGHT_X);
    steering->look_pitch -= kPadSpeed * seconds * axis(GLFW_GAMEPAD_AXIS_RIGHT_Y);
}

} // namespace

// ---- Start and end --------------------------------------------------------------------------------------

Window::Window(int width, int height, const char* title) {
    if (glfwInit() != GLFW_TRUE) {
        throw std::runtime_error("there is no display (" + reason() +
                                 "); without one, run it as `xvfb-run -a` or use render, which needs none");
    }
    try {
        open(width, height, title);
    } catch (...) {
        glfwTerminate();
        throw;
    }
    init_gui();
}

void Window::open(int width, int height, const char* title) {
    window_ = open_context(width, height, title, 4, 5);
    if (window_ == nullptr) { window_ = open_context(width, height, title, 3, 3); }
    if (window_ == nullptr) {
        throw std::runtime_error("no window with OpenGL 3.3 (" + reason() +
                                 "); a newer driver, or LIBGL_ALWAYS_SOFTWARE=1, may offer it");
    }
    glfwMakeContextCurrent(window_);
    glfwSwapInterval(1);
    glfwSetWindowUserPointer(window_, &events_);
    glfwSetKeyCallback(window_, [](GLFWwindow* window, int key, int, int action, int) {
        if (action == GLFW_PRESS && !ImGui::GetIO().WantCaptureKeyboard) { events_of(window)->keys.push_back(key); }
    });
    glfwSetScrollCallback(window_, [](GLFWwindow* window, double, double up) {
        if (!ImGui::GetIO().WantCaptureMouse) { events_of(window)->wheel += up; }
    });
    glfwSetDropCallback(window_, [](GLFWwindow* window, int count, const char** paths) {
        events_of(window)->dropped.assign(paths, paths + count);
    });
}

// Letters as large as the screen wants them: where window coordinates are pixels, they are its content scale larger.
void Window::init_gui() {
    IMGUI_CHECKVERSION();
    ImGui::CreateContext();
    ImGui::GetIO().IniFilename = nullptr; // the panel leaves no file behind
    ImGui_ImplGlfw_InitForOpenGL(window_, true);
    ImGui_ImplOpenGL3_Init("#version 330 core");
    float scale = 1.0f;
    glfwGetWindowContentScale(window_, &scale, nullptr);
    scale *= float(size().x) / float(std::max(framebuffer_size().x, 1));
    ImGui::GetIO().FontGlobalScale = scale;
    ImGui::GetStyle().ScaleAllSizes(scale);
}

Window::~Window() {
    ImGui_ImplOpenGL3_Shutdown();
    ImGui_ImplGlfw_Shutdown();
    ImGui::DestroyContext();
    glfwTerminate();
}

void* Window::get_proc(const char* name) { return reinterpret_cast<void*>(glfwGetProcAddress(name)); }

// ---- State ----------------------------------------------------------------------------------------------

bool Window::is_closed() const { return glfwWindowShouldClose(window_) == GLFW_TRUE; }
void Window::close() { glfwSetWindowShouldClose(window_, GLFW_TRUE); }

glm::ivec2 Window::size() const {
    glm::ivec2 size(0);
    glfwGetWindowSize(window_, &size.x, &size.y);
    return size;
}

glm::ivec2 Window::framebuffer_size() const {
    glm::ivec2 size(0);
    glfwGetFramebufferSize(window_, &size.x, &size.y);
    return size;
}

glm::vec2 Window::gui_size() const { return size(); }

void Window::begin_gui() {
    ImGui_ImplOpenGL3_NewFrame();
    ImGui_ImplGlfw_NewFrame();
    ImGui::NewFrame();
}

void Window::end_gui() {
    ImGui::Render();
    ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
}

void Window::show() { glfwSwapBuffers(window_); }

// ---- Input ----------------------------------------------------------------------------------------------

Events Window::poll() {
    if (framebuffer_size() == glm::ivec2(0)) {
        glfwWaitEventsTimeout(0.1);
    } else {
        glfwPollEvents();
    }
    return std::exchange(events_, {});
}

Steering Window::steer(float seconds, float picture_width, float* split) {
    Steering steering;
    drag(&steering, picture_width, split);
    if (!ImGui::GetIO().WantCaptureKeyboard) { read_keys(&steering); }
    read_gamepad(seconds, &steering);
    return steering;
}

// What a drag that begins now does, so far from the line between the halves.
Window::Drag Window::drag_of_buttons(double to_split) const {
    if (ImGui::GetIO().WantCaptureMouse) { return Drag::none; }
    if (glfwGetMouseButton(window_, GLFW_MOUSE_BUTTON_RIGHT) == GLFW_PRESS) { return Drag::look; }
    if (glfwGetMouseButton(window_, GLFW_MOUSE_BUTTON_LEFT) != GLFW_PRESS) { return Drag::none; }
    return std::abs(to_split) < kSplitReach ? Drag::split : Drag::orbit;
}

void Window::drag(Steering* steering, float picture_width, float* split) {
    glm::dvec2 mouse(0.0);
    glfwGetCursorPos(window_, &mouse.x, &mouse.y);
    const auto motion = glm::vec2(mouse - std::exchange(mouse_, mouse)) * kRadiansAPoint;
    const int button = drag_ == Drag::look ? GLFW_MOUSE_BUTTON_RIGHT : GLFW_MOUSE_BUTTON_LEFT;
    if (drag_ == Drag::none || glfwGetMouseButton(window_, button) != GLFW_PRESS) {
        drag_ = drag_of_buttons(mouse.x - double(*split * picture_width));
        glfwSetInputMode(window_, GLFW_CURSOR, drag_ == Drag::look ? GLFW_CURSOR_DISABLED : GLFW_CURSOR_NORMAL);
        return; // the motion so far was not part of it
    }
    if (drag_ == Drag::look) {
        steering->look_yaw -= motion.x;
        steering->look_pitch -= motion.y;
    } else if (drag_ == Drag::orbit) {
        steering->orbit_yaw -= motion.x;
        steering->orbit_pitch += motion.y;
    } else {
        *split = std::clamp(float(mouse.x) / std::max(picture_width, 1.0f), 0.0f, 1.0f);
    }
}

void Window::read_keys(Steering* steering) const {
    const auto pair = [&](int forth, int back) {
        return float(glfwGetKey(window_, forth) == GLFW_PRESS) - float(glfwGetKey(window_, back) == GLFW_PRESS);
    };
    steering->fly +=
        glm::vec3(pair(GLFW_KEY_D, GLFW_KEY_A), pair(GLFW_KEY_E, GLFW_KEY_Q), pair(GLFW_KEY_W, GLFW_KEY_S));
}
