// A renderer that gathers photon beams with covbeam: own threads, own scene, progress, Ctrl-C. See README.md.

#include "parallel.hpp"
#include "photons.hpp"

#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <stdexcept>
#include <string>

namespace {

constexpr int SHARES = 32; // of a pass' photons; fixed, so that the picture does not depend on the number of threads
constexpr int TILE = 8;    // 8x8 eye rays share one walk through the hierarchy of beams

std::atomic<bool> stopped{false};
static_assert(ATOMIC_BOOL_LOCK_FREE == 2, "the signal handler needs it");
void stop(int signal) {
    stopped = true;
    std::signal(signal, SIG_DFL); // the second Ctrl-C does not wait
}
bool go_on() { return !stopped; }

struct Options {
    unsigned threads = std::max(1u, std::thread::hardware_concurrency());
    int passes = 32, photons = 4000, seed = 1, size = 256;
    bool own_medium = false;
    std::string out = "shaft.pfm";
};

Options parse(int argc, char** argv) {
    Options options;
    for (int i = 1; i < argc; ++i) {
        const std::string name = argv[i];
        if (name == "--own-medium") {
            options.own_medium = true;
            continue;
        }
        if (i + 1 == argc) throw std::invalid_argument(name + ": unknown, or its value is missing");
        const char* value = argv[++i];
        const int number = std::atoi(value);
        if (name == "--out") options.out = value;
        else if (number < 1) throw std::invalid_argument(name + " " + value + ": unknown, or not a number from 1 on");
        else if (name == "--threads") options.threads = unsigned(number);
        else if (name == "--passes") options.passes = number;
        else if (name == "--photons") options.photons = number;
        else if (name == "--seed") options.seed = number;
        else if (name == "--size" && number <= 4096) options.size = number;
        else throw std::invalid_argument(name + ": unknown");
    }
    return options;
}

// The fog as a host would write it that has media of its own: exp(-height / scale) integrated along a ray.
struct OwnFog {
    float scattering, extinction, scale, asymmetry;

    float column(Vec3 origin, Vec3 direction, float distance) const {
        const float start = std::exp(-origin.y / scale), rate = direction.y / scale;
        return start * (rate == 0 ? distance : -std::expm1(-rate * distance) / rate);
    }
    float phase(float cosine) const { // Henyey-Greenstein
        const float g = asymmetry, d = 1 + g * g - 2 * g * cosine;
        return (1 - g * g) / (4 * PI * d * std::sqrt(d));
    }
};

class Renderer {
public:
    explicit Renderer(const Options& options)
        : options_(options), camera_{options.size, options.size}, fog_(make_fog()), grid_(layout()), map_(fog_), scratch_(options.threads),
          film_(size_t(camera_.width * camera_.height), Vec3{0, 0, 0}) {
        for (int i = 0; i < SHARES; ++i) shares_.emplace_back(layout());
    }

    // Adds a pass to the film, or throws and leaves the film as it was.
    void pass(uint32_t index) {
        const covbeam::Kernel kernel = schedule_.kernel(index);
        parallel(options_.threads, SHARES, [&](int i, unsigned) { trace_share(index, i); });

        map_.clear();
        beams_.clear();
        for (const Share& share : shares_) {
            grid_.merge(share.grid); // which keeps what all passes have collected
            map_.add(share.beams);
            if (options_.own_medium) beams_.insert(beams_.end(), share.beams.begin(), share.beams.end());
        }
        grid_.resolve();
        map_.commit(kernel.max_radius, go_on);

        std::vector<Vec3> picture(film_.size());
        const int across = (camera_.width + TILE - 1) / TILE, down = (camera_.height + TILE - 1) / TILE;
        parallel(options_.threads, across * down, [&](int tile, unsigned thread) {
            gather_tile(index, kernel, tile % across * TILE, tile / across * TILE, scratch_[thread], picture);
        });
        for (size_t i = 0; i < film_.size(); ++i) film_[i] = film_[i] + picture[i];
        ++passes_;
    }

