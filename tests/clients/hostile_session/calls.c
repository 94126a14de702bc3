#include "calls.h"
#include "../hosted.h"
#include "../hostile/types.h"
#include "spoil.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum kind { GEOMETRY, SCENE, SESSION, KINDS };
enum { EACH = OBJECTS / KINDS };

static struct slot {
    void *handle;
    bool is_stopped; /* a geometry of which the build was */
    size_t pixels;   /* of a scene or a session */
} pool[KINDS][EACH];

static struct hosted hosted;
static unsigned char *saved;
static size_t saved_size;

static void slot_free(enum kind kind, struct slot *slot) {
    int32_t status = COVBEAM_OK;
    if (kind == GEOMETRY) status = covbeam_geometry_free(slot->handle);
    if (kind == SCENE) status = covbeam_scene_free(slot->handle);
    if (kind == SESSION) status = covbeam_session_free(slot->handle);
    if (status != COVBEAM_OK) fail("an object that nobody uses is not freed", status);
    memset(slot, 0, sizeof *slot);
}

/* Gives a new object the place of another. */
static void place(enum kind kind, const void *given, size_t pixels) {
    struct slot *slot = &pool[kind][below(EACH)];
    for (int i = EACH - 1; i >= 0; i--)
        if (!pool[kind][i].handle) slot = &pool[kind][i];
    slot_free(kind, slot);
    memcpy(&slot->handle, given, sizeof slot->handle);
    slot->pixels = pixels;
}

/* An object, or what is none. */
static void *handle(enum kind kind, struct slot **slot) {
    struct slot *picked = &pool[kind][below(EACH)];
    for (int i = 0; i < EACH && !picked->handle; i++) picked = &pool[kind][i];
    *slot = picked;
    if (!is_turn(4)) {
        if (!picked->handle) must(COVBEAM_NULL_POINTER);
        return picked->handle;
    }
    void *other = pool[(kind + 1 + (uint32_t)variant % 2) % KINDS][below(EACH)].handle;
    if (variant < 2 && other) {
        must(COVBEAM_INVALID_HANDLE);
        return other;
    }
    if (variant == 3 && picked->handle) {
        must(COVBEAM_MISALIGNED);
        return (char *)picked->handle + 4;
    }
    must(COVBEAM_NULL_POINTER);
    return NULL;
}

static int32_t freed(enum kind kind, int32_t (*release)(void *)) {
    struct slot *slot;
    void *given = handle(kind, &slot);
    if (!given) {
        call.statuses = 0; /* NULL is fine */
        call.sure = false;
    }
    const int32_t status = release(given);
    if (given && status == COVBEAM_OK) slot->handle = NULL, slot_free(kind, slot);
    return status;
}

#define FREED(name, kind)                                                                 \
    static int32_t release_##name(void *given) { return covbeam_##name##_free(given); }   \
    static int32_t call_covbeam_##name##_free(void) { return freed(kind, release_##name); }
FREED(geometry, GEOMETRY)
FREED(scene, SCENE)
FREED(session, SESSION)

static int32_t call_covbeam_geometry_new(void) {
    covbeam_geometry **made = out(sizeof *made, false);
    const int32_t status = covbeam_geometry_new(made);
    if (status == COVBEAM_OK) place(GEOMETRY, made, 0);
    return status;
}

