// The viewer's window: an OpenGL context, ImGui on top of it, and what the user does with keys, mouse and gamepad.
#pragma once

#include <glm/glm.hpp>

#include <string>
#include <vector>

struct GLFWwindow;

// What moves the camera, of one frame.
struct Steering {
    float look_yaw = 0.0f, look_pitch = 0.0f;   // radians
    float orbit_yaw = 0.0f, orbit_pitch = 0.0f; // radians, around the target
    glm::vec3 fly{0.0f};                        // right, up, ahead: shares of the speed
};

// Since the last poll.
struct Events {
    std::vector<int> keys; // that went down: GLFW_KEY_*
    std::vector<std::string> dropped;
    double wheel = 0.0;
};

class Window {
public:
    // Throws std::runtime_error with one sentence when there is no display or no OpenGL 3.3.
    Window(int width, int height, const char* title);
    ~Window();
    Window(const Window&) = delete;
    Window& operator=(const Window&) = delete;

    bool is_closed() const;
    void close(); // at the end of this frame

    // Once a frame. What ImGui takes for itself is left out. split: where the left half ends, share of the picture's width,
    // which is in the window's coordinates; the user may drag it. seconds: since the last frame.
    Events poll();
    Steering steer(float seconds, float picture_width, float* split);

    glm::ivec2 framebuffer_size() const; // pixels; 0 while the window is minimised
    glm::vec2 gui_size() const;          // in ImGui's coordinates, which are the window's
    static void begin_gui();
    static void end_gui(); // draws it
    void show();           // what was drawn

    static void* get_proc(const char* name);

private:
    enum class Drag { none, look, orbit, split };

    void open(int width, int height, const char* title);
    void init_gui();
    glm::ivec2 size() const; // in the window's own coordinates
    Drag drag_of_buttons(double to_split) const;
    void drag(Steering* steering, float picture_width, float* split);
    void read_keys(Steering* steering) const;

    GLFWwindow* window_ = nullptr;
    Events events_;
    glm::dvec2 mouse_{0.0}; // where it was
    Drag drag_ = Drag::none;
};
