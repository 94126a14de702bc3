/*
 * The same bits however a host shares its work out: beams added in other batches, photons in shares that 1, 2 or 8 threads deposit
 * and that are merged in their order, eye rays gathered by 1, 2 or 8 threads.
 *
 *     determinism
 */
#include <covbeam.h>

#include <inttypes.h>
#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { SHARES = 16, PHOTONS = 400, BEAMS = 6000, TILES = 32, TILE = 64, RAYS = TILES * TILE, CELLS = 24, VOXELS = 12 };

static const float CEILING = 0.2f;
static covbeam_segment segments[SHARES][PHOTONS];
static covbeam_beam beams[BEAMS];
static covbeam_eye_ray rays[RAYS];
static covbeam_medium medium;

static void must(covbeam_status status)
{
    if (status != COVBEAM_OK) {
        fprintf(stderr, "%s: %s\n", covbeam_status_name(status), covbeam_last_error());
        exit(1);
    }
}

static uint64_t fnv(const void *memory, size_t size)
{
    const unsigned char *bytes = memory;
    uint64_t hash = UINT64_C(0xcbf29ce484222325);
    size_t i;
    for (i = 0; i < size; i++)
        hash = (hash ^ bytes[i]) * UINT64_C(0x100000001b3);
    return hash;
}

/* In [0, 1): xorshift64* by Vigna. */
static float uniform(uint64_t *state)
{
    *state ^= *state >> 12;
    *state ^= *state << 25;
    *state ^= *state >> 27;
    return (float)((*state * UINT64_C(0x2545f4914f6cdd1d)) >> 40) / 16777216.0f;
}

static void direction(uint64_t *state, float *out)
{
    float length;
    do {
        int i;
        for (i = 0; i < 3; i++)
            out[i] = 2.0f * uniform(state) - 1.0f;
        length = sqrtf(out[0] * out[0] + out[1] * out[1] + out[2] * out[2]);
    } while (length > 1.0f || length < 0.1f);
    out[0] /= length;
    out[1] /= length;
    out[2] /= length;
}

static void point(uint64_t *state, float *out)
{
    int i;
    for (i = 0; i < 3; i++)
        out[i] = 2.0f * uniform(state) - 1.0f;
}

static void make(uint64_t *state)
{
    int i, j;
    memset(segments, 0, sizeof segments);
    for (i = 0; i < SHARES; i++)
        for (j = 0; j < PHOTONS; j++) {
            covbeam_segment *segment = &segments[i][j];
            float towards[3];
            point(state, segment->origin);
            direction(state, towards);
            segment->length = 1.5f * uniform(state) + 0.01f;
            segment->power = uniform(state) + 0.01f;
            segment->unscattered = j % 2 == 0;
            must(covbeam_light_field_point(towards, 0.1f, &segment->field));
            must(covbeam_light_field_travel(&segment->field, 0.1f + uniform(state)));
        }
    memset(beams, 0, sizeof beams);
    for (i = 0; i < BEAMS; i++) {
        point(state, beams[i].origin);
        direction(state, beams[i].direction);
        beams[i].length = uniform(state);
        for (j = 0; j < 3; j++)
            beams[i].power[j] = uniform(state);
    }
    for (i = 0; i < RAYS; i++) {
        point(state, rays[i].origin);
        direction(state, rays[i].direction);
        rays[i].length = 2.0f * uniform(state);
    }
}

/* Each thread takes what is next, so that who does what differs from run to run. */
struct work {
    pthread_mutex_t lock;
    int next, count;
    void (*run)(struct work *, int index, covbeam_scratch *);
    covbeam_grid *shares[SHARES];
    const covbeam_beam_map *map;
    const covbeam_grid *grid;
    const covbeam_kernel *kernel;
    covbeam_gathered *gathered;
};

static void *worker(void *argument)
{
    struct work *work = argument;
    covbeam_scratch *scratch;
    must(covbeam_scratch_new(&scratch));
    for (;;) {
        int index;
        pthread_mutex_lock(&work->lock);
        index = work->next++;
        pthread_mutex_unlock(&work->lock);
        if (index >= work->count)
            break;
        work->run(work, index, scratch);
    }
    covbeam_scratch_free(scratch);
    return NULL;
}

static void share_out(struct work *work, int count, int threads)
{
    pthread_t all[8];
    int i;
    work->next = 0;
    work->count = count;
    pthread_mutex_init(&work->lock, NULL);
    for (i = 0; i < threads; i++)
        if (pthread_create(&all[i], NULL, worker, work) != 0) {
            fprintf(stderr, "no thread\n");
            exit(1);
        }
    for (i = 0; i < threads; i++)
        pthread_join(all[i], NULL);
    pthread_mutex_destroy(&work->lock);
}

static void deposit(struct work *work, int index, covbeam_scratch *scratch)
{
    (void)scratch;
    must(covbeam_grid_deposit(work->shares[index], &medium, PHOTONS, segments[index], sizeof segments[0][0], NULL, NULL));
}

static void gather(struct work *work, int index, covbeam_scratch *scratch)
{
    int first = index * TILE;
    must(covbeam_beam_map_gather(work->map, work->kernel, work->grid, TILE, &rays[first], sizeof *rays,
                                 &work->gathered[first], sizeof *work->gathered, scratch, NULL, NULL));
}

static covbeam_grid *new_grid(void)
{
    static const covbeam_grid_layout layout = { { -1, -1, -1 }, { 1, 1, 1 }, { CELLS, CELLS, CELLS } };
    covbeam_grid *grid;
    must(covbeam_grid_new(&layout, &grid));
    return grid;
}

