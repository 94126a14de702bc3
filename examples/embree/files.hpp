// Meshes of Wavefront OBJ files, with normals and texture coordinates, and images of portable pixel maps, in the folder EXAMPLES.
#pragma once

#include <array>
#include <charconv>
#include <covbeam_session.hpp>
#include <cstdint>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

using covbeam::Vec3, covbeam::vec;

struct Mesh {
    std::vector<std::array<float, 4>> positions; // the fourth number is 0: Embree reads sixteen bytes
    std::vector<std::array<uint32_t, 3>> triangles;
    // Of the three corners of each triangle; empty if a corner of the file has none.
    std::vector<std::array<std::array<float, 3>, 3>> normals;
    std::vector<std::array<std::array<float, 3>, 3>> uvs; // the third number is 0

    std::array<Vec3, 3> corners(uint32_t triangle) const {
        const auto& [a, b, c] = triangles[triangle];
        return {vec(positions[a]), vec(positions[b]), vec(positions[c])};
    }
};

// Of three corners.
inline std::array<Vec3, 3> vectors(const std::array<std::array<float, 3>, 3>& of) { return {vec(of[0]), vec(of[1]), vec(of[2])}; }

struct Image { // rows from the top; it repeats; without pixels it is white
    size_t width = 0, height = 0;
    std::vector<std::array<float, 3>> pixels;

    Vec3 at(double u, double v) const { // bilinear
        if (pixels.empty()) return {1, 1, 1};
        const double x = (u - std::floor(u) + 1) * double(width) - 0.5, y = (std::ceil(v) - v + 1) * double(height) - 0.5;
        const auto pixel = [&](size_t i, size_t j) { return vec(pixels[(size_t(y) + j) % height * width + (size_t(x) + i) % width]); };
        const double a = x - std::floor(x), b = y - std::floor(y);
        return (pixel(0, 0) * (1 - a) + pixel(1, 0) * a) * (1 - b) + (pixel(0, 1) * (1 - a) + pixel(1, 1) * a) * b;
    }
};

namespace obj {

// The numbers of a corner: position / texture coordinates / normal, from 1 on, or back from the last one if below 0; 0: there is none.
inline std::array<long, 3> corner(const std::string& word) {
    std::array<long, 3> numbers{};
    const char *at = word.data(), *end = at + word.size();
    for (long& number : numbers) {
        at = std::from_chars(at, end, number).ptr;
        if (at == end || *at != '/') break;
        ++at;
    }
    if (at != end) throw std::runtime_error("not a corner: " + word);
    return numbers;
}

inline std::array<float, 3> numbers(std::istringstream& line, size_t count) {
    std::array<float, 3> read{};
    for (size_t i = 0; i < count; ++i)
        if (!(line >> read[i])) throw std::runtime_error("numbers are missing: " + line.str());
    return read;
}

template <class T> T element(const std::vector<T>& list, long number) {
    const long count = static_cast<long>(list.size()), index = number < 0 ? count + number : number - 1;
    if (index < 0 || index >= count) throw std::runtime_error("no element " + std::to_string(number));
    return list[static_cast<size_t>(index)];
}

} // namespace obj

// Throws where the file is none.
inline Mesh load_mesh(const std::string& name) {
    const std::string path = EXAMPLES + name;
    std::ifstream file(path);
    if (!file) throw std::runtime_error(path + ": cannot be read");
    Mesh mesh;
    std::vector<std::array<float, 3>> normals;
    std::vector<std::array<float, 3>> uvs;
    std::vector<uint32_t> numbered; // so that positions are found as the others are
    bool has_normals = true, has_uvs = true;
    size_t row = 0;
    try {
        for (std::string text; std::getline(file, text);) {
            ++row;
            std::istringstream line(text);
            std::string kind;
            line >> kind;
            if (kind == "v") {
                numbered.push_back(static_cast<uint32_t>(mesh.positions.size()));
                const auto [x, y, z] = obj::numbers(line, 3);
                mesh.positions.push_back({x, y, z, 0});
            } else if (kind == "vn") {
                normals.push_back(obj::numbers(line, 3));
            } else if (kind == "vt") {
                uvs.push_back(obj::numbers(line, 2));
            } else if (kind == "f") {
                std::vector<std::array<long, 3>> corners;
                for (std::string word; line >> word;) corners.push_back(obj::corner(word));
                for (const auto& c : corners) has_uvs = has_uvs && c[1] != 0, has_normals = has_normals && c[2] != 0;
                for (size_t i = 2; i < corners.size(); ++i) {
                    const std::array<std::array<long, 3>, 3> fan = {corners[0], corners[i - 1], corners[i]};
                    mesh.triangles.emplace_back();
                    mesh.normals.emplace_back();
                    mesh.uvs.emplace_back();
                    for (size_t k = 0; k < 3; ++k) {
                        mesh.triangles.back()[k] = obj::element(numbered, fan[k][0]);
                        if (has_uvs) mesh.uvs.back()[k] = obj::element(uvs, fan[k][1]);
                        if (has_normals) mesh.normals.back()[k] = obj::element(normals, fan[k][2]);
                    }
                }
            }
        }
    } catch (const std::runtime_error& error) {
        throw std::runtime_error(path + ":" + std::to_string(row) + ": " + error.what());
    }
    if (!has_normals) mesh.normals.clear();
    if (!has_uvs) mesh.uvs.clear();
    return mesh;
}

// Binary, of 256 levels as displays have them. The same.
inline Image load_image(const std::string& name) {
    const std::string path = EXAMPLES + name;
    std::ifstream file(path, std::ios::binary);
    std::string kind, levels;
    Image made;
    file >> kind >> made.width >> made.height >> levels;
    file.get();
    if (kind != "P6" || levels != "255" || made.width > 8192 || made.height > 8192) throw std::runtime_error(path + ": no binary PPM of 256 levels");
    made.pixels.resize(made.width * made.height);
    for (auto& pixel : made.pixels)
        for (float& channel : pixel) channel = std::pow(float(file.get()) / 255, 2.2f);
    if (!file) throw std::runtime_error(path + ": too short");
    return made;
}
