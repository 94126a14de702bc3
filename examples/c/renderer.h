/* The renderer's own part: options, a glass ball around the origin, a lamp, a camera, pictures. No covbeam. */
#ifndef RENDERER_H
#define RENDERER_H

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

static const float RADIUS = 0.5f, INDEX = 1.5f;
static const float LAMP[3] = { 1.0f, 2.4f, 0.0f }; /* a point */
static const float EYE[3] = { 0.0f, 0.0f, -4.0f }; /* a pinhole that looks along +z; +y is up, +x on the left */
static const float TAN_HALF = 0.36397023f;         /* of 40 degrees from top to bottom */
enum { TILE = 8 };                                 /* pixels are seen in squares of so many across */

typedef struct {
    const char *out;
    uint32_t passes, photons, seed;
    int size, plain;
} options;

/* Ends the program where they make no sense. */
static inline options read_options(int count, char **arguments)
{
    options o = { .out = "glass_ball.pfm" };
    const char *const names[4] = { "--passes", "--photons", "--seed", "--size" };
    unsigned long numbers[4] = { 16, 5000, 1, 256 };
    int bad = 0;
    for (int i = 1; i < count; i++) {
        int option = 0;
        while (option < 4 && strcmp(arguments[i], names[option]))
            option++;
        if (option < 4 && i + 1 < count) {
            char *end = NULL;
            numbers[option] = strtoul(arguments[++i], &end, 10);
            bad |= end == arguments[i] || *end || numbers[option] < 1 || numbers[option] > 1000000;
        } else if (!strcmp(arguments[i], "--plain")) {
            o.plain = 1;
        } else {
            o.out = arguments[i];
            bad |= o.out[0] == '-';
        }
    }
    if (bad || numbers[3] % TILE || numbers[3] > 4096) {
        fprintf(stderr, "usage: glass_ball [OUT.pfm] [--passes N] [--photons N] [--seed N] [--size N] [--plain]\n"
                        "N is 1 to 1000000; --size: pixels across, a multiple of 8 up to 4096;\n"
                        "--plain: all kernels equally wide, as in progressive photon beams\n");
        exit(EXIT_FAILURE);
    }
    o.passes = (uint32_t)numbers[0];
    o.photons = (uint32_t)numbers[1];
    o.seed = (uint32_t)numbers[2];
    o.size = (int)numbers[3];
    return o;
}

/* Adds the seconds since the last call to a sum. */
static inline void lap(clock_t *last, double *sum)
{
    clock_t now = clock();
    *sum += (double)(now - *last) / (double)CLOCKS_PER_SEC;
    *last = now;
}