    // PFM: the rows from the bottom up, little-endian floats.
    void write(const std::string& path) const {
        std::FILE* file = std::fopen(path.c_str(), "wb");
        if (!file) throw std::runtime_error(path + ": cannot be written");
        std::fprintf(file, "PF\n%d %d\n-1.0\n", camera_.width, camera_.height);
        for (int y = camera_.height; y-- > 0;)
            for (int x = 0; x < camera_.width; ++x) {
                const Vec3 mean = (1 / float(passes_)) * film_[size_t(y * camera_.width + x)];
                std::fwrite(&mean, sizeof mean, 1, file);
            }
        if (std::fclose(file) != 0) throw std::runtime_error(path + ": cannot be written");
    }

private:
    static covbeam::Medium make_fog() {
        const float floor[3] = {0, 0, 0}, up[3] = {0, 1, 0};
        covbeam::Medium fog = covbeam::Medium::grey(0.25f, 0.02f);
        return fog.with_phase(covbeam::Phase::henyey_greenstein(0.2f)).with_exponential(floor, up, 1.5f);
    }
    covbeam_grid_layout layout() const {
        covbeam_grid_layout l = {{}, {}, {32, 32, 32}};
        store(scene_.room_min, l.min), store(scene_.room_max, l.max);
        return l;
    }

    void trace_share(uint32_t pass, int i) {
        Share& share = shares_[size_t(i)];
        share.beams.clear(), share.segments.clear(), share.grid.clear();
        // A tenth of the paths say how fast the light varies, which is enough. They have a sequence of their own: of one that fills
        // the lamp evenly every tenth point does not.
        const int fields = (options_.photons + 9) / 10;
        const struct { uint32_t sequence; int count; bool bandwidth; } kinds[] = {{FIELDS, fields, true}, {PHOTONS, options_.photons - fields, false}};
        for (const auto& kind : kinds)
            for (int path = kind.count * i / SHARES; path < kind.count * (i + 1) / SHARES; ++path) {
                if (stopped) throw covbeam::Cancelled("while tracing photons");
                const Random random(uint32_t(options_.seed), kind.sequence, (pass - 1) * uint32_t(kind.count) + uint32_t(path));
                trace(scene_, lamp_, fog_, random, 1 / float(options_.photons), kind.bandwidth, share);
            }
        share.grid.deposit(fog_, share.segments);
    }

    void gather_tile(uint32_t pass, const covbeam::Kernel& kernel, int x0, int y0, covbeam::Scratch& scratch,
                     std::vector<Vec3>& picture) const {
        covbeam_eye_ray rays[TILE * TILE] = {};
        covbeam_gathered gathered[TILE * TILE];
        size_t pixels[TILE * TILE], count = 0;
        for (int y = y0; y < std::min(y0 + TILE, camera_.height); ++y)
            for (int x = x0; x < std::min(x0 + TILE, camera_.width); ++x) {
                const size_t pixel = size_t(y * camera_.width + x);
                Random random(uint32_t(options_.seed), PIXELS + uint32_t(pixel), pass);
                const Vec3 direction = camera_.direction(float(x) + random.uniform(), float(y) + random.uniform());
                const Hit hit = scene_.intersect(camera_.position, direction);
                picture[pixel] = direct_light(direction, hit);
                store(camera_.position, rays[count].origin), store(direction, rays[count].direction);
                rays[count].length = hit.distance;
                pixels[count++] = pixel;
            }
        const covbeam::BeamMap::Rays in(rays, count);
        const covbeam::BeamMap::Out out(gathered, count);
        if (options_.own_medium) {
            const OwnFog own{fog_.scattering[0], fog_.scattering[0] + fog_.absorption[0], fog_.scale_height,
                             fog_.phase.asymmetry};
            const auto shade = [&](const covbeam_contact* contacts, size_t n, float* values) {
                for (size_t i = 0; i < n; ++i) {
                    const covbeam_contact& c = contacts[i];
                    const covbeam_beam& beam = beams_[c.beam];
                    // It may be a little before a beam that starts on a surface: less fog by as much as lies ahead.
                    const float stretch = own.column(vec(beam.origin), vec(beam.direction), std::abs(c.beam_distance));
                    const float column = own.column(vec(rays[c.ray].origin), vec(rays[c.ray].direction), c.ray_distance) +
                                         std::copysign(stretch, c.beam_distance);
                    const float value = own.scattering * std::exp(-c.position[1] / own.scale) * own.phase(c.cos_theta) *
                                        std::exp(-own.extinction * column);
                    std::fill_n(values + 3 * i, 3, value);
                }
            };
            map_.gather_shaded(kernel, &grid_, in, out, scratch, shade, go_on);
        } else {
            map_.gather(kernel, &grid_, in, out, scratch, go_on);
        }
        for (size_t i = 0; i < count; ++i) picture[pixels[i]] = picture[pixels[i]] + vec(gathered[i].radiance);
    }

