// A scene as the renderer keeps it: meshes and balls, and images on them. Materials, fog, lamp and camera are covbeam's plain structs.
#pragma once

#include "files.hpp"

constexpr double PI = 3.14159265358979323846;

struct Solid { // its object and material have the same number
    Mesh mesh;
    std::array<float, 4> ball = {}; // or its middle and radius
    Image texture = {}, mask = {};  // factors on what is diffuse, and on how much there is of the surface
};

struct World : covbeam::Description { // but for geometry
    std::vector<Solid> solids;
};

World build(const std::string& scene, uint32_t width); // one of glass-ball, shaft, rose-window, leaves; its picture's width [pixels]