static inline float dot(const float *a, const float *b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* out = a + t b */
static inline void add(const float *a, float t, const float *b, float *out)
{
    for (int i = 0; i < 3; i++)
        out[i] = a[i] + t * b[i];
}

static inline void copy(const float *from, float *to)
{
    for (int i = 0; i < 3; i++)
        to[i] = from[i];
}

static inline void normalize(float *v)
{
    float length = sqrtf(dot(v, v));
    for (int i = 0; i < 3; i++)
        v[i] /= length;
}

/* Where a ray is. On the ball it must be told: the distance to the ball is rounding noise there. */
typedef enum { IN_FOG, LEAVING_BALL, IN_BALL } place;

/* The head of a photon's or an eye ray's path. */
typedef struct {
    float position[3], direction[3];
    float normal[3]; /* of the ball, outwards, if it starts there; else 0 */
    place place;
} path;

/* Distance to the ball, or infinity. */
static inline float distance_to_ball(const path *p)
{
    float aside[3], middle = -dot(p->position, p->direction);
    add(p->position, middle, p->direction, aside);
    float half = sqrtf(fmaxf(RADIUS * RADIUS - dot(aside, aside), 0.0f));
    if (p->place == IN_BALL)
        return middle + half;
    return p->place == IN_FOG && half > 0 && middle > half ? middle - half : INFINITY;
}

/* The ball's outward normal where a path meets it. */
static inline void ball_normal(const path *p, float distance, float *normal)
{
    add(p->position, distance, p->direction, normal);
    normalize(normal);
}

/* Moves a path to where it is scattered. */
static inline void enter_fog(path *p, float distance)
{
    add(p->position, distance, p->direction, p->position);
    memset(p->normal, 0, sizeof p->normal);
    p->place = IN_FOG;
}

/* Moves a path onto the ball. Returns the share of light that is reflected (Fresnel), eta = the index on this side
 * over that on the other one, and both ways on. */
static inline float meet_ball(path *p, float distance, float *eta, path *reflected, path *refracted)
{
    int inside = p->place == IN_BALL;
    ball_normal(p, distance, p->normal);
    for (int i = 0; i < 3; i++)
        p->position[i] = RADIUS * p->normal[i];
    *reflected = *refracted = *p;
    reflected->place = inside ? IN_BALL : LEAVING_BALL;
    refracted->place = inside ? LEAVING_BALL : IN_BALL;

    float n = *eta = inside ? INDEX : 1 / INDEX;
    float along = dot(p->normal, p->direction), cos_i = fabsf(along);
    float cos_t = sqrtf(fmaxf(1 - n * n * (1 - cos_i * cos_i), 0.0f));
    add(p->direction, -2 * along, p->normal, reflected->direction);
    float turn = inside ? cos_t - n * cos_i : n * cos_i - cos_t;
    for (int i = 0; i < 3; i++)
        refracted->direction[i] = n * p->direction[i] + turn * p->normal[i];
    normalize(reflected->direction);
    normalize(refracted->direction);
    float s = (n * cos_i - cos_t) / (n * cos_i + cos_t), t = (cos_i - n * cos_t) / (cos_i + n * cos_t);
    return 0.5f * (s * s + t * t);
}

/* Where a path in the fog passes the silhouette of the ball: returns the distance along it, and finds that from it
 * and the way there. 0 where it does not, or runs through the middle. */
static inline float silhouette(const path *p, float *distance, float *towards)
{
    float depth = -dot(p->position, p->direction);
    add(p->position, depth, p->direction, towards);
    *distance = fabsf(sqrtf(dot(towards, towards)) - RADIUS);
    return p->place == IN_FOG && dot(towards, towards) > 0 ? fmaxf(depth, 0.0f) : 0.0f;
}

/* A photon's path, evenly in all directions, from two numbers in [0, 1). */
static inline path leave_lamp(float u, float v)
{
    float z = 1 - 2 * u, r = sqrtf(fmaxf(1 - z * z, 0.0f)), phi = 6.2831853f * v;
    path p = { .direction = { r * cosf(phi), r * sinf(phi), z } };
    normalize(p.direction);
    copy(LAMP, p.position);
    return p;
}

/* A straight piece of an eye path through the fog, and how much of its light the pixel sees. */
typedef struct {
    path start;
    float length, weight;
    float *pixel;
} piece;

/* Kinds of pieces: up to the ball, reflected there, what leaves it again after 0, 1 and 2 reflections inside. */
enum { KINDS = 5 };

/* What a square of pixels sees, by its kind: pieces of a kind run side by side. */
typedef struct {
    piece pieces[KINDS][TILE * TILE];
    size_t count[KINDS];
} tile;

static inline void see(tile *t, int kind, const path *start, float length, float weight, float *pixel)
{
    t->pieces[kind][t->count[kind]++] = (piece){ *start, length, weight, pixel };
}

static inline void trace_eye(path p, float extinction, float *pixel, tile *t)
{
    path reflected, refracted;
    float eta, distance = distance_to_ball(&p), weight = expf(-extinction * distance);
    see(t, 0, &p, distance, 1, pixel);
    if (distance == INFINITY)
        return;
    float reflectance = meet_ball(&p, distance, &eta, &reflected, &refracted);
    see(t, 1, &reflected, INFINITY, weight * reflectance, pixel);
    weight *= 1 - reflectance;
    for (int kind = 2; kind < KINDS; kind++) {
        p = kind == 2 ? refracted : reflected;
        reflectance = meet_ball(&p, distance_to_ball(&p), &eta, &reflected, &refracted);
        see(t, kind, &refracted, INFINITY, weight * (1 - reflectance), pixel);
        weight *= reflectance;
    }
}

/* The eye paths of a tile, through fog of this extinction. */
static inline void trace_tile(int x0, int y0, int size, const float *jitter, float extinction, float (*picture)[3],
    tile *t)
{
    float scale = 2 * TAN_HALF / (float)size, middle = 0.5f * (float)size;
    memset(t->count, 0, sizeof t->count);
    for (int y = y0; y < y0 + TILE; y++)
        for (int x = x0; x < x0 + TILE; x++) {
            path p = { .direction = { (middle - (float)x - jitter[0]) * scale,
                           (middle - (float)y - jitter[1]) * scale, 1 } };
            normalize(p.direction);
            copy(EYE, p.position);
            trace_eye(p, extinction, picture[y * size + x], t);
        }
}

/* Ends the program for what the system has not done. */
static inline void end(const char *what)
{
    perror(what);
    exit(EXIT_FAILURE);
}

/* A black one. */
static inline float (*new_picture(int size))[3]
{
    float(*picture)[3] = calloc((size_t)size * (size_t)size, sizeof *picture);
    if (!picture)
        end("the picture");
    return picture;
}

/* A portable float map: rows from the bottom, in the byte order that the sign of its third line tells. */
static inline void write_pfm(const char *name, int size, float (*picture)[3], float scale)
{
    const uint16_t one = 1;
    FILE *file = fopen(name, "wb");
    if (!file)
        end(name);
    fprintf(file, "PF\n%d %d\n%s\n", size, size, *(const unsigned char *)&one ? "-1.0" : "1.0");
    for (int y = size - 1; y >= 0; y--)
        for (int x = 0; x < size; x++) {
            float pixel[3] = { 0 };
            add(pixel, scale, picture[y * size + x], pixel);
            fwrite(pixel, sizeof pixel, 1, file);
        }
    int failed = ferror(file);
    if (fclose(file) != 0 || failed)
        end(name);
}

#endif