    // Light that the lamp sends straight to a surface, dimmed by the fog on both ways.
    Vec3 direct_light(Vec3 eye, Hit hit) const {
        const Vec3 point = camera_.position + hit.distance * eye, way = point - lamp_.position;
        const float distance = length(way), cosine = -dot(way, hit.normal) / distance;
        const Vec3 direction = (1 / distance) * way;
        if (hit.albedo == 0 || cosine <= 0) return {0, 0, 0};
        if (scene_.intersect(lamp_.position, direction).distance < distance - 1e-3f) return {0, 0, 0};
        float from_lamp[3], to_eye[3];
        fog_.transmittance(lamp_.position.data(), direction.data(), distance, from_lamp);
        fog_.transmittance(camera_.position.data(), eye.data(), hit.distance, to_eye);
        const float grey = hit.albedo / PI * lamp_.radiant_intensity(direction) * cosine / (distance * distance);
        return {grey * from_lamp[0] * to_eye[0], grey * from_lamp[1] * to_eye[1], grey * from_lamp[2] * to_eye[2]};
    }

    static Vec3 vec(const float* v) { return {v[0], v[1], v[2]}; }

    Options options_;
    Scene scene_;
    Lamp lamp_;
    Camera camera_;
    covbeam::Medium fog_;
    covbeam::Schedule schedule_{COVBEAM_KERNEL_EPANECHNIKOV, 0.04f, 0.5f, 0.15f, 0.01f};
    covbeam::Grid grid_;
    covbeam::BeamMap map_;
    std::vector<Share> shares_;
    std::vector<covbeam_beam> beams_; // all of a pass, for the host's own fog
    std::vector<covbeam::Scratch> scratch_;
    std::vector<Vec3> film_;
    int passes_ = 0;
};

int run(const Options& options) {
    covbeam::require_abi();
    std::signal(SIGINT, stop);
    Renderer renderer(options);
    const auto start = std::chrono::steady_clock::now();
    int done = 0;
    try {
        while (done < options.passes) {
            renderer.pass(uint32_t(done + 1));
            ++done;
            const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - start;
            std::fprintf(stderr, "\rpass %d of %d, %.0f s left ", done, options.passes,
                         spent.count() / done * (options.passes - done));
        }
    } catch (const covbeam::Cancelled&) {
        std::fprintf(stderr, "\nstopped after %d passes", done);
    }
    std::fprintf(stderr, "\n");
    if (done > 0) renderer.write(options.out);
    return done == options.passes ? 0 : 130;
}

} // namespace

int main(int argc, char** argv) {
    try {
        return run(parse(argc, argv));
    } catch (const std::invalid_argument& error) {
        std::fprintf(stderr, "%s\nusage: covbeam-shaft [--threads N] [--passes N] [--photons N] [--seed N]\n                     [--size N] [--own-medium] [--out FILE.pfm]\n",
                     error.what());
        return 2;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "covbeam-shaft: %s\n", error.what());
        return 1;
    }
}