static int32_t call_covbeam_geometry_add_mesh(void) {
    static const float positions[4][3] = { { -0.4f, 0, -0.4f }, { 0.4f, 0, -0.4f }, { 0, 0, 0.4f }, { 0, 0.6f, 0 } };
    static const int32_t triangles[5][3] = { { 1, 1, 2 }, { 0, 1, 2 }, { 0, 3, 1 }, { 1, 3, 2 }, { 2, 3, 0 } };
    static const int32_t materials[5] = { 0, 1, 0, 2, 0 };
    float normals[5][3][3] = { { { 0 } } };
    for (int i = 0; i < 15; i++) normals[i / 3][i % 3][1] = 1;
    struct slot *slot;
    covbeam_geometry *geometry = handle(GEOMETRY, &slot);
    covbeam_mesh mesh;
    memset(&mesh, 0, sizeof mesh);
    mesh.struct_size = sizeof mesh;
    mesh.material_count = chance(2) ? 1 : 5;
    mesh.materials = STRUCTS(int32_t, materials, mesh.material_count);
    mesh.position_count = 4;
    mesh.positions = STRUCTS(float, positions, 12);
    mesh.triangle_count = 5;
    mesh.triangles = STRUCTS(int32_t, triangles, 15);
    mesh.normals = STRUCTS(float, normals, 45);
    if (chance(2)) mesh.normals = NULL, call.sure = false;
    may(COVBEAM_WRONG_ORDER);
    const covbeam_mesh *given = OPTIONS(covbeam_mesh, &mesh);
    return covbeam_geometry_add_mesh(geometry, given, out(sizeof(size_t), true));
}

static int32_t call_covbeam_geometry_add_instances(void) {
    struct slot *slot;
    covbeam_geometry *geometry = handle(GEOMETRY, &slot);
    const size_t count = below(3);
    covbeam_instance instances[2];
    memset(instances, 0, sizeof instances);
    for (int i = 0; i < 2; i++) {
        for (int axis = 0; axis < 4; axis++) instances[i].matrix[5 * axis] = 1;
        instances[i].matrix[3] = (double)uniform(-0.5f, 0.5f);
        instances[i].object = (int32_t)below(2);
        instances[i].material = (int32_t)below(3) - 1;
    }
    size_t says, stride;
    may(COVBEAM_WRONG_ORDER);
    may(COVBEAM_INVALID_VALUE); /* there is no mesh */
    const covbeam_instance *all = STRIDED(covbeam_instance, instances, sizeof *instances, 8, count, &says, &stride);
    return covbeam_geometry_add_instances(geometry, says, all, stride);
}

static int32_t call_covbeam_geometry_build(void) {
    struct slot *slot;
    covbeam_geometry *geometry = handle(GEOMETRY, &slot);
    const covbeam_poll poll = a_poll();
    may(COVBEAM_WRONG_ORDER);
    const int32_t status = covbeam_geometry_build(geometry, poll, &polls);
    if (status == COVBEAM_CANCELLED) slot_free(GEOMETRY, slot);
    return status;
}

static int32_t call_covbeam_geometry_get_info(void) {
    struct slot *slot;
    covbeam_geometry *geometry = handle(GEOMETRY, &slot);
    may(COVBEAM_WRONG_ORDER);
    return covbeam_geometry_get_info(geometry, out(sizeof(covbeam_geometry_info), false));
}

static int32_t call_covbeam_geometry_cast(void) {
    float origins[9] = { 0 }, directions[9] = { 0 };
    for (int i = 0; i < 3; i++) origins[3 * i + 2] = uniform(-3, 3), directions[3 * i + below(3)] = 1;
    struct slot *slot;
    covbeam_geometry *geometry = handle(GEOMETRY, &slot);
    const size_t count = below(4);
    size_t says[3], strides[3];
    const float *from = STRIDED(float, origins, 12, 4, count, &says[0], &strides[0]);
    const float *along = STRIDED(float, directions, 12, 4, count, &says[1], &strides[1]);
    covbeam_surface_hit *hits = strided(NULL, sizeof *hits, 4, count, &says[2], &strides[2], NULL, 0);
    size_t most = count;
    for (int i = 0; i < 3; i++) most = says[i] > most ? says[i] : most;
    may(COVBEAM_WRONG_ORDER);
    return covbeam_geometry_cast(geometry, most, from, strides[0], along, strides[1], hits, strides[2]);
}

