/*
 * Sessions for C++11 and later: owners, exceptions and views over covbeam_session.h, which is the manual. Header only.
 * EXPERIMENTAL, as that is. MIT or Apache-2.0.
 *
 * As with covbeam.hpp every call that fails throws covbeam::Error, and what a poll throws stops the call and comes out of it.
 */
#ifndef COVBEAM_SESSION_HPP
#define COVBEAM_SESSION_HPP

#include "covbeam.hpp"
#include "covbeam_session.h"

namespace covbeam {

/// A struct of options, all else of which is 0: `auto settings = options<covbeam_session_settings>();`.
template <class T> T options() noexcept {
    T made{};
    made.struct_size = static_cast<uint32_t>(sizeof made);
    return made;
}

/// A poll that always goes on.
struct Always {
    bool operator()() const noexcept { return true; }
};

namespace detail {
template <class Poll> using Asks = Calls<typename std::remove_reference<Poll>::type, typename std::remove_reference<Poll>::type>;
}  // namespace detail

/// Meshes and their instances: first added, then built, then in any number of scenes.
class Geometry {
public:
    Geometry() {
        covbeam_geometry* made = nullptr;
        check(covbeam_geometry_new(&made));
        handle_.reset(made);
    }
    covbeam_geometry* get() noexcept { return handle_.get(); }
    const covbeam_geometry* get() const noexcept { return handle_.get(); }

    /// How many triangles of no area were left out.
    size_t add(const covbeam_mesh& mesh) {
        size_t dropped = 0;
        check(covbeam_geometry_add_mesh(get(), &mesh, &dropped));
        return dropped;
    }
    void add(Strided<const covbeam_instance> instances) {
        check(covbeam_geometry_add_instances(get(), instances.count, instances.data, instances.stride));
    }
    template <class Poll = Always> void build(Poll&& go_on = Poll()) {
        detail::Asks<Poll> calls(go_on, go_on);
        calls.check(covbeam_geometry_build(get(), calls.poll, &calls));
    }
    covbeam_geometry_info info() const {
        covbeam_geometry_info found;
        check(covbeam_geometry_get_info(get(), &found));
        return found;
    }

private:
    detail::Owner<covbeam_geometry, covbeam_geometry_free> handle_;
};

/// What is rendered; it does not change.
class Scene {
public:
    /// Of shapes alone.
    explicit Scene(const covbeam_description& description) : Scene(nullptr, description) {}
    Scene(const Geometry& geometry, const covbeam_description& description) : Scene(geometry.get(), description) {}
    /// Of a host's geometry, which outlives it.
    Scene(const covbeam_host& host, const covbeam_description& description) {
        covbeam_scene* made = nullptr;
        check(covbeam_scene_new_of_host(&host, &description, &made));
        handle_.reset(made);
    }
    const covbeam_scene* get() const noexcept { return handle_.get(); }

private:
    Scene(const covbeam_geometry* geometry, const covbeam_description& description) {
        covbeam_scene* made = nullptr;
        check(covbeam_scene_new(geometry, &description, &made));
        handle_.reset(made);
    }
    detail::Owner<covbeam_scene, covbeam_scene_free> handle_;
};

/// Passes and pictures of a scene.
class Session {
public:
    template <class Poll = Always>
    explicit Session(const Scene& scene, const covbeam_session_settings& settings = options<covbeam_session_settings>(),
                     Poll&& go_on = Poll())
        : Session(std::vector<const covbeam_scene*>(1, scene.get()), settings, std::forward<Poll>(go_on)) {}
    /// At several instants while a shutter is open, a power of two of them.
    template <class Poll = Always>
    explicit Session(const std::vector<const covbeam_scene*>& instants,
                     const covbeam_session_settings& settings = options<covbeam_session_settings>(), Poll&& go_on = Poll()) {
        covbeam_session* made = nullptr;
        detail::Asks<Poll> calls(go_on, go_on);
        calls.check(covbeam_session_new(instants.size(), instants.data(), sizeof(covbeam_scene*), &settings, calls.poll, &calls, &made));
        handle_.reset(made);
    }
    const covbeam_session* get() const noexcept { return handle_.get(); }

    template <class Poll = Always> void pass(Poll&& go_on = Poll()) const {
        detail::Asks<Poll> calls(go_on, go_on);
        calls.check(covbeam_session_pass(get(), calls.poll, &calls));
    }
    template <class Poll = Always> covbeam_end until(const covbeam_goal& goal, Poll&& go_on = Poll()) const {
        detail::Asks<Poll> calls(go_on, go_on);
        uint32_t end = COVBEAM_END_REACHED;
        calls.check(covbeam_session_until(get(), &goal, calls.poll, &calls, &end));
        return static_cast<covbeam_end>(end);
    }
    /// Three floats a pixel, rows from the top; one of COVBEAM_LAYER_ERROR and those after it.
    template <class Poll = Always> std::vector<float> picture(uint32_t layer = COVBEAM_LAYER_ALL, Poll&& go_on = Poll()) const {
        detail::Asks<Poll> calls(go_on, go_on);
        const covbeam_session_info found = info();
        const size_t pixels = static_cast<size_t>(found.width) * found.height;
        std::vector<float> out(layer < COVBEAM_LAYER_ERROR ? 3 * pixels : pixels);
        calls.check(covbeam_session_picture(get(), layer, pixels, out.data(), 0, calls.poll, &calls));
        return out;
    }
    covbeam_session_info info() const {
        covbeam_session_info found;
        check(covbeam_session_get_info(get(), &found));
        return found;
    }
    void restart(uint32_t photons, bool plain = false) const { check(covbeam_session_restart(get(), photons, plain ? 1 : 0)); }

    /// The exact sums of the passes, as bytes.
    std::vector<unsigned char> save() const {
        size_t size = 0;
        check(covbeam_session_save(get(), nullptr, 0, &size));
        std::vector<unsigned char> bytes(size);
        check(covbeam_session_save(get(), bytes.data(), bytes.size(), &size));
        return bytes;
    }
    void merge(const std::vector<unsigned char>& bytes) const {
        check(covbeam_session_merge(get(), bytes.data(), bytes.size(), nullptr, nullptr));
    }

private:
    detail::Owner<covbeam_session, covbeam_session_free> handle_;
};

}  // namespace covbeam

#endif  // COVBEAM_SESSION_HPP
