// What a renderer has already: vectors, geometry, a lamp, a camera. Nothing here knows covbeam.
#pragma once

#include <algorithm>
#include <cmath>

constexpr float PI = 3.14159265f;

struct Vec3 {
    float x, y, z;
    const float* data() const { return &x; } // what C functions take
};
inline Vec3 operator+(Vec3 a, Vec3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vec3 operator-(Vec3 a, Vec3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vec3 operator*(float s, Vec3 a) { return {s * a.x, s * a.y, s * a.z}; }
inline float dot(Vec3 a, Vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vec3 cross(Vec3 a, Vec3 b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }
inline float length(Vec3 a) { return std::sqrt(dot(a, a)); }
inline Vec3 normalize(Vec3 a) { return (1 / length(a)) * a; }
inline void store(Vec3 a, float* out) { out[0] = a.x, out[1] = a.y, out[2] = a.z; }

// A direction around `axis`, given by its cosine and its azimuth in turns.
inline Vec3 around(Vec3 axis, float cosine, float turns) {
    const Vec3 u = normalize(cross(std::abs(axis.x) < 0.5f ? Vec3{1, 0, 0} : Vec3{0, 1, 0}, axis));
    const float sine = std::sqrt(std::max(0.0f, 1 - cosine * cosine)), phi = 2 * PI * turns;
    return normalize(sine * std::cos(phi) * u + sine * std::sin(phi) * cross(axis, u) + cosine * axis);
}

struct Hit {
    float distance;
    Vec3 normal; // towards the fog
    float albedo;
};

// A ball in a dark room with a grey floor.
struct Scene {
    Vec3 room_min{-4, 0, -7}, room_max{4, 5, 4};
    Vec3 center{0.1f, 1.9f, 0};
    float radius = 0.4f;

    Hit intersect(Vec3 origin, Vec3 direction) const {
        // From inside, a box is left through the nearest of the three faces ahead.
        const float *o = origin.data(), *d = direction.data(), *lo = room_min.data(), *hi = room_max.data();
        Hit hit{1e30f, {0, 1, 0}, 0};
        for (int axis = 0; axis < 3; ++axis) {
            if (d[axis] == 0) continue;
            const float t = std::max(0.0f, ((d[axis] > 0 ? hi : lo)[axis] - o[axis]) / d[axis]);
            if (t >= hit.distance) continue;
            float normal[3] = {0, 0, 0};
            normal[axis] = d[axis] > 0 ? -1.0f : 1.0f;
            hit = {t, {normal[0], normal[1], normal[2]}, axis == 1 && d[1] < 0 ? 0.15f : 0.0f};
        }
        const Vec3 to = center - origin;
        const float along = dot(to, direction), gap2 = dot(to - along * direction, to - along * direction);
        if (along > 0 && gap2 < radius * radius) {
            const float t = along - std::sqrt(radius * radius - gap2);
            if (t > 1e-3f && t < hit.distance) hit = {t, normalize(origin + t * direction - center), 0.3f};
        }
        return hit;
    }
};

// A spot lamp. Between the inner and the outer cone its intensity falls as a smooth step.
struct Lamp {
    Vec3 position{-0.5f, 4.2f, 0};
    Vec3 axis = normalize(Vec3{0.6f, -2.3f, 0});
    float intensity = 200, inner = 0.314f, outer = 0.349f;

    float radiant_intensity(Vec3 direction) const {
        const float q = std::min(std::max((outer - angle(direction)) / (outer - inner), 0.0f), 1.0f);
        return intensity * q * q * (3 - 2 * q);
    }
    float angle(Vec3 direction) const { return std::acos(std::min(dot(direction, axis), 1.0f)); }
    float solid_angle() const { return 2 * PI * (1 - std::cos(outer)); }

    // How fast the light varies with direction, towards the axis and around it, as the variance of its angular spectrum: the
    // relative second derivatives of I(theta)/d^2 over 4 pi^2. On the steep rim the slope says more than the curvature.
    void angular_variance(Vec3 direction, float out[2]) const {
        const float theta = angle(direction), width = outer - inner, q = (outer - theta) / width;
        float towards = 2, across = 2; // of the 1/d^2 alone
        if (q > 0 && q < 1) {
            const float falloff = q * q * (3 - 2 * q), slope = -6 * q * (1 - q) / (width * falloff);
            towards = std::max(std::abs((6 - 12 * q) / (width * width * falloff) - 2), slope * slope);
            across = 2 - slope / std::tan(theta);
        }
        out[0] = towards / (4 * PI * PI), out[1] = across / (4 * PI * PI);
    }
};

struct Camera {
    int width = 256, height = 256;
    Vec3 position{0.4f, 1.7f, -6.6f}, target{0.1f, 1.62f, 0};
    float half = 0.2962f; // tan(33 degrees / 2)

    Vec3 direction(float x, float y) const {
        const Vec3 forward = normalize(target - position), right = normalize(cross(forward, {0, 1, 0}));
        const Vec3 up = cross(right, forward);
        const float u = (2 * x - float(width)) / float(height) * half, v = (1 - 2 * y / float(height)) * half;
        return normalize(forward + u * right + v * up);
    }
};