/* A lamp of any kind, by its fields. */
static void lamp(covbeam_light *light, uint32_t kind) {
    static const float cells[18] = { 1, 1, 1, 0.5f, 1, 2, 0, 0, 0, 1, 0, 1, 2, 2, 2, 1, 1, 0 };
    static const float triangle[9] = { 0.5f, 1, 0, 1, 1, 0, 0.5f, 1, 0.5f };
    memset(light, 0, sizeof *light);
    light->kind = kind;
    light->is_visible = below(2);
    light->position[1] = 1.5;
    light->axis[1] = -1;
    light->u[0] = light->v[2] = 0.3;
    for (int i = 0; i < 3; i++) {
        light->intensity[i] = light->radiance[i] = light->irradiance[i] = 2;
        light->axes[i][i] = 1;
    }
    light->cosine = 0.5;
    light->reach = 3;
    if (kind == COVBEAM_LIGHT_SKY || (kind < COVBEAM_LIGHT_AREA && chance(3))) {
        light->rows = 2, light->columns = 3;
        light->cells = STRUCTS(float, cells, 18);
    }
    if (kind == COVBEAM_LIGHT_MESH) {
        light->triangle_count = 1;
        light->triangles = STRUCTS(float, triangle, 9);
    }
}

/* Everything that a description may hold, in small numbers. */
static const covbeam_description *described(size_t *pixels) {
    static const float densities[8] = { 1, 2, 0.5f, 1, 3, 1, 0, 1 };
    covbeam_description all = hosted_description();
    covbeam_shape shapes[3];
    covbeam_volume volumes[3];
    covbeam_light lights[2];
    memset(shapes, 0, sizeof shapes);
    memset(volumes, 0, sizeof volumes);
    for (int i = 0; i < 3; i++) {
        shapes[i].kind = (uint32_t)i;
        shapes[i].volume = -1;
        shapes[i].radius = 0.3f;
        shapes[i].b[0] = shapes[i].c[2] = 0.5f;
        volumes[i].scattering[i] = volumes[i].absorption[1] = 0.2;
        for (int axis = 0; axis < 3; axis++) {
            if (i == 1) shapes[i].b[axis] = 0.4f;
            volumes[i].min[axis] = volumes[i].density_min[axis] = -1;
            volumes[i].max[axis] = volumes[i].density_max[axis] = 1;
        }
    }
    shapes[2].material = 1; /* a rectangle has no inside that could be of glass */
    shapes[0].volume = chance(2) ? 1 : -1;
    covbeam_material materials[3];
    memcpy(materials, all.materials, sizeof materials);
    for (int i = 0; i < 3; i++) {
        materials[i].asks = COVBEAM_ASKS_NOTHING;
        materials[0].diffuse[i] = 0;
        materials[0].glass_reflection[i] = materials[0].glass_transmission[i] = 1;
    }
    for (int i = 0; i < 3; i++) volumes[2].density_cells[i] = 2;
    volumes[2].density = STRUCTS(float, densities, 8);
    lamp(&lights[0], below(6));
    lamp(&lights[1], below(6));
    covbeam_object objects[2] = { { 2, 1, 0, 0, 0 }, { -1, 0, 0, 0, 0 } };
    all.camera.is_own = 0;
    all.camera.projection = below(4);
    all.camera.widest = 1;
    if (chance(3)) all.camera.aperture = 0.1, all.camera.focus = 2, all.camera.ratio = 1;
    all.fog_alone = chance(6);
    all.world_volume = chance(6) ? -1 : 0;
    all.materials = STRUCTS(covbeam_material, materials, 3);
    all.objects = STRUCTS(covbeam_object, objects, 2);
    all.shape_count = all.volume_count = 3;
    all.light_count = 2;
    all.shapes = STRUCTS(covbeam_shape, shapes, 3);
    all.volumes = STRUCTS(covbeam_volume, volumes, 3);
    all.lights = STRUCTS(covbeam_light, lights, 2);
    const covbeam_description *given = OPTIONS(covbeam_description, &all);
    *pixels = HOSTED_PIXELS;
    return given;
}

