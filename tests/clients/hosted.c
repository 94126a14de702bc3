#include "hosted.h"
#include <float.h>
#include <math.h>
#include <string.h>

enum { CAST, BLOCKED, LOBES, SCATTER, EMIT, ILLUMINATE, EYE };

static const double ball_radius = 0.5, floor_height = -0.6, floor_radius = 2, lamp_height = 1.5, lamp_intensity = 2;

/* Counters go up from all threads, and nobody reads them before the end. */
static uint64_t count(uint64_t *counter) { return __atomic_fetch_add(counter, 1, __ATOMIC_RELAXED); }

uint64_t hosted_sum(const uint64_t *counters) {
    uint64_t sum = 0;
    for (int i = 0; i < 7; i++) sum += __atomic_load_n(&counters[i], __ATOMIC_RELAXED);
    return sum;
}

/* A number from a number: the finalizer of splitmix64. */
static uint64_t mixed(uint64_t n) {
    n = (n ^ (n >> 30)) * 0xbf58476d1ce4e5b9u;
    n = (n ^ (n >> 27)) * 0x94d049bb133111ebu;
    return n ^ (n >> 31);
}

static float any_number(uint64_t bits) {
    static const float all[] = { NAN,      INFINITY, -INFINITY, 0,        -0.0f,    1e-45f, -1e-45f, FLT_MIN,
                                 -FLT_MIN, FLT_MAX,  -FLT_MAX,  1e-10f,   -1e-10f,  1,      -1,      1e30f,
                                 -1e30f,   1e9f,     -1e9f,     1.0005f,  0.5f,     -0.5f,  1e5f,    -1e5f };
    float number;
    const uint32_t word = (uint32_t)(bits >> 32);
    memcpy(&number, &word, sizeof number);
    return bits % 4 == 0 ? number : all[bits / 4 % (sizeof all / sizeof *all)];
}

/* Makes a lie of an answer, a struct of floats and 32-bit integers, now and then: `what` is the number of the function. */
static void lie(struct hosted *hosted, int what, void *answer, const void *before, size_t size) {
    const uint64_t asked = count(&hosted->asked[what]);
    if (hosted->lies == 0) return;
    uint64_t bits = mixed(hosted->seed + asked * 8 + (uint64_t)what);
    if (bits % hosted->lies != 0) return;
    count(&hosted->told[what]);
    bits = mixed(bits + 1);
    const size_t words = size / 4;
    switch (bits >> 61) {
    case 0: /* another answer than that before, or none */
        memcpy(answer, before, size);
        break;
    case 1: /* all of it is nonsense */
    case 2:
        for (size_t i = 0; i < words; i++) {
            const float number = any_number(bits = mixed(bits + 1));
            memcpy((char *)answer + 4 * i, &number, 4);
        }
        break;
    case 3: /* three neighbours: a vector */
    case 4: {
        const size_t first = bits / 64 % words;
        for (size_t i = first; i < first + 3 && i < words; i++) {
            const float number = any_number(bits = mixed(bits + 1));
            memcpy((char *)answer + 4 * i, &number, 4);
        }
        break;
    }
    default: { /* one number */
        const float number = any_number(mixed(bits + 1));
        memcpy((char *)answer + bits / 64 % words * 4, &number, 4);
    }
    }
}

/* Calls `truth` for each, and lies. `before` is what an answer holds when it is asked for. */
#define ANSWER(what, answers, truth)                                         \
    for (size_t i = 0; i < many; i++) {                                      \
        unsigned char before[sizeof *(answers)];                             \
        memcpy(before, &(answers)[i], sizeof before);                        \
        truth;                                                               \
        lie(user, what, &(answers)[i], before, sizeof before);               \
    }

static void set_direction(float out[3], double x, double y, double z) {
    const double length = sqrt(x * x + y * y + z * z);
    out[0] = (float)(x / length);
    out[1] = (float)(y / length);
    out[2] = (float)(z / length);
}

static void hit_at(const covbeam_host_ray *ray, double distance, covbeam_host_hit *hit) {
    for (int i = 0; i < 3; i++) hit->position[i] = (float)(ray->origin[i] + distance * ray->direction[i]);
    hit->distance = (float)distance;
    hit->offset = 2e-6f;
}

