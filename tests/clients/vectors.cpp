// Makes the calls of tests/vectors.txt through covbeam.hpp and compares every bit; tests/src/vectors/mod.rs describes the file.
// Functions that have a form for arrays are called in both forms: the second with all lines of a name that share their options
// and the state (density, grid) at once, on strided rows of the file.

#include <covbeam.hpp>

#include <array>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <sstream>

namespace cb = covbeam;
namespace many = covbeam::many;

namespace {

struct Word {
    uint64_t bits;
    size_t digits;
    bool operator!=(Word other) const { return bits != other.bits || digits != other.digits; }
};
using Words = std::vector<Word>;

struct Mismatch : std::runtime_error {
    using std::runtime_error::runtime_error;
};

std::string text(const Words& words) {
    std::string out;
    char buffer[20];
    for (Word word : words) {
        std::snprintf(buffer, sizeof buffer, " %0*llx", int(word.digits), static_cast<unsigned long long>(word.bits));
        out += buffer;
    }
    return out;
}

void compare(const Words& found, const Words& expected) {
    bool equal = found.size() == expected.size();
    for (size_t i = 0; equal && i < found.size(); ++i) equal = !(found[i] != expected[i]);
    if (!equal) throw Mismatch("\n  expected" + text(expected) + "\n  found   " + text(found));
}

// Takes values from a line; every struct here is a row of 4-byte numbers.
class In {
public:
    explicit In(const Words& words) : words_(words) {}
    size_t left() const { return words_.size() - at_; }
    void into(void* where, size_t count) {
        for (size_t i = 0; i < count; ++i, ++at_) {
            if (at_ == words_.size() || words_[at_].digits != 8) throw Mismatch("too few words, or one of 16 digits");
            const uint32_t bits = uint32_t(words_[at_].bits);
            std::memcpy(static_cast<char*>(where) + 4 * i, &bits, 4);
        }
    }
    template <class T> T take() {
        T value{};
        into(&value, sizeof(T) / 4);
        return value;
    }
    template <class T> std::vector<T> rest() {
        std::vector<T> values;
        while (left()) values.push_back(take<T>());
        return values;
    }
    float f() { return take<float>(); }
    uint32_t u() { return take<uint32_t>(); }

private:
    const Words& words_;
    size_t at_ = 0;
};

struct Vec {
    float v[3];
    operator const float*() const { return v; }
};
struct Pair {
    float v[2];
};

class Out {
public:
    Words words;
    template <class T> Out& operator<<(const T& value) {
        static_assert(sizeof(T) % 4 == 0, "a row of words");
        for (size_t i = 0; i < sizeof(T) / 4; ++i) {
            uint32_t bits;
            std::memcpy(&bits, reinterpret_cast<const char*>(&value) + 4 * i, 4);
            words.push_back({bits, 8});
        }
        return *this;
    }
    Out& operator<<(bool value) { return *this << uint32_t(value); }
    template <class T> Out& all(const std::vector<T>& values) {
        for (const T& value : values) *this << value;
        return *this;
    }
    void wide(uint64_t bits) { words.push_back({bits, 16}); }
};

uint64_t fnv(const std::vector<unsigned char>& bytes) {
    uint64_t hash = 0xcbf29ce484222325;
    for (unsigned char byte : bytes) hash = (hash ^ byte) * 0x100000001b3;
    return hash;
}

// Lines of one name side by side: what they share, and a row of numbers each.
struct Rows {
    size_t n = 0, width = 0, out_width = 0;
    Words shared;
    std::vector<float> in, out;
    std::vector<uint8_t> flags;
    std::vector<Words> expected;

    template <class T, size_t N = 1> cb::Strided<const T, N> get(size_t word) const {
        return {reinterpret_cast<const T*>(&in[word]), n, 4 * width};
    }
    cb::Floats f(size_t word) const { return get<float>(word); }
    cb::Vectors v(size_t word) const { return get<float, 3>(word); }
    cb::Strided<const float, 2> pair(size_t word) const { return get<float, 2>(word); }
    cb::Fields fields() { return {reinterpret_cast<covbeam_light_field*>(in.data()), n, 4 * width}; }
    template <class T, size_t N = 1> cb::Strided<T, N> put(size_t word = 0) {
        return {reinterpret_cast<T*>(&out[word]), n, 4 * out_width};
    }
};

class Client {
public:
    Client() {
        light_fields();
        phases_spectra_kernels();
        media();
        grids();
        maps();
        image_space();
        importances();
        marches();
    }

