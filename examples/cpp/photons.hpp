// Light paths: what they leave for covbeam.
#pragma once

#include "scene.hpp"
#include <covbeam.hpp>
#include <vector>

// Sequences of decisions: each pixel has one, from PIXELS on.
enum : uint32_t { PHOTONS, FIELDS, PIXELS };

// The decisions of a path, a function of its place alone: which thread asks, and when, does not matter. The first ones of many
// paths in a row are spread evenly.
class Random {
public:
    Random(uint32_t seed, uint32_t sequence, uint32_t path) : seed_(seed), sequence_(sequence), path_(path) {}
    float uniform() { return covbeam::path_number(seed_, sequence_, path_, next_++); }

private:
    uint32_t seed_, sequence_, path_, next_ = 0;
};

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