/* The ball is object 0, the floor object 1; materials change with the place, as with textures. */
static void meet(const covbeam_host_ray *ray, covbeam_host_hit *hit) {
    const double *o = ray->origin, *d = ray->direction;
    double nearest = ray->reach;
    const double foot = -(o[0] * d[0] + o[1] * d[1] + o[2] * d[2]);
    double apart = 0;
    for (int i = 0; i < 3; i++) apart += (o[i] + foot * d[i]) * (o[i] + foot * d[i]);
    if (apart < ball_radius * ball_radius) {
        const double half = sqrt(ball_radius * ball_radius - apart);
        const double distance = foot - half > 1e-7 ? foot - half : foot + half;
        if (distance > 1e-7 && distance < nearest) {
            nearest = distance;
            hit_at(ray, distance, hit);
            double normal[3];
            for (int i = 0; i < 3; i++) normal[i] = o[i] + distance * d[i];
            set_direction(hit->geometric_normal, normal[0], normal[1], normal[2]);
            set_direction(hit->normal, normal[0], normal[1], normal[2]);
            set_direction(hit->tangent, normal[1] + 1e-9, -normal[0], 0);
            hit->along = hit->across = (float)(1 / ball_radius);
            hit->material = hit->position[0] > 0 ? 2 : 1;
        }
    }
    const double down = (floor_height - o[1]) / d[1];
    if (down > 1e-7 && down < nearest) {
        const double x = o[0] + down * d[0], z = o[2] + down * d[2];
        if (x * x + z * z < floor_radius * floor_radius) {
            memset(hit, 0, sizeof *hit);
            hit_at(ray, down, hit);
            hit->geometric_normal[1] = hit->normal[1] = 1;
            hit->object = 1;
            hit->material = x * z > 0 ? 0 : 1;
        }
    }
}

static void cast(void *user, size_t many, const covbeam_host_ray *rays, covbeam_host_hit *hits) {
    struct hosted *hosted = user;
    if (hosted->meanwhile) hosted->meanwhile();
    ANSWER(CAST, hits, meet(&rays[i], &hits[i]))
}

static void blocked(void *user, size_t many, const covbeam_host_ray *rays, uint8_t *answers) {
    struct hosted *hosted = user;
    for (size_t i = 0; i < many; i++) {
        covbeam_host_hit hit;
        memset(&hit, 0, sizeof hit);
        meet(&rays[i], &hit);
        answers[i] = hit.distance > 0;
        const uint64_t asked = count(&hosted->asked[BLOCKED]);
        if (hosted->lies == 0 || mixed(hosted->seed + asked) % hosted->lies != 0) continue;
        count(&hosted->told[BLOCKED]);
        answers[i] ^= (uint8_t)(1 + asked % 255);
    }
}

/* A checkerboard of weights. */
static void texture(const covbeam_host_hit *hit, covbeam_material *lobes) {
    const float scale = fmodf(fabsf(8 * hit->position[0]), 1) < 0.5f ? 1 : 0.25f;
    for (int i = 0; i < 3; i++) lobes->diffuse[i] *= scale;
}

static void lobes(void *user, size_t many, const covbeam_host_hit *hits, covbeam_material *all) {
    ANSWER(LOBES, all, texture(&hits[i], &all[i]))
}

/* A mirror under dust. */
static void send(const covbeam_host_meeting *meeting, covbeam_host_ways *ways) {
    const float *n = meeting->hit.normal, *d = meeting->direction;
    const float cosine = n[0] * d[0] + n[1] * d[1] + n[2] * d[2];
    for (int i = 0; i < 3; i++) {
        ways->diffuse[i] = 0.3f;
        ways->reflected[0].factor[i] = 0.4f;
        ways->reflected[1].factor[i] = 0.1f;
    }
    float mirrored[3];
    for (int i = 0; i < 3; i++) mirrored[i] = d[i] - 2 * cosine * n[i];
    set_direction(ways->reflected[0].direction, mirrored[0], mirrored[1], mirrored[2]);
    set_direction(ways->reflected[1].direction, mirrored[0] + 0.2 * (meeting->xi[0] - 0.5),
                  mirrored[1] + 0.2 * (meeting->xi[1] - 0.5), mirrored[2]);
    ways->reflected[1].deviation = 0.1f;
}

static void scatter(void *user, size_t many, const covbeam_host_meeting *meetings, covbeam_host_ways *all) {
    ANSWER(SCATTER, all, send(&meetings[i], &all[i]))
}

