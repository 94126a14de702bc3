// A renderer on Embree that keeps geometry, textures and threads; with --own materials, lamp and camera, too. See README.md.

#include "host.hpp"

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <map>

static constexpr const char* USAGE =
    "usage: covbeam-embree [glass-ball | shaft | rose-window | leaves] [--own] [--OPTION VALUE]...\n"
    "  --own        materials, lamp and camera are functions of the host, too: the same picture\n"
    "  --passes N   ends after so many (32)     --seconds N  and after so long (0: however long)\n"
    "  --width N    pixels across (256)         --seed N     another one, another noise (1)\n"
    "  --threads N  the host's (0: all cores)   --out FILE   linear floats (picture.pfm); Ctrl-C keeps the passes that are done\n";

static std::atomic<bool> stopped{false};

using Options = std::map<std::string, std::string>;

static Options parse(int argc, char** argv) {
    Options options = {{"scene", "glass-ball"}, {"--passes", "32"}, {"--seconds", "0"}, {"--width", "256"}, {"--seed", "1"}, {"--threads", "0"},
                       {"--out", "picture.pfm"}};
    for (int i = 1; i < argc; ++i) {
        const std::string word = argv[i];
        if (word == "--own") options[word] = "yes";
        else if (word[0] != '-') options["scene"] = word;
        else if (options.count(word) > 0 && i + 1 < argc) options[word] = argv[++i];
        else throw std::invalid_argument(word + ": unknown, or its value is missing");
    }
    return options;
}

static uint32_t number(const std::string& value) {
    if (value.empty() || value.size() > 6 || value.find_first_not_of("0123456789") != value.npos)
        throw std::invalid_argument(value + ": no whole number below a million");
    return uint32_t(std::stoul(value));
}

static void write(const std::string& path, const std::vector<float>& pixels, size_t width) { // PFM: rows from the bottom
    std::ofstream file(path, std::ios::binary);
    file << "PF\n" << width << ' ' << pixels.size() / (3 * width) << "\n-1.0\n";
    for (size_t end = pixels.size(); end > 0; end -= 3 * width)
        file.write(reinterpret_cast<const char*>(&pixels[end - 3 * width]), std::streamsize(3 * width * sizeof(float)));
    if (!file.flush()) throw std::runtime_error(path + ": cannot be written");
}

static int run(const Options& options) {
    covbeam::require_abi();
    const bool is_own = options.count("--own") > 0;
    covbeam_session_settings settings = covbeam::options<covbeam_session_settings>();
    settings.seed = number(options.at("--seed")), settings.threads = number(options.at("--threads"));
    covbeam_goal goal = covbeam::options<covbeam_goal>();
    goal.passes = std::max(1u, number(options.at("--passes"))), goal.seconds = number(options.at("--seconds"));

    World world = build(options.at("scene"), number(options.at("--width")));
    const Host host(world);
    for (covbeam_material& m : world.materials) // of black ones all is said
        if (is_own && m.diffuse[0] + m.metal[0] + m.glass_reflection[0] > 0) m.asks = COVBEAM_ASKS_WAYS;
    world.lights[0].is_own = world.fixed.camera.is_own = is_own;
    covbeam_host functions = covbeam::host(host, is_own);
    const auto& room = world.solids.back().mesh.positions; // from its lower corner to its upper one
    vec(room.front()).store(functions.min), vec(room.back()).store(functions.max);

    covbeam::Threads threads(settings);
    const covbeam::Session session(covbeam::Scene(functions, world), settings, [] { return !stopped; });
    const auto start = std::chrono::steady_clock::now();
    try {
        session.until(goal, [&] { // in this thread, while the others render
            const double passes = session.info().passes, spent = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
            const double share = std::max(passes / goal.passes, goal.seconds > 0 ? spent / goal.seconds : 0);
            if (share > 0) std::fprintf(stderr, "\rpass %.0f of %u, %.0f s left ", passes, goal.passes, std::max(spent / share - spent, 0.0));
            return !stopped;
        });
    } catch (const covbeam::Cancelled&) { // what is done is kept
    }
    const uint32_t done = session.info().passes;
    std::fprintf(stderr, "\n%s after %u passes\n", stopped ? "stopped" : "done", done);
    if (done > 0) write(options.at("--out"), session.picture(), world.fixed.camera.width);
    return stopped ? 130 : 0;
}

int main(int argc, char** argv) {
    try {
        if (argc == 2 && std::strcmp(argv[1], "--help") == 0) return std::fputs(USAGE, stdout), 0;
        const Options options = parse(argc, argv);
        std::signal(SIGINT, [](int) { stopped = true; });
        return run(options);
    } catch (const std::exception& error) {
        const bool is_usage = dynamic_cast<const std::invalid_argument*>(&error) != nullptr;
        return std::fprintf(stderr, "covbeam-embree: %s\n%s", error.what(), is_usage ? USAGE : ""), is_usage ? 2 : 1;
    }
}