/* The grid after deposits by so many threads. */
static covbeam_grid *deposited(int threads)
{
    struct work work;
    covbeam_grid *sum = new_grid();
    const covbeam_grid *others[SHARES];
    int i;
    memset(&work, 0, sizeof work);
    work.run = deposit;
    for (i = 0; i < SHARES; i++)
        others[i] = work.shares[i] = new_grid();
    share_out(&work, SHARES, threads);
    must(covbeam_grid_merge(sum, others, SHARES));
    for (i = 0; i < SHARES; i++)
        covbeam_grid_free(work.shares[i]);
    must(covbeam_grid_resolve(sum));
    return sum;
}

static uint64_t hash_of_grid(covbeam_grid *grid)
{
    size_t size;
    void *bytes;
    uint64_t hash;
    must(covbeam_grid_get_saved_size(grid, &size));
    bytes = malloc(size);
    if (bytes == NULL)
        exit(1);
    must(covbeam_grid_save(grid, bytes, size));
    hash = fnv(bytes, size);
    free(bytes);
    return hash;
}

/* The map with its beams added so many at a time; 0: in batches of 1, 2, 3 and so on. */
static covbeam_beam_map *added(int batch)
{
    covbeam_beam_map *map;
    int first, count = batch > 0 ? batch : 1;
    must(covbeam_beam_map_new(&medium, &map));
    for (first = 0; first < BEAMS; first += count, count += batch == 0) {
        if (count > BEAMS - first)
            count = BEAMS - first;
        must(covbeam_beam_map_add(map, (size_t)count, &beams[first], sizeof *beams));
    }
    must(covbeam_beam_map_commit(map, CEILING, NULL, NULL));
    return map;
}

static uint64_t hash_of_gather(const covbeam_beam_map *map, const covbeam_grid *grid, int threads, uint64_t *pairs)
{
    static covbeam_gathered gathered[RAYS];
    covbeam_kernel kernel = { sizeof kernel, COVBEAM_KERNEL_BIWEIGHT, 0.02f, 0.0f, 0.05f };
    struct work work;
    int i;
    kernel.max_radius = CEILING;
    memset(gathered, 0, sizeof gathered);
    memset(&work, 0, sizeof work);
    work.run = gather;
    work.map = map;
    work.grid = grid;
    work.kernel = &kernel;
    work.gathered = gathered;
    share_out(&work, TILES, threads);
    for (*pairs = 0, i = 0; i < RAYS; i++)
        *pairs += gathered[i].pairs;
    return fnv(gathered, sizeof gathered);
}

static void same(uint64_t hash, uint64_t expected, const char *what, int number)
{
    if (hash != expected) {
        fprintf(stderr, "%s %d: %016" PRIx64 " instead of %016" PRIx64 "\n", what, number, hash, expected);
        exit(1);
    }
}

static void all_ways(const char *name)
{
    static const int threads[] = { 1, 2, 8 }, batches[] = { BEAMS, 1, 77, 4096, 0 };
    covbeam_grid *grid = deposited(1);
    covbeam_beam_map *map = added(BEAMS);
    uint64_t pairs, grid_hash = hash_of_grid(grid), hash = hash_of_gather(map, grid, 1, &pairs);
    size_t i, again;
    for (again = 0; again < 2; again++)
        for (i = 0; i < sizeof threads / sizeof *threads; i++) {
            covbeam_grid *other = deposited(threads[i]);
            same(hash_of_grid(other), grid_hash, "deposits by threads:", threads[i]);
            same(hash_of_gather(map, other, threads[i], &pairs), hash, "gather by threads:", threads[i]);
            covbeam_grid_free(other);
        }
    for (i = 0; i < sizeof batches / sizeof *batches; i++) {
        covbeam_beam_map *other = added(batches[i]);
        same(hash_of_gather(other, grid, 2, &pairs), hash, "beams in batches of", batches[i]);
        covbeam_beam_map_free(other);
    }
    covbeam_beam_map_free(map);
    covbeam_grid_free(grid);
    if (pairs < RAYS) {
        fprintf(stderr, "%s: only %lu pairs\n", name, (unsigned long)pairs);
        exit(1);
    }
    printf("%s: %lu pairs, grid %016" PRIx64 ", gathered %016" PRIx64 " in all ways\n", name, (unsigned long)pairs,
           grid_hash, hash);
}

int main(void)
{
    static const covbeam_grid_layout layout = { { -1, -1, -1 }, { 1, 1, 1 }, { VOXELS, VOXELS, VOXELS } };
    static float values[VOXELS * VOXELS * VOXELS];
    uint64_t state = 1;
    covbeam_density *density;
    size_t i;
    make(&state);
    for (i = 0; i < sizeof values / sizeof *values; i++)
        values[i] = uniform(&state);
    must(covbeam_density_new(&layout, values, sizeof *values, sizeof values / sizeof *values, &density));
    memset(&medium, 0, sizeof medium);
    medium.struct_size = sizeof medium;
    for (i = 0; i < 3; i++) {
        medium.scattering[i] = 0.5f + 0.1f * (float)i;
        medium.absorption[i] = 0.1f;
    }
    medium.phase.kind = COVBEAM_PHASE_HENYEY_GREENSTEIN;
    medium.phase.asymmetry = 0.6f;
    all_ways("homogeneous");
    medium.density = COVBEAM_DENSITY_VOXELS;
    medium.voxels = density;
    all_ways("voxels");
    covbeam_density_free(density);
    printf("1, 2 and 8 threads, 5 ways to add %d beams: the same bits\n", BEAMS);
    return 0;
}