/* A point that shines alike all around. */
static void shine(const covbeam_host_draw *draw, covbeam_host_photon *photon) {
    const double pi = 3.14159265358979, z = 1 - 2 * (double)draw->place[1], around = 2 * pi * (double)draw->place[0];
    const double across = sqrt(fmax(0, 1 - z * z));
    set_direction(photon->direction, across * cos(around), across * sin(around), z);
    photon->origin[1] = (float)lamp_height;
    for (int i = 0; i < 3; i++) photon->power[i] = (float)(4 * pi * lamp_intensity);
}

static void emit(void *user, size_t many, const covbeam_host_draw *draws, covbeam_host_photon *photons) {
    ANSWER(EMIT, photons, shine(&draws[i], &photons[i]))
}

static void arrive(const covbeam_host_question *question, covbeam_host_arrival *arrival) {
    const float *p = question->place, above = p[1] - (float)lamp_height;
    const float squared = p[0] * p[0] + above * above + p[2] * p[2];
    for (int i = 0; i < 3; i++) arrival->density[i] = (float)lamp_intensity / fmaxf(squared, 1e-6f);
    arrival->from[0] = arrival->from[2] = 0;
    arrival->from[1] = (float)lamp_height;
}

static void illuminate(void *user, size_t many, const covbeam_host_question *questions, covbeam_host_arrival *arrivals) {
    ANSWER(ILLUMINATE, arrivals, arrive(&questions[i], &arrivals[i]))
}

static void look(const covbeam_host_pixel *pixel, covbeam_host_eye_ray *ray) {
    const double side = HOSTED_WIDTH;
    ray->origin[0] = ray->origin[1] = 0;
    ray->origin[2] = -2;
    set_direction(ray->direction, 0.5 - (double)pixel->place[0] / side, 0.5 - (double)pixel->place[1] / side, 1);
}

static void eye(void *user, size_t many, const covbeam_host_pixel *pixels, covbeam_host_eye_ray *rays) {
    ANSWER(EYE, rays, look(&pixels[i], &rays[i]))
}

covbeam_host hosted_host(struct hosted *hosted, bool has_blocked) {
    const float side = (float)floor_radius;
    covbeam_host host = { sizeof host, 1,    hosted, cast, has_blocked ? blocked : NULL, lobes, scatter, emit, illuminate, eye,
                          { -side, -1, -side }, { side, 1, side } };
    return host;
}

covbeam_description hosted_description(void) {
    static covbeam_material materials[3];
    static covbeam_object objects[2];
    static covbeam_volume fog;
    static covbeam_light lights[2];
    covbeam_description description;
    memset(&description, 0, sizeof description);
    memset(lights, 0, sizeof lights);
    for (int i = 0; i < 3; i++) {
        for (int m = 0; m < 3; m++) materials[m].diffuse[i] = 0.5f;
        materials[1].coat[i] = 1;
        fog.scattering[i] = 0.2;
        fog.absorption[i] = 0.02;
        lights[0].intensity[i] = lights[1].intensity[i] = lamp_intensity;
    }
    materials[1].asks = COVBEAM_ASKS_LOBES;
    materials[2].asks = COVBEAM_ASKS_WAYS;
    for (int i = 0; i < 2; i++) {
        objects[i].volume = -1;
        lights[i].position[1] = lamp_height;
    }
    objects[0].is_closed = 1;
    lights[0].is_own = 1;
    lights[1].position[0] = 1;
    description.struct_size = sizeof description;
    description.material_count = 3;
    description.materials = materials;
    description.object_count = 2;
    description.objects = objects;
    description.volume_count = 1;
    description.volumes = &fog;
    description.light_count = 2;
    description.lights = lights;
    description.camera.position[2] = -2;
    description.camera.forward[2] = description.camera.up[1] = 1;
    description.camera.half_height = 0.5;
    description.camera.width = description.camera.height = HOSTED_WIDTH;
    description.camera.is_own = 1;
    return description;
}

covbeam_session_settings hosted_settings(uint32_t method) {
    covbeam_session_settings settings;
    memset(&settings, 0, sizeof settings);
    settings.struct_size = sizeof settings;
    settings.method = method;
    settings.photons = 50;
    settings.grid = 4;
    settings.radius = 0.05;
    settings.threads = 2;
    return settings;
}