static int32_t call_covbeam_scene_new(void) {
    struct slot *slot;
    size_t pixels;
    covbeam_geometry *geometry = handle(GEOMETRY, &slot);
    if (!geometry) call.statuses = 0, call.sure = false; /* shapes only */
    may(COVBEAM_WRONG_ORDER);
    const covbeam_description *description = described(&pixels);
    covbeam_scene **made = out(sizeof *made, false);
    const int32_t status = covbeam_scene_new(geometry, description, made);
    if (status == COVBEAM_OK) place(SCENE, made, pixels);
    return status;
}

static int32_t call_covbeam_scene_new_of_host(void) {
    hosted.lies = chance(2) ? 0 : 3;
    const covbeam_host host = hosted_host(&hosted, chance(2));
    const covbeam_description all = hosted_description();
    const covbeam_host *given = OPTIONS(covbeam_host, &host);
    const covbeam_description *description = OPTIONS(covbeam_description, &all);
    covbeam_scene **made = out(sizeof *made, false);
    const int32_t status = covbeam_scene_new_of_host(given, description, made);
    if (status == COVBEAM_OK) place(SCENE, made, HOSTED_PIXELS);
    return status;
}

/* Threads of the host's, which end with their sessions. */
struct work {
    void (*body)(void *argument);
    void *argument;
};

static void *work(void *given) {
    const struct work own = *(struct work *)given;
    free(given);
    own.body(own.argument);
    return NULL;
}

static uint32_t spawn_refuses;

static int32_t spawn(void *user, void (*body)(void *argument), void *argument) {
    if (user != &spawn_refuses || (spawn_refuses > 0 && --spawn_refuses == 0)) return -3;
    struct work *own = malloc(sizeof *own);
    pthread_t thread;
    if (!own) return -1;
    own->body = body;
    own->argument = argument;
    if (pthread_create(&thread, NULL, work, own) != 0) return free(own), -1;
    pthread_detach(thread);
    return 0;
}

static int32_t call_covbeam_session_new(void) {
    struct slot *slot;
    const covbeam_scene *scene = handle(SCENE, &slot);
    covbeam_session_settings settings = hosted_settings(1 + below(4));
    if (chance(4)) settings.method = COVBEAM_METHOD_COVBEAM;
    settings.threads = 1 + below(2);
    settings.kinds_apart = settings.method < COVBEAM_METHOD_PLAIN && chance(2);
    spawn_refuses = 0;
    if (is_turn(1)) {
        settings.spawn = spawn, settings.spawn_user = &spawn_refuses, spawn_refuses = settings.threads;
        must(COVBEAM_INVALID_VALUE);
    } else if (chance(2)) {
        settings.spawn = spawn, settings.spawn_user = &spawn_refuses;
    }
    const covbeam_scene *twice[2] = { scene, scene };
    size_t count = 1 + below(2), says, stride;
    const covbeam_scene *const *scenes = STRIDED(covbeam_scene, twice, sizeof *twice, 8, count, &says, &stride);
    if (count > 1 && is_turn(1)) {
        stride = 0, says = (size_t)1 << 40;
        must(COVBEAM_INVALID_ARRAY);
    }
    may(COVBEAM_INVALID_VALUE); /* light that single precision does not hold */
    const covbeam_session_settings *given = OPTIONS(covbeam_session_settings, &settings);
    const covbeam_poll poll = a_poll();
    covbeam_session **made = out(sizeof *made, false);
    const int32_t status = covbeam_session_new(says, scenes, stride, given, poll, &polls, made);
    if (status == COVBEAM_OK) {
        const covbeam_session *session;
        memcpy(&session, made, sizeof session);
        covbeam_session_info info;
        if (covbeam_session_get_info(session, &info) != COVBEAM_OK || info.passes != 0) fail("a new session", COVBEAM_OK);
        /* The pilot takes a second. */
        if (covbeam_session_restart(session, 50, 1) != COVBEAM_OK) fail("a new session", COVBEAM_OK);
        place(SESSION, made, (size_t)info.width * info.height);
    }
    return status;
}

