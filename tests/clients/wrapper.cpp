// Tests of covbeam.hpp itself, and of the ABI as a C++ compiler sees it.

#include <covbeam.hpp>

#include <cmath>
#include <cstddef>
#include <cstdio>
#include <cstring>
#include <limits>
#include <thread>
#include <utility>

namespace cb = covbeam;

// The ABI is little more than these numbers: they change only together with COVBEAM_ABI_VERSION.
#define SIZE(type, bytes, alignment)                                                                                  \
    static_assert(sizeof(covbeam_##type) == bytes && std::is_standard_layout<covbeam_##type>::value &&                \
                      alignof(covbeam_##type) == alignment,                                                           \
                  #type);
#define AT(type, member, offset) static_assert(offsetof(covbeam_##type, member) == offset, #type "." #member);
#define VALUE(name, value) static_assert(COVBEAM_##name == value, #name);
#include "layout.h"

// What the wrapper adds to the C structs is no data.
static_assert(sizeof(cb::LightField) == 64 && sizeof(cb::Medium) == 80 && sizeof(cb::Kernel) == 20,
              "C reads arrays of them");

template <class T> struct Owner {
    static constexpr bool ok = std::is_nothrow_move_constructible<T>::value && std::is_nothrow_move_assignable<T>::value &&
                               !std::is_copy_constructible<T>::value && sizeof(T) == sizeof(void*);
};
static_assert(Owner<cb::Grid>::ok && Owner<cb::Density>::ok && Owner<cb::BeamMap>::ok && Owner<cb::Scratch>::ok &&
                  Owner<cb::Film>::ok && Owner<cb::March>::ok,
              "owners move without a throw, are not copied, and are one pointer");

namespace {

int failures = 0, tests = 0;

void expect(bool true_, const char* what) {
    if (true_) return;
    std::printf("FAILED: %s\n", what);
    ++failures;
}

// Whether `call` throws an E with this status and with `part` in its text.
template <class E = cb::Error, class Call> bool throws(covbeam_status status, const char* part, Call call) {
    try {
        call();
    } catch (const E& error) {
        const bool said = std::strstr(error.what(), part) && std::strstr(error.what(),
                                                                         covbeam_status_name(status)) == error.what();
        if (!said) std::printf("it says: %s\n", error.what());
        return said && error.status() == status;
    }
    return false;
}

struct Vec {
    float x, y, z;
};
const covbeam_grid_layout ROOM = {{-1, -1, -1}, {1, 1, 1}, {8, 8, 8}};

float noise(uint32_t& state) {
    state = state * 1664525u + 1013904223u;
    return float(state >> 8) / 16777216.0f;
}
void direction(uint32_t& state, float* out) {
    const float z = 2 * noise(state) - 1, phi = 6.2831853f * noise(state), r = std::sqrt(1 - z * z);
    out[0] = r * std::cos(phi), out[1] = r * std::sin(phi), out[2] = z;
}
std::vector<covbeam_beam> beams(size_t count) {
    uint32_t state = 1;
    std::vector<covbeam_beam> all(count);
    for (covbeam_beam& beam : all) {
        beam = covbeam_beam();
        for (float& x : beam.origin) x = 2 * noise(state) - 1;
        direction(state, beam.direction);
        beam.length = 1 + noise(state);
        for (float& p : beam.power) p = noise(state);
    }
    return all;
}
std::vector<covbeam_eye_ray> rays(size_t count) {
    uint32_t state = 7;
    std::vector<covbeam_eye_ray> all(count);
    for (covbeam_eye_ray& ray : all) {
        for (float& x : ray.origin) x = 2 * noise(state) - 1;
        direction(state, ray.direction);
        ray.length = 2;
    }
    return all;
}
const cb::Kernel KERNEL(COVBEAM_KERNEL_EPANECHNIKOV, 0.02f, 0.1f, 0.01f);

cb::BeamMap committed(size_t count, const cb::Medium& medium) {
    cb::BeamMap map(medium);
    map.add(beams(count));
    map.commit(KERNEL.max_radius);
    return map;
}
bool same(const std::vector<covbeam_gathered>& a, const std::vector<covbeam_gathered>& b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof a[0]) == 0;
}

void the_library_is_that_of_the_header() {
    cb::require_abi();
    expect(covbeam_abi_version() == COVBEAM_ABI_VERSION, "macro and run-time value of the ABI version");
    expect(std::strlen(covbeam_version()) >= 5, "a version");
}

void a_moved_owner_leaves_nothing_behind() {
    cb::Grid grid(ROOM);
    const covbeam_grid* handle = grid.get();
    cb::Grid moved(std::move(grid));
    expect(moved.get() == handle && grid.get() == nullptr, "moved by construction");
    cb::Grid other(ROOM);
    other = std::move(moved);
    expect(other.get() == handle && moved.get() == nullptr, "moved by assignment, the old one freed");
    expect(other.layout().cells[0] == 8, "the moved grid works");
    expect(throws(COVBEAM_NULL_POINTER, "grid", [&] { moved.resolve(); }),
           "a moved-from owner is refused, not followed");
}

void a_failure_names_the_parameter() {
    covbeam_grid_layout none = ROOM;
    none.cells[1] = 0;
    expect(throws(COVBEAM_INVALID_VALUE, "layout", [&] { cb::Grid grid(none); }), "a layout without voxels");
    const float nan[3] = {std::numeric_limits<float>::quiet_NaN(), 0, 0};
    expect(throws(COVBEAM_INVALID_VALUE, "direction", [&] { cb::LightField::point(nan, 0); }), "NaN");
    expect(throws(COVBEAM_WRONG_ORDER, "", [&] {
        cb::BeamMap map(cb::Medium::grey(1, 0));
        cb::Scratch scratch;
        covbeam_gathered out[1];
        map.gather(KERNEL, nullptr, rays(1), out, scratch);
    }), "a gather before the commit");
    expect(throws(COVBEAM_BAD_DATA, "",
                  [] { cb::Grid::load("no grid at all, but as long as a header of a saved one would be", 60); }),
                      "bytes of others");
    covbeam_grid_cell cells[2];
    covbeam_fluence_cell means[2];
    expect(throws(COVBEAM_SHORT_BUFFER, "count", [&] { cb::Grid grid(ROOM, cells, 2, means, 2); }),
           "short memory of the host's");
}

void views_reach_into_arrays_of_structs() {
    const Vec down = {0, -1, 0};
    std::vector<cb::LightField> fields(3, cb::LightField::point(&down.x, 1)), reference = fields;
    struct Photon {
        uint32_t id;
        float distance;
        Vec towards;
    } photons[3] = {{0, 1, {1, 0, 0}}, {1, 2, {0, 0, 1}}, {2, 3, {1, 0, 1}}};
    cb::many::travel(fields, cb::Floats::of(&photons[0].distance, 3, sizeof photons[0]));
    cb::many::occlude(fields, cb::Vectors::of(&photons[0].towards, 3, sizeof photons[0]), cb::Floats::every(0.1f));
    for (size_t i = 0; i < 3; ++i) {
        reference[i].travel(photons[i].distance);
        reference[i].occlude(&photons[i].towards.x, 0.1f);
    }
    expect(std::memcmp(fields.data(), reference.data(), 3 * sizeof fields[0]) == 0,
           "members of the host's structs, and one for all");

    const Vec directions[2] = {{1, 0, 0}, {0, 2, 0}};
    cb::LightField made[2];
    cb::many::point(directions, cb::Floats::every(0.0f), made);
    expect(made[0].direction[0] == 1 && made[1].direction[1] == 1, "an array of the host's vectors");
    const float two[2] = {1, 2};
    expect(throws(COVBEAM_INVALID_ARRAY, "length", [&] { cb::many::travel(fields, two); }),
           "arrays of different lengths");
    expect(std::memcmp(fields.data(), reference.data(), 3 * sizeof fields[0]) == 0, "and nothing changed");
    cb::many::travel(cb::Fields(fields.data(), 0), cb::Floats());
}

void a_cancelled_call_changes_nothing_and_can_be_made_again() {
    const cb::Medium fog = cb::Medium::grey(0.5f, 0.1f);
    cb::BeamMap map(fog);
    map.add(beams(100000));
    int asked = 0;
    const auto no = [&] { return ++asked < 3; };
    expect(throws<cb::Cancelled>(COVBEAM_CANCELLED, "", [&] { map.commit(KERNEL.max_radius, no); }),
           "commit stops when the poll says so");
    expect(asked == 3, "and asks no more");
    const auto changes = [&] { map.clear(); return true; };
    expect(throws(COVBEAM_BUSY, "map", [&] { map.commit(KERNEL.max_radius, changes); }),
           "a poll cannot change what is committed");
    map.commit(KERNEL.max_radius, [&] { return true; });
    expect(map.count() == 100000 && map.memory() > 100000 * sizeof(covbeam_beam), "the beams are all there");

    const std::vector<covbeam_eye_ray> eyes = rays(512);
    std::vector<covbeam_gathered> untouched(512), out(512), reference(512);
    std::memset(untouched.data(), 0x5a, 512 * sizeof untouched[0]);
    out = untouched;
    cb::Scratch scratch;
    asked = 0;
    expect(throws(COVBEAM_CANCELLED, "", [&] { map.gather(KERNEL, nullptr, eyes, out, scratch, no); }),
           "gather stops: Cancelled is an Error");
    expect(same(out, untouched), "and has written nothing");
    map.gather(KERNEL, nullptr, eyes, out, scratch, [] { return true; });
    committed(100000, fog).gather(KERNEL, nullptr, eyes, reference, scratch);
    expect(same(out, reference), "made again, the result is that of an undisturbed map");
}

void an_exception_of_a_callback_comes_out_of_the_call() {
    struct Own {
        int number;
    };
    const cb::Medium fog = cb::Medium::grey(0.5f, 0.1f);
    cb::BeamMap map(fog);
    map.add(beams(20000));
    int caught = 0;
    try {
        map.commit(KERNEL.max_radius, []() -> bool { throw Own{1}; });
    } catch (const Own& own) {
        caught += own.number;
    }
    map.commit(KERNEL.max_radius);
    const std::vector<covbeam_eye_ray> eyes = rays(64);
    std::vector<covbeam_gathered> out(64);
    cb::Scratch scratch;
    try {
        map.gather(KERNEL, nullptr, eyes, out, scratch, []() -> bool { throw Own{10}; });
    } catch (const Own& own) {
        caught += own.number;
    }
    try {
        map.gather_shaded(KERNEL, nullptr, eyes, out, scratch, [](const covbeam_contact*, size_t,
                                                                  float*) { throw Own{100}; });
    } catch (const Own& own) {
        caught += own.number;
    }
    expect(caught == 111, "from the polls of commit and gather, and from shade");
    map.gather(KERNEL, nullptr, eyes, out, scratch);
    uint32_t pairs = 0;
    for (const covbeam_gathered& g : out) pairs += g.pairs;
    expect(pairs > 1000, "map and scratch work afterwards");
}

void a_medium_of_the_hosts_gives_what_the_built_in_one_gives() {
    const cb::Medium fog = cb::Medium::grey(0.5f, 0.1f);
    const cb::BeamMap map = committed(20000, fog);
    const std::vector<covbeam_eye_ray> eyes = rays(256);
    std::vector<covbeam_gathered> built_in(256), own(256);
    cb::Scratch scratch;
    map.gather(KERNEL, nullptr, eyes, built_in, scratch);
    size_t contacts = 0;
    map.gather_shaded(KERNEL, nullptr, eyes, own, scratch, [&](const covbeam_contact* c, size_t count, float* values) {
        contacts += count;
        for (size_t i = 0; i < 3 * count; ++i)
            values[i] = 0.5f * 0.07957747f * std::exp(-0.6f * (c[i / 3].ray_distance + c[i / 3].beam_distance));
    }, [] { return true; });
    size_t pairs = 0, wrong = 0;
    for (size_t i = 0; i < 256; ++i) {
        pairs += built_in[i].pairs;
        // Sums of some hundred positive terms in the same order: the roundings of each, not their number, count.
        wrong += std::abs(own[i].radiance[0] - built_in[i].radiance[0]) > 1e-5f * built_in[i].radiance[0];
        wrong += own[i].pairs != built_in[i].pairs;
    }
    expect(pairs == contacts && pairs > 1000 && wrong == 0, "homogeneous fog, written down again");
}

void batches_of_beams_and_threads_of_rays_do_not_change_a_bit() {
    const cb::Medium fog = cb::Medium::grey(0.5f, 0.1f);
    const std::vector<covbeam_beam> all = beams(5000);
    const std::vector<covbeam_eye_ray> eyes = rays(1024);
    std::vector<covbeam_gathered> reference;
    for (const size_t batch : {size_t(5000), size_t(1), size_t(7), size_t(64), size_t(4999)}) {
        cb::BeamMap map(fog);
        for (size_t first = 0; first < all.size(); first += batch)
            map.add(cb::Beams(&all[first], std::min(batch, all.size() - first)));
        map.commit(KERNEL.max_radius);
        for (const size_t threads : {size_t(1), size_t(2), size_t(8)}) {
            std::vector<covbeam_gathered> out(eyes.size());
            std::vector<std::thread> workers;
            const size_t share = eyes.size() / threads;
            for (size_t t = 0; t < threads; ++t)
                workers.emplace_back([&, t] {
                    cb::Scratch scratch;
                    map.gather(KERNEL, nullptr, {&eyes[t * share], share}, {&out[t * share], share}, scratch);
                });
            for (std::thread& worker : workers) worker.join();
            if (reference.empty()) reference = out;
            expect(same(out, reference), "the same bits for any batches and threads");
        }
    }
}

void a_table_of_columns_is_what_the_medium_says() {
    const std::vector<float> values = {0, 1, 2, 3, 4, 5, 6, 7};
    const cb::Density density({{-1, -1, -1}, {1, 1, 1}, {2, 2, 2}}, values);
    cb::Medium smoke = cb::Medium::grey(0.5f, 0.1f);
    smoke.with_voxels(density).with_phase(cb::Phase::rayleigh());
    const float from[3] = {-2, 0.1f, 0.2f}, along[3] = {1, 0, 0};
    std::vector<covbeam_knot> table(smoke.tabulate(from, along, 4, nullptr, 0));
    expect(throws(COVBEAM_SHORT_BUFFER, "", [&] { smoke.tabulate(from, along, 4, table.data(), 1); }),
           "a table that does not fit");
    smoke.tabulate(from, along, 4, table.data(), table.size());
    const cb::Column column = smoke.column(from, along, table.data(), table.size());
    const float all = smoke.column_at(from, along, 4);
    // The table is exact at its ends.
    expect(all > 1 && std::abs(column.at(4) - all) <= 1e-6f * all, "the whole column");
    expect(std::abs(column.distance_at(0.5f * all) - smoke.distance_at(from, along, 4, 0.5f * all)) < 1e-3f,
           "and half of it");
    float distances[2] = {4, 1.5f}, found[2];
    cb::many::at(column, distances, found);
    expect(found[0] == column.at(4) && found[1] == column.at(1.5f), "on arrays");
    cb::many::distance_at(column, found, distances);
    expect(distances[1] == column.distance_at(found[1]), "and back");

    // Voxels have no closed form, so a pair needs both columns.
    const covbeam_eye_ray eye = {{-2, 0.1f, 0.2f}, {1, 0, 0}, 4};
    const covbeam_beam beam = {{0, -2, 0.2f}, {0, 1, 0}, 4, {1, 1, 1}, {0, 0, 0}, {0, 0, 0}};
    std::vector<covbeam_knot> beam_table(smoke.tabulate(beam.origin, beam.direction, 4, nullptr, 0));
    smoke.tabulate(beam.origin, beam.direction, 4, beam_table.data(), beam_table.size());
    const cb::Column along_beam = smoke.column(beam.origin, beam.direction, beam_table.data(), beam_table.size());
    covbeam_gathered pair = {}, from_map[1];
    expect(throws(COVBEAM_NULL_POINTER, "column", [&] {
        cb::gather_pair(eye, beam, 0, 4, smoke, nullptr, nullptr, KERNEL, nullptr, pair);
    }), "without columns it says so");
    expect(cb::gather_pair(eye, beam, 0, 4, smoke, &column, &along_beam, KERNEL, nullptr, pair), "the pair meets");
    cb::BeamMap map(smoke);
    map.add({&beam, 1});
    map.commit(KERNEL.max_radius);
    cb::Scratch scratch;
    map.gather(KERNEL, nullptr, {&eye, 1}, from_map, scratch);
    expect(pair.pairs == 1 && std::memcmp(&pair, from_map, sizeof pair) == 0,
           "and gives what the map gives, to the bit");
}

void edges_are_found_by_probes_and_their_exceptions_come_out() {
    // A ball of radius 1 at distance 5, passed at 0.05 rad from its silhouette: sin = 1/5, which touches at sqrt(24).
    const float angle = std::asin(0.2f) + 0.05f, center[3] = {5 * std::sin(angle), 0, 5 * std::cos(angle)};
    const auto ball = [&](const float* d, covbeam_probe_hit& hit) {
        const float along = center[0] * d[0] + center[2] * d[2], half2 = along * along - 24;
        if (along <= 0 || half2 <= 0) return;
        hit.distance = along - std::sqrt(half2);
        for (int i = 0; i < 3; ++i) hit.normal[i] = hit.distance * d[i] - center[i];
    };
    const Vec z = {0, 0, 1};
    cb::Segment segment;
    segment.field = cb::LightField::point(&z.x, 0.05f);
    segment.find_edges(nullptr, ball);
    expect(segment.edge_count >= 1, "the ball's silhouette");
    const covbeam_edge& edge = segment.edges[0];
    const float touch = std::sqrt(24.0f), distance = touch * std::tan(0.05f);
    expect(std::abs(edge.depth / touch - 1) < 0.05f && std::abs(edge.distance / distance - 1) < 0.12f,
           "where its tangents touch");
    expect(edge.towards[0] > 0.92f, "on the ball's side");
    bool caught = false;
    try {
        segment.find_edges(nullptr, [](const float*, covbeam_probe_hit&) { throw std::out_of_range("far"); });
    } catch (const std::out_of_range&) {
        caught = true;
    }
    expect(caught && segment.edge_count >= 1, "and the edges are as they were");
}

void a_grid_keeps_what_it_collected() {
    const Vec down = {0, -1, 0};
    covbeam_segment segment = {};
    segment.origin[1] = 0.9f;
    segment.length = 1.5f;
    segment.power = 1;
    segment.unscattered = 1;
    cb::LightField field = cb::LightField::point(&down.x, 2);
    field.travel(1);
    segment.field = field;
    const cb::Medium fog = cb::Medium::grey(0.5f, 0.1f);
    std::vector<covbeam_grid_cell> cells(512, covbeam_grid_cell());
    std::vector<covbeam_fluence_cell> means(512);
    {
        cb::Grid hosts(ROOM, cells.data(), cells.size(), means.data(), means.size()), share(ROOM);
        share.deposit(fog, {&segment, 1}, [] { return true; });
        hosts.merge(share);
        hosts.resolve();
        expect(hosts.cells().data == cells.data() && hosts.means().count == 512, "in the host's memory");
        cb::Grid loaded = cb::Grid::load(hosts.save().data(), hosts.save().size());
        expect(std::memcmp(loaded.cells().data, cells.data(), 512 * sizeof cells[0]) == 0, "saved and loaded");
        share.clear();
        expect(share.cells().data[0].weight == 0, "cleared");
        const Vec points[2] = {{0, 0, 0}, {5, 5, 5}};
        cb::Spectrum spectra[2];
        uint8_t found[2];
        hosts.look_up(points, spectra, found);
        expect(found[0] == 1 && found[1] == 0 && spectra[0].xx > 0 && spectra[1].xx == 0, "looked up");
    }
    double weight = 0;
    for (const covbeam_grid_cell& cell : cells) weight += cell.weight;
    expect(weight > 0, "the host's memory outlives the grid, with what is in it");
}

void importances_add_up_and_guides_refuse_what_is_none() {
    const cb::Medium fog = cb::Medium::grey(0.5f, 0.1f);
    const std::vector<covbeam_eye_ray> seen = rays(20);
    const float one = 1;
    cb::Importance first(ROOM), second(ROOM);
    first.add_eye_rays(fog, seen, cb::Floats::every(one));
    first.add_paths(fog, seen, cb::Floats::every(one));
    second.merge(first);
    second.merge(first);
    std::vector<covbeam_importance_cell> once(20), twice(20);
    const cb::Vectors points = cb::Vectors::of(&seen[0].origin, seen.size(), sizeof seen[0]);
    expect(throws(COVBEAM_WRONG_ORDER, "importance", [&] { first.at(points, once); }), "looked up before the resolve");
    first.resolve();
    second.resolve();
    first.at(points, once);
    second.at(points, twice);
    for (size_t i = 0; i < once.size(); ++i)
        expect(once[i].beam > 0 && twice[i].beam == 2 * once[i].beam && twice[i].scattered == 2 * once[i].scattered,
               "merged twice, twice the importance");
    expect(throws(COVBEAM_INVALID_ARRAY, "", [&] { first.at(points, cb::Strided<covbeam_importance_cell>(&once[0], 3)); }),
           "arrays of different lengths");
    expect(throws(COVBEAM_SHORT_BUFFER, "weight_count", [] { cb::EmissionGuide(2, {1, 2, 3}, 0.1f); }), "three weights");
    expect(throws(COVBEAM_INVALID_VALUE, "even", [] { cb::EmissionGuide(1, {1}, 0); }), "no even share");
}

} // namespace

int main() {
    void (*const all[])() = {
        the_library_is_that_of_the_header,
        a_moved_owner_leaves_nothing_behind,
        a_failure_names_the_parameter,
        views_reach_into_arrays_of_structs,
        a_cancelled_call_changes_nothing_and_can_be_made_again,
        an_exception_of_a_callback_comes_out_of_the_call,
        a_medium_of_the_hosts_gives_what_the_built_in_one_gives,
        batches_of_beams_and_threads_of_rays_do_not_change_a_bit,
        a_table_of_columns_is_what_the_medium_says,
        edges_are_found_by_probes_and_their_exceptions_come_out,
        a_grid_keeps_what_it_collected,
        importances_add_up_and_guides_refuse_what_is_none,
    };
    for (const auto test : all) {
        try {
            test();
        } catch (const std::exception& error) {
            expect(false, error.what());
        }
        ++tests;
    }
    std::printf("%d tests of the wrapper, %d failures\n", tests, failures);
    return failures ? 1 : 0;
}
