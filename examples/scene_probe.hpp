// Light from where no surface is known: a sky to look at, and the irradiance that a surface gets from all around.
#pragma once

#include "scene.hpp"

#include <array>

// Radiance by direction, W/m2/sr: above, from the horizon's to the zenith's in proportion to the sine of the elevation;
// below, the ground's.
struct Sky {
    glm::vec3 zenith{0.0f}, horizon{0.0f}, ground{0.0f};
};

Sky uniform_sky(glm::vec3 radiance);

// Bright at the horizon, above a ground of albedo 0.3. What faces the zenith gets as much as from a uniform sky.
Sky gradient_sky(glm::vec3 radiance);

// Irradiance by normal, divided by pi: the radiance from everywhere that would give as much, W/m2/sr. In spherical
// harmonics up to order 2 (Ramamoorthi and Hanrahan 2001): about 1 % from the truth under skies and between walls, up to a
// tenth of the brightest side where all light comes from one direction. The factors of
//     1, y, z, x, xy, yz, 3yy - 1, xz, zz - xx
// of a unit normal in world space.
using Probe = std::array<glm::vec3, 9>;

Probe probe_of(const Sky& sky);

// Adds up radiance from all around.
class ProbeSum {
public:
    void add(glm::vec3 direction, glm::vec3 radiance, float solid_angle);
    Probe probe() const; // what was added so far is taken for the whole sphere

private:
    std::array<glm::dvec3, 9> sums_{};
    double solid_angle_ = 0.0; // sr
};