static int32_t call_covbeam_session_pass(void) {
    struct slot *slot;
    const covbeam_session *session = handle(SESSION, &slot);
    const covbeam_poll poll = a_poll();
    may(COVBEAM_INVALID_VALUE);
    return covbeam_session_pass(session, poll, &polls);
}

static int32_t call_covbeam_session_until(void) {
    struct slot *slot;
    const covbeam_session *session = handle(SESSION, &slot);
    covbeam_goal goal = { sizeof goal, 1 + below(5), 0, 0 };
    if (chance(3)) goal.seconds = 0.01;
    if (chance(3)) goal.error = 0.5;
    const covbeam_goal *given = OPTIONS(covbeam_goal, &goal);
    const covbeam_poll poll = a_poll();
    uint32_t *end = out(sizeof *end, true);
    may(COVBEAM_INVALID_VALUE);
    const int32_t status = covbeam_session_until(session, given, poll, &polls, end);
    if (status == COVBEAM_OK && end && *end > COVBEAM_END_DARK) fail("an end that is none", status);
    return status;
}

static int32_t call_covbeam_session_restart(void) {
    static const uint32_t photons[] = { 0, 1, 50, 51, 0xffffffffu };
    struct slot *slot;
    const covbeam_session *session = handle(SESSION, &slot);
    /* Plain: the pilot takes a second. */
    return covbeam_session_restart(session, chance(2) ? 50 : photons[below(5)], 1 + below(2));
}

static int32_t call_covbeam_session_get_info(void) {
    struct slot *slot;
    const covbeam_session *session = handle(SESSION, &slot);
    return covbeam_session_get_info(session, out(sizeof(covbeam_session_info), false));
}

static int32_t call_covbeam_session_picture(void) {
    struct slot *slot;
    const covbeam_session *session = handle(SESSION, &slot);
    uint32_t layer = below(8);
    if (is_turn(2)) {
        layer = variant ? 8 : 0xffffffffu;
        must(COVBEAM_INVALID_VALUE);
    }
    const size_t parts = layer < COVBEAM_LAYER_ERROR ? 3 : 1;
    size_t says = slot->pixels, stride;
    const size_t pixels = slot->pixels;
    if (is_turn(3)) {
        const size_t wrong[] = { pixels - (pixels > 0), pixels + 1, SIZE_MAX };
        says = wrong[variant];
        must(COVBEAM_SHORT_BUFFER);
    }
    size_t counted;
    float *numbers = strided(NULL, 4 * parts, 4, pixels, &counted, &stride, NULL, 0);
    if (counted != pixels) says = counted;
    if (stride == 0) call.sure = false; /* side by side */
    const covbeam_poll poll = a_poll();
    may(COVBEAM_WRONG_ORDER);
    const int32_t status = covbeam_session_picture(session, layer, says, numbers, stride, poll, &polls);
    for (size_t i = 0; status == COVBEAM_OK && i < parts * pixels; i++)
        if (!(isfinite(numbers[i]) && numbers[i] >= 0)) fail("a picture holds what is no light", status);
    return status;
}

static int32_t call_covbeam_session_save(void) {
    struct slot *slot;
    const covbeam_session *session = handle(SESSION, &slot);
    size_t size = 0, *needed = out(sizeof *needed, false);
    void *bytes = NULL;
    /* Once without memory, to know how much. */
    if (!call.sure && !chance(4) && covbeam_session_save(session, NULL, 0, &size) == COVBEAM_OK) {
        if (is_turn(1)) {
            size--;
            must(COVBEAM_SHORT_BUFFER);
        }
        bytes = block(NULL, size, 0, true);
    }
    may(COVBEAM_WRONG_ORDER);
    const int32_t status = covbeam_session_save(session, bytes, size, needed);
    if (status == COVBEAM_OK && bytes) {
        if (*needed != size) fail("another size than before", status);
        free(saved);
        saved = malloc(size);
        if (!saved) abort();
        memcpy(saved, bytes, saved_size = size);
    }
    return status;
}