    void line(const std::string& name, const Words& in, const Words& expected) {
        const auto found = single_.find(name);
        if (found == single_.end()) throw Mismatch("unknown name");
        const auto many_found = plural_.find(name);
        // Density and grid stay as they are until the lines of one state have been called at once.
        if (name == "density_new" || name.compare(0, 5, "grid_") == 0) flush();
        In reader(in);
        Out out;
        found->second(reader, out);
        if (reader.left()) throw Mismatch("words are left over");
        compare(out.words, expected);
        names_.insert(name);
        ++calls_;
        if (many_found != plural_.end()) remember(name, many_found->second, in, expected);
    }

    void flush() {
        for (auto& entry : groups_) {
            Rows& rows = entry.second;
            const std::string& name = entry.first.first;
            const Plural& plural = plural_.at(name);
            rows.out.resize(rows.n * rows.out_width + 1);
            rows.flags.resize(rows.n);
            In shared(rows.shared);
            plural.call(shared, rows);
            for (size_t i = 0; i < rows.n; ++i) {
                Out out;
                if (plural.flagged) out << uint32_t(rows.flags[i]);
                const float* row = plural.in_place ? &rows.in[i * rows.width] : &rows.out[i * rows.out_width];
                for (size_t k = 0; k < rows.out_width; ++k) out << row[k];
                try {
                    compare(out.words, rows.expected[i]);
                } catch (const Mismatch& wrong) {
                    throw Mismatch("the array form of " + name + ", element " + std::to_string(i) + wrong.what());
                }
            }
            ++arrays_;
            elements_ += rows.n;
        }
        groups_.clear();
    }

    int end() const {
        std::printf("%zu calls, %zu names, all equal; %zu of them again in %zu calls on arrays\n", calls_,
                    names_.size(), elements_, arrays_);
        const bool enough = names_.size() >= 40 && calls_ >= 500 && elements_ >= 500;
        if (!enough) std::printf("too few\n");
        return enough ? 0 : 1;
    }

private:
    using Single = std::function<void(In&, Out&)>;
    struct Plural {
        size_t shared;  // words at the front of a line that are options of the whole call
        bool in_place;  // the result is the first 16 words of the row
        bool flagged;   // the first output is a flag
        std::function<void(In&, Rows&)> call;
    };

    void remember(const std::string& name, const Plural& plural, const Words& in, const Words& expected) {
        const Words shared(in.begin(), in.begin() + long(plural.shared));
        Rows& rows = groups_[{name, text(shared)}];
        rows.shared = shared;
        rows.width = in.size() - plural.shared;
        rows.out_width = expected.size() - (plural.flagged ? 1 : 0);
        for (size_t i = plural.shared; i < in.size(); ++i) {
            const uint32_t bits = uint32_t(in[i].bits);
            rows.in.emplace_back();
            std::memcpy(&rows.in.back(), &bits, 4);
        }
        rows.expected.push_back(expected);
        ++rows.n;
    }

    // A function that gives one struct or number.
    template <class F> void gives(const char* name, F f) {
        single_[name] = [f](In& in, Out& out) { out << f(in); };
    }
    // An operator: the field, changed.
    template <class F> void changes(const char* name, F f, std::function<void(Rows&)> rows) {
        single_[name] = [f](In& in, Out& out) {
            cb::LightField field = in.take<cb::LightField>();
            f(field, in);
            out << field;
        };
        plural_[name] = {0, true, false, [rows](In&, Rows& r) { rows(r); }};
    }
    void array(const char* name, size_t shared, std::function<void(In&, Rows&)> call) {
        plural_[name] = {shared, false, false, call};
    }

    cb::Medium medium(In& in) const {
        cb::Medium m;
        in.into(m.scattering, 16); // scattering to scale_height
        if (m.density == COVBEAM_DENSITY_VOXELS) m.with_voxels(*density_);
        return m;
    }
    static cb::Segment segment(In& in) {
        cb::Segment s;
        in.into(&s, 22); // origin to field
        s.edge_count = in.u();
        in.into(s.edges, 5 * s.edge_count);
        return s;
    }
    static cb::Kernel kernel(In& in) {
        cb::Kernel k(0, 0, 0, 0);
        in.into(&k.shape, 4);
        return k;
    }
    const cb::Grid* used(In& in) const { return in.u() ? grid_.get() : nullptr; }

