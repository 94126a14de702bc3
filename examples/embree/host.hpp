// What covbeam asks of a renderer: rays, by Embree, and what surfaces, the lamp and the camera do.
#pragma once

#include "scene.hpp"

#include <cstring>
#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
template <class Function, class Ray> void run(Function function, RTCScene scene, Ray& ray) { function(scene, &ray, nullptr); }
#else
#include <embree3/rtcore.h>
template <class Function, class Ray> void run(Function function, RTCScene scene, Ray& ray) {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    function(scene, &context, &ray);
}
#endif

class Host {
public:
    explicit Host(const World& world) : world_(world), lamp_(world.lights[0]), camera_(world.fixed.camera) {
        rtcSetSceneFlags(scene_, RTC_SCENE_FLAG_ROBUST); // no ray gets through where triangles meet
        for (const Solid& solid : world.solids) {
            const auto& [places, triangles, normals, uvs] = solid.mesh;
            RTCGeometry made = rtcNewGeometry(device_, triangles.empty() ? RTC_GEOMETRY_TYPE_SPHERE_POINT : RTC_GEOMETRY_TYPE_TRIANGLE);
            if (triangles.empty()) {
                rtcSetSharedGeometryBuffer(made, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT4, &solid.ball, 0, 16, 1);
            } else {
                rtcSetSharedGeometryBuffer(made, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, places.data(), 0, 16, places.size());
                rtcSetSharedGeometryBuffer(made, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, triangles.data(), 0, 12, triangles.size());
            }
            rtcSetGeometryUserData(made, const_cast<Solid*>(&solid));
            rtcSetGeometryIntersectFilterFunction(made, filter);
            rtcSetGeometryOccludedFilterFunction(made, filter);
            rtcCommitGeometry(made);
            rtcAttachGeometry(scene_, made); // by the solid's number
            rtcReleaseGeometry(made);
        }
        rtcCommitScene(scene_);
        if (rtcGetDeviceError(device_) != RTC_ERROR_NONE) throw std::runtime_error("Embree refuses the scene");
    }
    Host(const Host&) = delete;
    ~Host() { rtcReleaseScene(scene_), rtcReleaseDevice(device_); }

    void cast(const covbeam_host_ray& ray, covbeam_host_hit& hit) const {
        RTCRayHit found{embree(ray), {}};
        found.hit.geomID = RTC_INVALID_GEOMETRY_ID;
        run(rtcIntersect1, scene_, found);
        if (found.hit.geomID == RTC_INVALID_GEOMETRY_ID) return;
        const Solid& solid = world_.solids[found.hit.geomID];
        const uint32_t number = found.hit.primID;
        if (!meet(solid, number, found.ray.tfar, ray, hit)) return void(hit.distance = 0);
        hit.object = hit.material = found.hit.geomID, hit.mark[0] = number;
        std::memcpy(&hit.mark[1], &found.hit.u, 2 * sizeof(float)); // u and v
        if (!solid.mesh.normals.empty())
            covbeam::smooth(hit, solid.mesh.corners(number), vectors(solid.mesh.normals[number]), found.hit.u, found.hit.v);
    }
    void blocked(const covbeam_host_ray& ray, uint8_t& is_blocked) const {
        RTCRay asked = embree(ray);
        run(rtcOccluded1, scene_, asked);
        is_blocked = asked.tfar < 0;
    }

    void lobes(const covbeam_host_hit& hit, covbeam_material& there) const {
        const auto& [mesh, ball, texture, mask] = world_.solids[hit.object];
        float at[2];
        std::memcpy(at, &hit.mark[1], sizeof at);
        const auto [a, b, c] = mesh.uvs.empty() ? std::array<Vec3, 3>{} : vectors(mesh.uvs[hit.mark[0]]);
        const Vec3 uv = a * (1 - at[0] - at[1]) + b * at[0] + c * at[1], solid = mask.at(uv.x, uv.y);
        (vec(world_.materials[hit.material].diffuse) * texture.at(uv.x, uv.y) * solid).store(there.diffuse);
        (Vec3{1, 1, 1} - solid).store(there.transparent);
    }
    void scatter(const covbeam_host_meeting& met, covbeam_host_ways& ways) const { // Lambert's law, mirrors; glass by Snell and Fresnel
        covbeam_material there = world_.materials[met.hit.material];
        lobes(met.hit, there);
        const bool enters = vec(met.direction).dot(vec(met.hit.normal)) < 0;
        const Vec3 along = vec(met.direction), normal = vec(met.hit.normal) * (enters ? 1 : -1);
        const double index = there.ior, eta = enters ? 1 / index : index, cosine = -along.dot(normal);
        const double beyond2 = 1 - eta * eta * (1 - cosine * cosine), beyond = std::sqrt(std::max(0.0, beyond2));
        const double s = (eta * cosine - beyond) / (eta * cosine + beyond), p = (cosine - eta * beyond) / (cosine + eta * beyond);
        const double share = beyond2 > 0 ? (s * s + p * p) / 2 : 1;
        const Vec3 reflected = along + normal * (2 * cosine), refracted = along * eta + normal * (eta * cosine - beyond);
        reflected.unit().store(ways.reflected[0].direction), refracted.unit().store(ways.refracted.direction);
        (vec(there.metal) + vec(there.glass_reflection) * share).store(ways.reflected[0].factor);
        (vec(there.glass_transmission) * (1 - share)).store(ways.refracted.factor), vec(there.diffuse).store(ways.diffuse);
    }