static uint32_t crc32(const unsigned char *bytes, size_t size) {
    uint32_t crc = 0xffffffffu;
    for (size_t i = 0; i < size; i++) {
        crc ^= bytes[i];
        for (int bit = 0; bit < 8; bit++) crc = crc >> 1 ^ (crc & 1 ? 0xedb88320u : 0);
    }
    return ~crc;
}

/* Another number in one of the records, of which each has its length and its sum before it: what only a look at the numbers can notice. */
static void forge(unsigned char *bytes, size_t size) {
    size_t first = 8, chosen = 8;
    uint32_t length = 0;
    for (uint32_t records = 1; first + 8 <= size; records++) {
        memcpy(&length, bytes + first, 4);
        if (chance(records)) chosen = first;
        first += 8 + (size_t)length;
    }
    memcpy(&length, bytes + chosen, 4);
    if (length < 4) return;
    static const uint32_t words[] = { 0, 1, 0x7fffffffu, 0x80000000u, 0xffffffffu, 0xfffffffeu, 0x7f800000u, 0x7fc00000u };
    const uint32_t word = chance(2) ? words[below(8)] : (uint32_t)draw();
    memcpy(bytes + chosen + 8 + below(length / 4) * 4, &word, 4);
    const uint32_t crc = crc32(bytes + chosen + 8, length);
    memcpy(bytes + chosen + 4, &crc, 4);
}

static int32_t call_covbeam_session_merge(void) {
    struct slot *slot;
    const covbeam_session *session = handle(SESSION, &slot);
    size_t size = saved_size;
    unsigned char *bytes = block(saved, size, 0, false), *given = bytes;
    may(COVBEAM_BAD_DATA); /* of another scene, or passes that are there */
    if (is_turn(24)) {
        switch (variant % 6) {
        case 0: size = below((uint32_t)size + 1); break;
        case 1: bytes[below((uint32_t)size)] ^= (unsigned char)(1 + below(255)); must(COVBEAM_BAD_DATA); break;
        case 2: given = NULL; if (size > 0) must(COVBEAM_NULL_POINTER); break;
        case 3: size = SIZE_MAX; must(COVBEAM_INVALID_ARRAY); break;
        default: forge(bytes, size);
        }
        spoiled();
    }
    const covbeam_poll poll = a_poll();
    return covbeam_session_merge(session, given, size, poll, &polls);
}

const struct session_call session_calls[] = {
#define CALLED(name) { #name, call_##name }
    CALLED(covbeam_geometry_new), CALLED(covbeam_geometry_add_mesh), CALLED(covbeam_geometry_add_instances),
    CALLED(covbeam_geometry_build), CALLED(covbeam_geometry_get_info), CALLED(covbeam_geometry_cast),
    CALLED(covbeam_scene_new), CALLED(covbeam_scene_new_of_host), CALLED(covbeam_session_new),
    CALLED(covbeam_session_pass), CALLED(covbeam_session_until), CALLED(covbeam_session_restart),
    CALLED(covbeam_session_get_info), CALLED(covbeam_session_picture), CALLED(covbeam_session_save),
    CALLED(covbeam_session_merge), CALLED(covbeam_session_free), CALLED(covbeam_scene_free), CALLED(covbeam_geometry_free),
#undef CALLED
};
const size_t session_call_count = sizeof session_calls / sizeof *session_calls;

static void must_work(const char *what, int32_t status) {
    if (status != COVBEAM_OK) fail(what, status);
}

