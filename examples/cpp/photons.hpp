// Light paths: what they leave for covbeam.
#pragma once

#include "scene.hpp"
#include <covbeam.hpp>
#include <vector>

// A fixed part of a pass' photons. It has its own beams and its own grid, so that threads share nothing, and it is merged in its
// turn, so that the sums do not depend on which thread was first.
struct Share {
    std::vector<covbeam_beam> beams;
    std::vector<covbeam_segment> segments;
    covbeam::Grid grid;

    explicit Share(const covbeam_grid_layout& layout) : grid(layout) {}
};

// Traces one light path; `scale` = 1 / number of paths. One with `bandwidth` carries a light field and leaves segments too.
void trace(const Scene& scene, const Lamp& lamp, const covbeam::Medium& fog, Random random, float scale,
           bool bandwidth, Share& out);
