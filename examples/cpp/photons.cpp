#include "photons.hpp"

#include <limits>

namespace {

// The ball is the only thing that casts a shadow: its silhouette lies where the ray comes closest to the centre. A renderer of
// meshes lets covbeam::Segment::find_edges look for it with a few probe rays.
void find_edges(const Scene& scene, Vec3 origin, Vec3 direction, covbeam_segment& segment) {
    const Vec3 to = scene.center - origin;
    const float nearest = dot(to, direction);
    const Vec3 towards = to - nearest * direction;
    const float gap = length(towards) - scene.radius;
    segment.edge_count = gap > 0 && nearest > 0 && nearest < segment.length;
    segment.edges[0].depth = nearest, segment.edges[0].distance = gap;
    store(towards, segment.edges[0].towards);
}

} // namespace

void trace(const Scene& scene, const Lamp& lamp, const covbeam::Medium& fog, Random random, float scale,
           bool bandwidth, Share& out) {
    const float extinction = fog.scattering[0] + fog.absorption[0], albedo = fog.scattering[0] / extinction;
    const covbeam::Phase phase(fog.phase.kind, fog.phase.asymmetry);

    const float u = random.uniform(), v = random.uniform();
    Vec3 origin = lamp.position, normal{0, 0, 0};
    Vec3 direction = around(lamp.axis, 1 - u * (1 - std::cos(lamp.outer)), v);
    float power = lamp.radiant_intensity(direction) * lamp.solid_angle() * scale;
    if (!(power > 0)) return;
    bool unscattered = true;

    // A point: infinite spatial variance, and the lamp's own angular one.
    const float infinity = std::numeric_limits<float>::infinity(), spatial[2] = {infinity, infinity};
    float angular[2];
    lamp.angular_variance(direction, angular);
    covbeam::LightField field = covbeam::LightField::gaussian(direction.data(), lamp.axis.data(), spatial, angular);

    for (;;) {
        const Hit hit = scene.intersect(origin, direction);

        // The beam runs to the surface whatever the photon does: the gather takes the transmittance along it.
        covbeam_beam beam = {};
        store(origin, beam.origin), store(direction, beam.direction), store(normal, beam.start_normal);
        store(hit.normal, beam.end_normal);
        beam.length = hit.distance;
        beam.power[0] = beam.power[1] = beam.power[2] = power;
        out.beams.push_back(beam);

        const float column = -std::log(1 - random.uniform()) / extinction;
        const float flight = fog.distance_at(origin.data(), direction.data(), hit.distance, column);
        const bool collides = flight < hit.distance;
        const float distance = collides ? flight : hit.distance;
        if (bandwidth) {
            // Like the beam, what goes into the grid runs to the surface; the field itself stops where the photon does.
            covbeam::Segment segment;
            store(origin, segment.origin);
            segment.length = hit.distance;
            segment.power = power;
            segment.unscattered = unscattered;
            segment.field = field;
            find_edges(scene, origin, direction, segment);
            out.segments.push_back(segment);
            field = segment.field_at(fog, distance);
        }
        // Survival by the albedo keeps the power of a path as it is.
        if (random.uniform() >= (collides ? albedo : hit.albedo)) return;
        origin = origin + distance * direction;
        if (collides) {
            const float xi[2] = {random.uniform(), random.uniform()};
            Vec3 scattered;
            phase.sample(direction.data(), xi, &scattered.x);
            if (bandwidth) field.scatter(scattered.data(), phase.angular_variance());
            direction = scattered, normal = {0, 0, 0};
        } else {
            const float c = std::sqrt(1 - random.uniform());
            direction = around(hit.normal, c, random.uniform());
            normal = hit.normal;
            origin = origin + 1e-4f * normal;
            if (bandwidth) field.diffuse(normal.data(), direction.data());
        }
        unscattered = false;
    }
}