    void light_fields();
    void phases_spectra_kernels();
    void media();
    void grids();
    void maps();
    void image_space();
    void marches();
    void importances();

    std::map<std::string, Single> single_;
    std::map<std::string, Plural> plural_;
    std::map<std::pair<std::string, std::string>, Rows> groups_;
    std::unique_ptr<cb::Density> density_;
    std::unique_ptr<cb::Grid> grid_;
    std::unique_ptr<cb::BeamMap> map_;
    cb::Scratch scratch_;
    std::unique_ptr<cb::Film> film_;
    size_t film_pixels_ = 0;
    std::unique_ptr<cb::Importance> importance_;
    std::unique_ptr<cb::EmissionGuide> guide_;
    cb::March march_;
    std::set<std::string> names_;
    size_t calls_ = 0, arrays_ = 0, elements_ = 0;
};

void Client::light_fields() {
    using Field = cb::LightField;
    gives("light_field_point", [](In& in) { Vec d = in.take<Vec>(); return Field::point(d, in.f()); });
    gives("light_field_disk", [](In& in) {
        Vec d = in.take<Vec>(), n = in.take<Vec>();
        float r = in.f();
        return Field::disk(d, n, r, in.f());
    });
    gives("light_field_collimated", [](In& in) { Vec d = in.take<Vec>(); return Field::collimated(d, in.f()); });
    gives("light_field_gaussian", [](In& in) {
        Vec d = in.take<Vec>(), x = in.take<Vec>();
        Pair s = in.take<Pair>(), a = in.take<Pair>();
        return Field::gaussian(d, x, s.v, a.v);
    });
    array("light_field_point", 0, [](In&, Rows& r) { many::point(r.v(0), r.f(3), r.put<covbeam_light_field>()); });
    array("light_field_disk", 0, [](In&, Rows& r) { many::disk(r.v(0), r.v(3), r.f(6), r.f(7),
                                                               r.put<covbeam_light_field>()); });
    array("light_field_collimated", 0, [](In&, Rows& r) { many::collimated(r.v(0), r.f(3),
                                                                           r.put<covbeam_light_field>()); });
    array("light_field_gaussian", 0,
          [](In&, Rows& r) { many::gaussian(r.v(0), r.v(3), r.pair(6), r.pair(8), r.put<covbeam_light_field>()); });

#include "vectors/operators.hpp"

    // The medium stands between: lines that share it are not found at the front, and each is an array of one.
    single_["light_field_carry"] = [this](In& in, Out& out) {
        Field one = in.take<Field>(), field[1] = {one};
        const cb::Medium m = medium(in);
        const Vec origin[1] = {in.take<Vec>()};
        const float distance[1] = {in.f()};
        one.carry(m, origin[0], distance[0]);
        many::carry(field, m, origin, distance);
        if (std::memcmp(&one, field, sizeof one) != 0) throw Mismatch("the array form differs");
        out << one;
    };
    single_["light_field_refract"] = [](In& in, Out& out) {
        Field f = in.take<Field>();
        Vec n = in.take<Vec>();
        covbeam_curvature c = in.take<covbeam_curvature>();
        out << f.refract(n, &c, in.f());
        out << f;
    };
    plural_["light_field_refract"] = {0, true, true, [](In&, Rows& r) {
        many::refract(r.fields(), r.v(16), r.get<covbeam_curvature>(19), r.f(25), r.flags);
    }};

    gives("light_field_slice", [](In& in) { Vec v; in.take<Field>().slice(v.v); return v; });
    gives("light_field_fluence", [](In& in) { Field f = in.take<Field>(); return f.fluence(in.f()); });
    gives("light_field_variance_along_ray",
          [](In& in) { Field f = in.take<Field>(); return f.variance_along_ray(in.f()); });
    array("light_field_slice", 0, [](In&, Rows& r) { many::slice(r.get<covbeam_light_field>(0), r.put<float, 3>()); });
    array("light_field_fluence", 0, [](In&, Rows& r) { many::fluence(r.get<covbeam_light_field>(0), r.f(16),
                                                                     r.put<covbeam_spectrum>()); });
    array("light_field_variance_along_ray", 0,
          [](In&, Rows& r) { many::variance_along_ray(r.get<covbeam_light_field>(0), r.f(16), r.put<float>()); });
}

void Client::phases_spectra_kernels() {
    using cb::Phase;
    gives("phase_evaluate", [](In& in) { Phase p = in.take<Phase>(); return p.evaluate(in.f()); });
    gives("phase_sample_cosine", [](In& in) { Phase p = in.take<Phase>(); return p.sample_cosine(in.f()); });
    gives("phase_angular_variance", [](In& in) { return in.take<Phase>().angular_variance(); });
    gives("phase_sample", [](In& in) {
        Phase p = in.take<Phase>();
        Vec d = in.take<Vec>(), out;
        p.sample(d, in.take<Pair>().v, out.v);
        return out;
    });
    array("phase_evaluate", 2, [](In& in, Rows& r) { many::evaluate(in.take<Phase>(), r.f(0), r.put<float>()); });
    array("phase_sample_cosine", 2, [](In& in, Rows& r) { many::sample_cosine(in.take<Phase>(), r.f(0),
                                                                              r.put<float>()); });
    array("phase_sample", 2, [](In& in, Rows& r) { many::sample(in.take<Phase>(), r.v(0), r.pair(3), r.put<float,
                                                                3>()); });

    using cb::Spectrum;
    gives("spectrum_variance_along",
          [](In& in) { Spectrum s = in.take<Spectrum>(); return s.variance_along(in.take<Vec>()); });
    gives("spectrum_add_along", [](In& in) {
        Spectrum s = in.take<Spectrum>();
        Vec axis = in.take<Vec>();
        s.add_along(axis, in.f());
        return s;
    });
    array("spectrum_variance_along", 0, [](In&, Rows& r) { many::variance_along(r.get<covbeam_spectrum>(0), r.v(6),
                                                                                r.put<float>()); });
    plural_["spectrum_add_along"] = {0, true, false, [](In&, Rows& r) {
        many::add_along({reinterpret_cast<covbeam_spectrum*>(r.in.data()), r.n, 4 * r.width}, r.v(6), r.f(9));
    }};

    gives("kernel_evaluate", [](In& in) { uint32_t s = in.u(); float d = in.f(); return cb::kernel_evaluate(s, d,
        in.f()); });
    gives("kernel_second_moment", [](In& in) { return cb::kernel_second_moment(in.u()); });
    gives("kernel_radius_from_error",
          [](In& in) { uint32_t s = in.u(); float e = in.f(); return cb::kernel_radius_from_error(s, e, in.f()); });
    gives("progressive_radius", [](In& in) { float r = in.f(), a = in.f(); return cb::progressive_radius(r, a,
        in.u()); });
    gives("error_bound", [](In& in) { float e = in.f(); return cb::error_bound(e, in.u()); });
    single_["schedule_kernel"] = [](In& in, Out& out) {
        cb::Schedule s(0, 0, 0, 0, 0);
        in.into(&s.shape, 5);
        const cb::Kernel k = s.kernel(in.u());
        out << k.shape << k.min_radius << k.max_radius << k.error;
    };
}

void Client::media() {
    single_["density_new"] = [this](In& in, Out&) {
        const covbeam_grid_layout layout = in.take<covbeam_grid_layout>();
        density_.reset(new cb::Density(layout, in.rest<float>()));
    };
    gives("medium_density_at", [this](In& in) { cb::Medium m = medium(in); return m.density_at(in.take<Vec>()); });
    gives("medium_derivatives_at",
          [this](In& in) { cb::Medium m = medium(in); return m.derivatives_at(in.take<Vec>()); });
    gives("medium_step", [this](In& in) { return medium(in).step(); });
    gives("medium_opaque_column", [this](In& in) { return medium(in).opaque_column(); });
    gives("medium_column_at", [this](In& in) {
        cb::Medium m = medium(in);
        Vec o = in.take<Vec>(), d = in.take<Vec>();
        return m.column_at(o, d, in.f());
    });
    gives("medium_distance_at", [this](In& in) {
        cb::Medium m = medium(in);
        Vec o = in.take<Vec>(), d = in.take<Vec>();
        float length = in.f();
        return m.distance_at(o, d, length, in.f());
    });
    gives("medium_transmittance", [this](In& in) {
        cb::Medium m = medium(in);
        Vec o = in.take<Vec>(), d = in.take<Vec>(), t;
        m.transmittance(o, d, in.f(), t.v);
        return t;
    });
    gives("medium_column_transmittance",
          [this](In& in) { cb::Medium m = medium(in); Vec t; m.column_transmittance(in.f(), t.v); return t; });
    gives("medium_reach", [this](In& in) { cb::Medium m = medium(in); Vec o = in.take<Vec>(); return m.reach(o,
        in.take<Vec>()); });
    single_["medium_knots"] = [this](In& in, Out& out) {
        const cb::Medium m = medium(in);
        const Vec o = in.take<Vec>(), d = in.take<Vec>();
        const float length = in.f(), error = in.f(), most = in.f();
        std::vector<covbeam_knot> table(m.knots(o, d, length, error, most, nullptr, 0));
        if (m.knots(o, d, length, error, most, table.data(),
                    table.size()) != table.size()) throw Mismatch("another number of knots");
        out.all(table);
    };
    single_["medium_tabulate"] = [this](In& in, Out& out) {
        const cb::Medium m = medium(in);
        const Vec o = in.take<Vec>(), d = in.take<Vec>();
        const float length = in.f();
        std::vector<covbeam_knot> table(m.tabulate(o, d, length, nullptr, 0));
        if (m.tabulate(o, d, length, table.data(),
                       table.size()) != table.size()) throw Mismatch("another number of knots");
        out.all(table);
    };
    array("medium_density_at", 16, [this](In& in, Rows& r) { many::density_at(medium(in), r.v(0), r.put<float>()); });
    array("medium_derivatives_at", 16, [this](In& in, Rows& r) { many::derivatives_at(medium(in), r.v(0),
        r.put<covbeam_derivatives>()); });
    array("medium_column_at", 16, [this](In& in, Rows& r) { many::column_at(medium(in), r.v(0), r.v(3), r.f(6),
                                                                            r.put<float>()); });
    array("medium_distance_at", 16, [this](In& in, Rows& r) { many::distance_at(medium(in), r.v(0), r.v(3), r.f(6),
                                                                                r.f(7), r.put<float>()); });
    array("medium_transmittance", 16, [this](In& in, Rows& r) { many::transmittance(medium(in), r.v(0), r.v(3), r.f(6),
        r.put<float, 3>()); });
    array("medium_column_transmittance", 16, [this](In& in, Rows& r) { many::column_transmittance(medium(in), r.f(0),
        r.put<float, 3>()); });
    array("medium_reach", 16, [this](In& in, Rows& r) { many::reach(medium(in), r.v(0), r.v(3), r.put<float>()); });
}

void Client::grids() {
    single_["grid_new"] = [this](In& in, Out&) { grid_.reset(new cb::Grid(in.take<covbeam_grid_layout>())); };
    single_["grid_resolve"] = [this](In&, Out&) { grid_->resolve(); };
    single_["grid_deposit"] = [this](In& in, Out&) {
        const cb::Medium m = medium(in);
        std::vector<cb::Segment> segments;
        while (in.left()) segments.push_back(segment(in));
        grid_->deposit(m, segments);
    };
    single_["segment_field_at"] = [this](In& in, Out& out) {
        const cb::Segment one = segment(in), all[1] = {one};
        const cb::Medium m = medium(in);
        const float distance[1] = {in.f()};
        cb::LightField field[1];
        many::field_at(all, m, distance, field);
        const cb::LightField found = one.field_at(m, distance[0]);
        if (std::memcmp(&found, field, sizeof found) != 0) throw Mismatch("the array form differs");
        out << found;
    };
    single_["path_number"] = [](In& in, Out& out) {
        const uint32_t seed = in.u(), sequence = in.u(), path[1] = {in.u()}, dimension = in.u();
        float number[1];
        many::path_numbers(seed, sequence, path, dimension, number);
        const float found = cb::path_number(seed, sequence, path[0], dimension);
        if (std::memcmp(&found, number, sizeof found) != 0) throw Mismatch("the array form differs");
        out << found;
    };
    single_["grid_deposit_spectra"] = [this](In& in, Out&) {
        const Vec position[1] = {in.take<Vec>()};
        const covbeam_spectrum spectrum = in.take<covbeam_spectrum>();
        const float weight[1] = {in.f()};
        grid_->deposit_spectra(position, cb::SpectraIn::every(spectrum), weight);
    };
    single_["grid_look_up"] = [this](In& in, Out& out) {
        const std::vector<Vec> positions = in.rest<Vec>();
        std::vector<cb::Spectrum> spectra(positions.size());
        std::vector<uint8_t> found(positions.size());
        grid_->look_up(positions, spectra, found);
        for (size_t i = 0; i < positions.size(); ++i) out << uint32_t(found[i]) << spectra[i];
    };
    single_["grid_save"] = [this](In&, Out& out) {
        const std::vector<unsigned char> bytes = grid_->save();
        if (cb::Grid::load(bytes.data(),
                           bytes.size()).save() != bytes) throw Mismatch("a loaded grid saves other bytes");
        out.wide(bytes.size());
        out.wide(fnv(bytes));
    };
    single_["kernel_radius_at"] = [this](In& in, Out& out) {
        const cb::Grid* grid = used(in);
        const cb::Kernel k = kernel(in);
        const Vec position = in.take<Vec>();
        float sigma;
        const float radius = k.radius_at(grid, position, in.take<Vec>(), &sigma);
        out << radius << sigma;
    };
    array("kernel_radius_at", 5, [this](In& in, Rows& r) {
        const cb::Grid* grid = used(in);
        many::radius_at(kernel(in), grid, r.v(0), r.v(3), r.put<float>(0), r.put<float>(1));
    });
}

void Client::maps() {
    single_["cross"] = [](In& in, Out& out) {
        const covbeam_eye_ray ray = in.take<covbeam_eye_ray>();
        covbeam_crossing crossing = {};
        const bool crosses = cb::cross(ray, in.take<covbeam_beam>(), crossing);
        out << crosses << crossing;
    };
    plural_["cross"] = {7, false, true, [](In& in, Rows& r) {
        many::cross(in.take<covbeam_eye_ray>(), r.get<covbeam_beam>(0), r.put<covbeam_crossing>(), r.flags);
    }};
    single_["filter_beams"] = [](In& in, Out& out) {
        const covbeam_eye_ray ray = in.take<covbeam_eye_ray>();
        std::vector<covbeam_beam> beams;
        while (in.left() > 1) beams.push_back(in.take<covbeam_beam>());
        std::vector<uint8_t> masks(beams.size());
        many::filter_beams(ray, beams, in.f(), masks);
        for (uint8_t mask : masks) out << uint32_t(mask);
    };
    single_["gather_pair"] = [this](In& in, Out& out) {
        const cb::Grid* grid = used(in);
        const cb::Medium m = medium(in);
        const cb::Kernel k = kernel(in);
        const float from[1] = {in.f()}, to[1] = {in.f()};
        const covbeam_eye_ray ray = in.take<covbeam_eye_ray>();
        const covbeam_beam beam[1] = {in.take<covbeam_beam>()};
        covbeam_gathered sum = {}, again = {};
        uint8_t accepted[1];
        const bool counts = cb::gather_pair(ray, beam[0], from[0], to[0], m, nullptr, nullptr, k, grid, sum);
        many::gather_pairs(ray, beam, from, to, m, nullptr, {}, k, grid, again, accepted);
        if (std::memcmp(&sum, &again,
                        sizeof sum) != 0 || (accepted[0] != 0) != counts) throw Mismatch("the array form differs");
        out << counts << sum;
    };
    single_["beam_map_new"] = [this](In& in, Out&) { map_.reset(new cb::BeamMap(medium(in))); };
    single_["beam_map_add"] = [this](In& in, Out&) { map_->add(in.rest<covbeam_beam>()); };
    single_["beam_map_commit"] = [this](In& in, Out&) { map_->commit(in.f()); };
    single_["beam_map_clear"] = [this](In&, Out&) { map_->clear(); };
    single_["beam_map_gather"] = [this](In& in, Out& out) {
        const cb::Grid* grid = used(in);
        const cb::Kernel k = kernel(in);
        const std::vector<covbeam_eye_ray> rays = in.rest<covbeam_eye_ray>();
        std::vector<covbeam_gathered> gathered(rays.size());
        map_->gather(k, grid, rays, gathered, scratch_);
        out.all(gathered);
    };
}

void Client::image_space() {
    struct Two {
        covbeam_pixel_step steps[2];
    };
    gives("image_spectrum_along", [this](In& in) {
        const cb::Medium m = medium(in);
        const covbeam_eye_ray ray = in.take<covbeam_eye_ray>();
        const Two two = in.take<Two>();
        return cb::ImageSpectrum::along(*grid_, m, ray, two.steps);
    });
    array("image_spectrum_along", 16, [this](In& in, Rows& r) {
        many::along(*grid_, medium(in), r.get<covbeam_eye_ray>(0), r.get<covbeam_pixel_step, 2>(7),
                    r.put<covbeam_image_spectrum>());
    });
    gives("image_spectrum_filter", [](In& in) {
        const cb::ImageSpectrum s = in.take<cb::ImageSpectrum>();
        const float error = in.f();
        return s.filter(error, in.f());
    });
    array("image_spectrum_filter", 0, [](In&, Rows& r) {
        many::filter(r.get<covbeam_image_spectrum>(0), r.f(4), r.f(5), r.put<covbeam_image_filter>());
    });
    gives("image_filter_density", [](In& in) { return in.take<cb::ImageFilter>().density(); });
    array("image_filter_density", 0,
          [](In&, Rows& r) { many::density(r.get<covbeam_image_filter>(0), r.put<float>()); });
    gives("pixel_threshold", [](In& in) {
        const uint32_t pass = in.u(), seed = in.u(), pixel[1][2] = {{in.u(), in.u()}};
        const float threshold = cb::pixel_threshold(pass, seed, pixel[0]);
        float again[1];
        many::pixel_threshold(pass, seed, pixel, again);
        if (std::memcmp(&threshold, again, 4) != 0) throw Mismatch("the array form differs");
        return threshold;
    });
    single_["film_regions"] = [](In& in, Out& out) {
        const uint32_t width = in.u(), height = in.u();
        const std::vector<float> depths = in.rest<float>();
        std::vector<uint32_t> labels(depths.size());
        cb::film_regions(width, height, depths, labels);
        out.all(labels);
    };
    single_["film_new"] = [this](In& in, Out&) {
        const uint32_t width = in.u(), height = in.u();
        const float typical = in.f();
        film_.reset(new cb::Film(width, height, typical, in.rest<uint32_t>()));
        film_pixels_ = size_t(width) * height;
    };
    single_["film_nodes"] = [this](In&, Out& out) {
        std::vector<uint32_t> nodes(2 * film_->node_count());
        film_->nodes({nodes.data(), nodes.size() / 2, 8});
        out.all(nodes);
        if (film_->memory() < 20 * film_pixels_) throw Mismatch("a film of no size");
    };
    single_["film_plan"] = [this](In& in, Out&) {
        const uint32_t pass = in.u();
        const float error = in.f();
        const uint32_t paths = in.u();
        film_->plan(pass, error, paths, in.rest<covbeam_image_spectrum>());
    };
    single_["film_density"] = [this](In&, Out& out) {
        std::vector<float> densities(film_pixels_);
        film_->density(densities);
        out.all(densities);
    };
    single_["film_add"] = [this](In& in, Out&) { film_->add(in.rest<covbeam_film_ray>()); };
    single_["film_picture"] = [this](In&, Out& out) {
        std::vector<covbeam_film_pixel> pixels(film_pixels_);
        film_->verify();
        film_->picture(0, pixels);
        out.all(pixels);
    };
    single_["film_errors"] = [](In& in, Out& out) {
        const uint32_t width = in.u(), height = in.u();
        std::vector<covbeam_film_pixel> pixels(in.left() / 2);
        for (covbeam_film_pixel& pixel : pixels) {
            pixel.variance = in.f();
            pixel.difference = in.f();
        }
        std::vector<float> errors(pixels.size());
        cb::film_errors(width, height, pixels, errors);
        out.all(errors);
    };
}

void Client::marches() {
    single_["march_lay"] = [](In& in, Out& out) {
        const Vec origin = in.take<Vec>(), direction = in.take<Vec>();
        const float from = in.f(), to = in.f();
        const Vec light = in.take<Vec>();
        std::vector<covbeam_march_knot> knots(in.u());
        cb::March::lay(origin, direction, from, to, light, knots);
        for (const covbeam_march_knot& knot : knots) out << knot.distance;
    };
    single_["march_update"] = [this](In& in, Out&) { march_.update(in.rest<covbeam_march_knot>()); };
    gives("march_get_expected", [this](In&) { return march_.expected(); });
    gives("march_get_first_round", [this](In& in) { return uint32_t(march_.first_round(in.u())); });
    single_["march_place"] = [this](In& in, Out& out) {
        const std::vector<float> jitters = in.rest<float>();
        std::vector<covbeam_march_sample> samples(jitters.size());
        march_.place(jitters, samples);
        out.all(samples);
    };
    single_["march_refine"] = [this](In& in, Out& out) {
        std::vector<covbeam_march_sample> firsts(in.u());
        for (covbeam_march_sample& first : firsts) first = in.take<covbeam_march_sample>();
        const std::vector<float> jitters = in.rest<float>();
        std::vector<covbeam_march_sample> samples(jitters.size());
        march_.refine(firsts, jitters, samples);
        out.all(samples);
    };
}

void Client::importances() {
    struct Weighted {
        covbeam_eye_ray ray;
        float weight;
    };
    single_["importance_new"] = [this](In& in, Out&) {
        importance_.reset(new cb::Importance(in.take<covbeam_grid_layout>()));
    };
    using Add = void (cb::Importance::*)(const covbeam_medium&, cb::Importance::Pieces, cb::Floats);
    const auto adds = [this](const char* name, Add add) {
        single_[name] = [this, add](In& in, Out&) {
            const cb::Medium fog = medium(in);
            const std::vector<Weighted> all = in.rest<Weighted>();
            ((*importance_).*add)(fog, cb::Importance::Pieces::of(&all[0].ray, all.size(), sizeof all[0]),
                                  cb::Floats::of(&all[0].weight, all.size(), sizeof all[0]));
        };
    };
    adds("importance_add_eye_rays", &cb::Importance::add_eye_rays);
    adds("importance_add_paths", &cb::Importance::add_paths);
    single_["importance_add_surfaces"] = [this](In& in, Out&) {
        struct Place {
            Vec at;
            float weight;
        };
        const std::vector<Place> all = in.rest<Place>();
        importance_->add_surfaces(cb::Vectors::of(&all[0].at, all.size(), sizeof all[0]),
                                  cb::Floats::of(&all[0].weight, all.size(), sizeof all[0]));
    };
    single_["importance_resolve"] = [this](In&, Out&) { importance_->resolve(); };
    single_["importance_at"] = [this](In& in, Out& out) {
        const std::vector<Vec> positions = in.rest<Vec>();
        std::vector<covbeam_importance_cell> cells(positions.size());
        importance_->at(positions, cells);
        out.all(cells);
    };
    single_["importance_of_segments"] = [this](In& in, Out& out) {
        const cb::Medium fog = medium(in);
        const std::vector<covbeam_eye_ray> segments = in.rest<covbeam_eye_ray>();
        std::vector<covbeam_segment_importance> worths(segments.size());
        importance_->of_segments(fog, segments, worths);
        out.all(worths);
    };
    single_["weight_window"] = [](In& in, Out& out) {
        std::vector<float> factors(in.left() - 1);
        for (float& factor : factors) factor = in.f();
        cb::weight_window(factors, in.f());
        out.all(factors);
    };
    single_["emission_guide_fill"] = [this](In& in, Out& out) {
        const uint32_t side = in.u();
        std::vector<float> weights(side * side);
        for (float& weight : weights) weight = in.f();
        guide_.reset(new cb::EmissionGuide(side, weights, in.f()));
        out.all(guide_->numbers());
    };
    // The guide is that of the line before.
    single_["emission_guide_warp"] = [this](In& in, Out& out) {
        in.u();
        for (float number : guide_->numbers())
            if (number != in.f()) throw Mismatch("another guide");
        const std::vector<Pair> points = in.rest<Pair>();
        std::vector<Pair> places(points.size());
        std::vector<float> densities(points.size());
        guide_->warp(points, places, densities);
        for (size_t i = 0; i < points.size(); ++i) out << places[i] << densities[i];
    };
}

} // namespace

int main(int argc, char** argv) {
    if (argc != 2) return std::fprintf(stderr, "usage: vectors VECTORS.txt\n"), 2;
    std::ifstream file(argv[1]);
    if (!file) return std::fprintf(stderr, "%s cannot be read\n", argv[1]), 1;
    Client client;
    size_t number = 0;
    std::string line;
    try {
        while (std::getline(file, line)) {
            ++number;
            if (line.empty() || line[0] == '#') continue;
            std::istringstream split(line);
            std::string name, word;
            Words in, out, *side = &in;
            split >> name;
            while (split >> word) {
                if (word == "->") side = &out;
                else side->push_back({std::stoull(word, nullptr, 16), word.size()});
            }
            client.line(name, in, out);
        }
        client.flush();
    } catch (const std::exception& error) {
        std::printf("line %zu: %s\n  %s\n", number, line.substr(0, line.find(' ')).c_str(), error.what());
        return 1;
    }
    return client.end();
}
