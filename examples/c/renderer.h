/* The renderer's own part: vectors, a glass ball around the origin, picture files. No covbeam. */
#ifndef RENDERER_H
#define RENDERER_H

#include <math.h>
#include <stdint.h>
#include <stdio.h>

static const float RADIUS = 0.5f, INDEX = 1.5f;

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

/* Moves a path onto the ball. Returns the share of light that is reflected (Fresnel), eta = the index on this side
 * over that on the other one, and both ways on. */
static inline float meet_ball(path *p, float distance, float *eta, path *reflected, path *refracted)
{
    int inside = p->place == IN_BALL;
    add(p->position, distance, p->direction, p->normal);
    normalize(p->normal);
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

/* A portable float map: rows from the bottom, in the byte order that the sign of its third line tells. */
static inline int write_pfm(const char *name, int size, float (*picture)[3], float scale)
{
    const uint16_t one = 1;
    FILE *file = fopen(name, "wb");
    if (!file)
        return 0;
    fprintf(file, "PF\n%d %d\n%s\n", size, size, *(const unsigned char *)&one ? "-1.0" : "1.0");
    for (int y = size - 1; y >= 0; y--)
        for (int x = 0; x < size; x++) {
            float pixel[3] = { 0 };
            add(pixel, scale, picture[y * size + x], pixel);
            fwrite(pixel, sizeof pixel, 1, file);
        }
    int failed = ferror(file);
    return fclose(file) == 0 && !failed;
}

#endif