/* A call of which nothing is spoiled. */
static int32_t made(int32_t (*function)(void)) {
    begin("furnish");
    const int32_t status = function();
    free_blocks(status);
    return status;
}

/* A geometry that is built and one that is not; a scene of each kind; two sessions of one picture, of other passes. */
void furnish(void) {
    faulty = -1;
    for (int i = 0; i < 2; i++) {
        must_work("a geometry", made(call_covbeam_geometry_new));
        made(call_covbeam_geometry_add_mesh);
        made(call_covbeam_geometry_add_instances);
        if (i > 0) continue;
        must_work("a build", covbeam_geometry_build(pool[GEOMETRY][0].handle, NULL, NULL));
        must_work("a scene", made(call_covbeam_scene_new));
    }
    must_work("a host's scene", made(call_covbeam_scene_new_of_host));
    covbeam_session_settings settings = hosted_settings(below(4));
    for (int i = 0; i < 2; i++) {
        covbeam_session *session;
        settings.first_pass = 100 * (uint32_t)i;
        must_work("a session", covbeam_session_new(1, (const covbeam_scene *const *)&pool[SCENE][1].handle, 0, &settings, NULL, NULL, &session));
        must_work("a session", covbeam_session_restart(session, 50, 1));
        if (i == 0) {
            must_work("a pass", covbeam_session_pass(session, NULL, NULL));
            must_work("its sums", covbeam_session_save(session, NULL, 0, &saved_size));
            saved = malloc(saved_size);
            if (!saved) abort();
            must_work("its sums", covbeam_session_save(session, saved, saved_size, &saved_size));
        }
        place(SESSION, &session, HOSTED_PIXELS);
    }
}

void unfurnish(void) {
    for (enum kind kind = GEOMETRY; kind < KINDS; kind++)
        for (int i = 0; i < EACH; i++) slot_free(kind, &pool[kind][i]);
    free(saved);
    saved = NULL;
    saved_size = 0;
}

static uint64_t hash(uint64_t state, const void *bytes, size_t size) {
    const unsigned char *byte = bytes;
    for (size_t i = 0; i < size; i++) state = (state ^ byte[i]) * 0x100000001b3u;
    return state;
}

static uint64_t geometry_digest(const covbeam_geometry *geometry) {
    static const float origin[3] = { 0.1f, 0.2f, -3 }, direction[3] = { 0, 0, 1 };
    covbeam_geometry_info info;
    covbeam_surface_hit hit;
    memset(&info, 0, sizeof info);
    memset(&hit, 0, sizeof hit);
    int32_t status = covbeam_geometry_get_info(geometry, &info);
    status |= covbeam_geometry_cast(geometry, 1, origin, 0, direction, 0, &hit, 0);
    return hash(hash(hash(1, &status, sizeof status), &info, sizeof info), &hit, sizeof hit);
}

static uint64_t session_digest(const covbeam_session *session) {
    covbeam_session_info info;
    size_t size = 0;
    must_work("what may always be asked", covbeam_session_get_info(session, &info));
    const uint32_t numbers[] = { info.passes, info.photons, info.most_photons, info.width, info.height };
    const uint64_t state = hash(hash(1, numbers, sizeof numbers), &info.pairs, sizeof info.pairs);
    if (info.passes == 0) return state;
    must_work("sums of passes", covbeam_session_save(session, NULL, 0, &size));
    unsigned char *bytes = malloc(size);
    if (!bytes) abort();
    must_work("sums of passes", covbeam_session_save(session, bytes, size, &size));
    const uint64_t whole = hash(state, bytes, size);
    free(bytes);
    return whole;
}

uint64_t digest(int object) {
    const enum kind kind = (enum kind)(object / EACH);
    const void *given = pool[kind][object % EACH].handle;
    if (!given) return 0;
    return kind == GEOMETRY ? geometry_digest(given) : kind == SESSION ? session_digest(given) : 1;
}
