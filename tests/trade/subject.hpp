// A scene and its light, by name: the procedural ones, or FILE[@ex,ey,ez,tx,ty,tz,fov[,sx,sy,sz]].
#pragma once

#include "bench.hpp"

#include <glm/gtc/type_ptr.hpp>

struct Subject {
    View view;
    std::vector<PunctualLight> lights;

    float size() const { return glm::length(view.scene.bounds_max - view.scene.bounds_min); } // metres
};

inline Subject load_subject(const std::string& argument) {
    Subject subject;
    if (argument == "gallery") {
        subject.view.name = argument;
        subject.view.scene = make_gallery();
        subject.view.camera = camera_of_file(subject.view.scene.cameras[0], subject.view.scene);
        set_planes(subject.view.scene, &subject.view.camera);
    } else {
        subject.view = load_view(argument == "atrium" ? std::string() : argument);
    }
    subject.lights = subject.view.scene.lights;
    if (subject.lights.empty()) { subject.lights = {sun_light(subject.view.to_sun, 4.0f)}; }
    return subject;
}