    void emit(const covbeam_host_draw& draw, covbeam_host_photon& photon) const { // evenly over the lamp's cone
        const double height = 1 - lamp_.cosine, fall = draw.place[0] * height, out = std::sqrt(fall * (2 - fall)), turn = 2 * PI * draw.place[1];
        const Vec3 axis = vec(lamp_.axis), side = axis.aside() * std::cos(turn) + axis.cross(axis.aside()) * std::sin(turn);
        const double q = rise(1 - fall), slope = q < 1 ? 6 * (1 - q) / (q * (3 - 2 * q)) * out / lamp_.blend : 0; // of the light over itself
        vec(lamp_.position).store(photon.origin), (axis * (1 - fall) + side * out).unit().store(photon.direction);
        (vec(lamp_.intensity) * (2 * PI * height * falloff(q))).store(photon.power);
        photon.angular_variance = float(slope * slope / (4 * PI * PI));
    }
    void illuminate(const covbeam_host_question& question, covbeam_host_arrival& arrival) const {
        const Vec3 way = vec(question.place) - vec(lamp_.position);
        const double share = falloff(rise(way.unit().dot(vec(lamp_.axis)))) / way.dot(way);
        (vec(lamp_.intensity) * share).store(arrival.density), vec(lamp_.position).store(arrival.from);
    }
    void eye(const covbeam_host_pixel& pixel, covbeam_host_eye_ray& ray) const {
        const Vec3 forward = vec(camera_.forward).unit(), right = forward.cross(vec(camera_.up)).unit();
        const double x = pixel.place[0] - 0.5 * camera_.width, y = 0.5 * camera_.height - pixel.place[1], step = 2 * camera_.half_height / camera_.height;
        vec(camera_.position).store(ray.origin), (forward + (right * x + right.cross(forward) * y) * step).unit().store(ray.direction);
    }

private:
    static RTCRay embree(const covbeam_host_ray& ray) {
        RTCRay made{};
        vec(ray.origin).store(&made.org_x), vec(ray.direction).store(&made.dir_x), made.tfar = float(ray.reach), made.mask = ~0u;
        return made;
    }
    // What Embree has found in floats, in doubles: nothing on a surface that the ray has just left.
    static bool meet(const Solid& solid, uint32_t number, float distance, const covbeam_host_ray& ray, covbeam_host_hit& hit) {
        if (!solid.mesh.triangles.empty()) return covbeam::meet_triangle(ray, solid.mesh.corners(number), hit);
        return covbeam::meet_sphere(ray, vec(solid.ball), solid.ball[3], distance, hit);
    }
    static void filter(const RTCFilterFunctionNArguments* a) {
        const RTCRay& ray = *reinterpret_cast<const RTCRay*>(a->ray); // of one
        if (ray.tfar > 0.01f * std::max({std::abs(ray.org_x), std::abs(ray.org_y), std::abs(ray.org_z)})) return; // beyond doubt
        covbeam_host_ray asked = {{}, {}, INFINITY};
        vec(&ray.org_x).store(asked.origin), vec(&ray.dir_x).store(asked.direction);
        covbeam_host_hit hit;
        if (!meet(*static_cast<const Solid*>(a->geometryUserPtr), RTCHitN_primID(a->hit, 1, 0), ray.tfar, asked, hit)) a->valid[0] = 0;
    }
    double rise(double cosine) const { // from the border of the lamp's cone, 0, to where it shines in full, 1
        return lamp_.kind == COVBEAM_LIGHT_POINT ? 1 : std::clamp((cosine - lamp_.cosine) / lamp_.blend, 0.0, 1.0);
    }
    static double falloff(double q) { return q * q * (3 - 2 * q); }

    const World& world_;
    const covbeam_light& lamp_;
    const covbeam_camera& camera_;
    RTCDevice device_ = rtcNewDevice("threads=1"); // of the same scene the same hierarchy
    RTCScene scene_ = rtcNewScene(device_);
};
