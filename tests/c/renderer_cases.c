/* SPDX-License-Identifier: Apache-2.0 */

/* Renderers: the table, scenes, recorded frames, measurements, memory. */
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "check.h"

enum { floats = 3 * small_width * small_height };

void test_table(void) {
  size_t count = 0;
  CHECK_OK(swiftgs_renderers_count(&count));
  swiftgs_renderer_entry entry = {.size = sizeof(entry)};
  bool cpu = false;
  for (size_t i = 0; i < count; ++i) {
    CHECK_OK(swiftgs_renderers_get(i, &entry));
    cpu |= strncmp(entry.name, "cpu/", 4) == 0 && entry.usable == 1;
    swiftgs_renderer* renderer = NULL;
    if (entry.usable) continue;
    CHECK_ERROR(swiftgs_renderer_create(entry.name, NULL, &renderer), SWIFTGS_UNAVAILABLE, entry.name);
    CHECK(renderer == NULL);
  }
  CHECK_INVALID(swiftgs_renderers_get(count, &entry), "renderers: number");
  CHECK_INVALID(swiftgs_renderers_get(0, NULL), "swiftgs_renderer_entry is NULL");
  CHECK_INVALID(swiftgs_renderers_count(NULL), "count is NULL");

  /* By backend, or the best. */
  CHECK_OK(swiftgs_renderers_find("serial", &entry));
  CHECK(strncmp(entry.name, "serial/early/", 13) == 0 && entry.usable == 1 && entry.on_device == 0);
  CHECK_OK(swiftgs_renderers_find(NULL, &entry));
  CHECK(entry.usable == 1 && (!cpu || strncmp(entry.name, "serial/", 7) != 0));
  CHECK_INVALID(swiftgs_renderers_find("nothing", &entry),
                "renderer 'nothing' is not known; expected a BACKEND");
  CHECK_INVALID(swiftgs_renderers_find(NULL, NULL), "swiftgs_renderer_entry is NULL");

  /* Options of a backend. The device's name has the number of threads. */
  if (!cpu) return;
  const swiftgs_renderer_options one = {.size = sizeof(one), .threads = 1};
  swiftgs_renderer* renderer = NULL;
  CHECK_OK(swiftgs_renderer_create("cpu/early/per-pixel/ellipse", &one, &renderer));
  const char *name = NULL, *device = NULL;
  CHECK_OK(swiftgs_renderer_name(renderer, &name));
  CHECK_OK(swiftgs_renderer_device_name(renderer, &device));
  CHECK(name && strcmp(name, "cpu/early/per-pixel/ellipse") == 0);
  CHECK(device && strstr(device, "1 thread") != NULL);
  swiftgs_renderer_free(renderer);
  const swiftgs_renderer_options negative = {.size = sizeof(negative), .threads = -1};
  CHECK_INVALID(swiftgs_renderer_create("cpu/early/per-pixel/ellipse", &negative, &renderer),
                "threads is -1, expected 1 or more, or 0 for all");
  CHECK_INVALID(swiftgs_renderer_create("serial/early/per-pixel/ellipse", &negative, &renderer),
                "threads is -1");
}

void test_recorded(void) {
  struct drawing d;
  set_up(&d, small_renderer);
  swiftgs_renderer* const renderer = d.renderer;
  float* const recorded = make_floats(floats);
  swiftgs_report report = {0};
  CHECK_OK(swiftgs_renderer_reserve(renderer, &d.frame, NULL));
  CHECK_INVALID(swiftgs_renderer_record(renderer, NULL), "memory for the report");
  CHECK_INVALID(swiftgs_renderer_record(NULL, &report), "renderer is NULL");

  /* Another camera and other memory. */
  d.camera.translation[0] += 0.1;
  CHECK_OK(swiftgs_renderer_render_into(renderer, &d.frame));
  d.view.colour.data = recorded;
  CHECK_OK(swiftgs_renderer_set_views(renderer, &d.frame));
  CHECK_OK(swiftgs_renderer_record(renderer, &report));
  CHECK_OK(swiftgs_renderer_wait(renderer));
  CHECK(report.visible > 0 && report.intersections >= report.visible && report.overflowed == 0);
  CHECK(same_floats(d.colour, recorded, floats));

  swiftgs_capacity capacity = {.size = sizeof(capacity), .splats = 1, .intersections = 1};
  CHECK_OK(swiftgs_renderer_reserve(renderer, &d.frame, &capacity));
  swiftgs_report overflowed = {0};
  CHECK_OK(swiftgs_renderer_record(renderer, &overflowed));
  CHECK(overflowed.overflowed == 1 && overflowed.visible == report.visible);
  capacity.reserved = 1;
  CHECK_INVALID(swiftgs_renderer_reserve(renderer, &d.frame, &capacity), "reserved is 1");
  CHECK_INVALID(swiftgs_renderer_wait(NULL), "renderer is NULL");
  swiftgs_renderer_free(renderer);
}

/* What it finds, same_bits_test compares with the C++ interface. */
void test_pick(void) {
  struct drawing d;
  set_up(&d, small_renderer);
  swiftgs_picked picked = {0};
  CHECK_ERROR(swiftgs_renderer_pick(d.renderer, 0, 0, 0, 1, 1, &picked), SWIFTGS_LOGIC_ERROR,
              "pick: expected a frame before");
  CHECK_OK(swiftgs_renderer_render(d.renderer, &d.frame));
  CHECK_INVALID(swiftgs_renderer_pick(d.renderer, 0, 0, INT32_MIN, 1, 1, &picked), "along y");
  CHECK_INVALID(swiftgs_renderer_pick(NULL, 0, 0, 0, 1, 1, &picked), "renderer is NULL");
  CHECK_INVALID(swiftgs_renderer_pick(d.renderer, 0, 0, 0, 1, 1, NULL), "picked is NULL");
  swiftgs_renderer_free(d.renderer);
}

void test_measures(void) {
  struct drawing d;
  set_up(&d, small_renderer);
  swiftgs_renderer* const renderer = d.renderer;
  swiftgs_times times = {.size = sizeof(times)};
  swiftgs_statistics statistics = {.size = sizeof(statistics)};
  swiftgs_memory memory = {.size = sizeof(memory)};

  CHECK_OK(swiftgs_renderer_render_into(renderer, &d.frame));
  CHECK_OK(swiftgs_renderer_times(renderer, &times));
  CHECK(isnan(times.total));
  CHECK_OK(swiftgs_renderer_statistics(renderer, &statistics));
  CHECK(statistics.gaussians == small_count && statistics.visible > 0 && statistics.visible <= small_count);
  CHECK(statistics.intersections >= statistics.visible && statistics.contributing_pairs == 0);

  /* The left half is hidden by what is directly before the camera, the right one by nothing. */
  float* const occluder = make_floats(floats / 3);
  for (int i = 0; i < floats / 3; ++i) occluder[i] = i % small_width < small_width / 2 ? 0 : INFINITY;
  d.view.occluder = (swiftgs_plane){occluder, 4 * small_width};
  d.frame.measure = SWIFTGS_MEASURE_COUNTS | SWIFTGS_MEASURE_TIMES;
  CHECK_OK(swiftgs_renderer_render_into(renderer, &d.frame));
  CHECK_OK(swiftgs_renderer_times(renderer, &times));
  CHECK(times.project > 0 && times.sort > 0 && times.raster > 0 && times.total > times.raster);
  CHECK_OK(swiftgs_renderer_statistics(renderer, &statistics));
  CHECK(statistics.contributing_pairs > 0 && statistics.intersections_visited > 0 &&
        statistics.rows_visited > 0);
  CHECK(statistics.intersections_hidden > 0 && statistics.intersections_hidden < statistics.intersections);

  CHECK_OK(swiftgs_renderer_memory(renderer, &memory));
  CHECK(memory.project > 0 && memory.sort > 0 && memory.device_total == 0 && memory.device_in_use == 0);
  CHECK_OK(swiftgs_renderer_trim(renderer));
  CHECK_OK(swiftgs_renderer_memory(renderer, &memory));
  CHECK(memory.project == 0 && memory.sort == 0 && memory.raster == 0);

  CHECK_NULLS(swiftgs_renderer_times, renderer, "renderer", &times, "swiftgs_times");
  CHECK_NULLS(swiftgs_renderer_statistics, renderer, "renderer", &statistics, "swiftgs_statistics");
  CHECK_NULLS(swiftgs_renderer_memory, renderer, "renderer", &memory, "swiftgs_memory");
  CHECK_INVALID(swiftgs_renderer_trim(NULL), "renderer is NULL");
  swiftgs_renderer_free(renderer);
}

void test_sharing(void) {
  struct drawing d;
  set_up(&d, small_renderer);
  swiftgs_renderer *const first = d.renderer, *second = NULL;
  CHECK_OK(swiftgs_renderer_create("serial/standard/per-pixel/ellipse", NULL, &second));
  CHECK_ERROR(swiftgs_renderer_render_into(second, &d.frame), SWIFTGS_LOGIC_ERROR,
              "expected a scene before the first");
  CHECK_INVALID(swiftgs_renderer_share_scene(first, second),
                "'serial/standard/per-pixel/ellipse' has no scene or another backend");
  CHECK_OK(swiftgs_renderer_share_scene(second, first));
  swiftgs_renderer_free(first); /* the scene stays */
  CHECK_OK(swiftgs_renderer_render_into(second, &d.frame));
  swiftgs_statistics statistics = {.size = sizeof(statistics)};
  CHECK_OK(swiftgs_renderer_statistics(second, &statistics));
  CHECK(statistics.gaussians == small_count && statistics.visible > 0);

  CHECK_NULLS(swiftgs_renderer_share_scene, second, "renderer", second, "renderer");
  swiftgs_scene* const scene = make_scene();
  CHECK_NULLS(swiftgs_renderer_set_scene, second, "renderer", scene, "scene");
  swiftgs_scene_free(scene);
  swiftgs_renderer_free(second);
}

/* Arrays draw as the scene that has them, also in place of one. */
void test_gaussians(void) {
  struct drawing d;
  set_up(&d, small_renderer);
  swiftgs_renderer* const renderer = d.renderer;
  swiftgs_scene* const scene = make_scene();
  swiftgs_gaussians arrays = arrays_of(scene);
  const float* const expected = draw_plain(renderer, &d.camera);
  CHECK_OK(swiftgs_renderer_set_gaussians(renderer, &arrays));
  CHECK(draws(&d, expected));
  CHECK_OK(swiftgs_renderer_borrow_gaussians(renderer, &arrays));
  CHECK(draws(&d, expected));

  /* What is refused leaves the scene that was there. */
  CHECK_NULLS(swiftgs_renderer_set_gaussians, renderer, "renderer", &arrays, "swiftgs_gaussians");
  CHECK_NULLS(swiftgs_renderer_borrow_gaussians, renderer, "renderer", &arrays, "swiftgs_gaussians");
  const swiftgs_gaussians moved = {.size = sizeof(moved), .count = 1, .means = arrays.means};
  CHECK_INVALID(swiftgs_renderer_update_scene(renderer, 0, 0, &moved),
                "update: the scene's arrays are the caller's, expected a scene that was uploaded");
  arrays.means.stride = 4;
  CHECK_INVALID(swiftgs_renderer_set_gaussians(renderer, &arrays), "scene: means: stride is 4 bytes");
  CHECK(draws(&d, expected));
  swiftgs_scene_free(scene), swiftgs_renderer_free(renderer);
}

/* Memory of a caller, which may run out. */
struct pool {
  size_t in_use, most, limit;
};

static void* take(void* context, size_t bytes) {
  struct pool* const pool = context;
  if (pool->in_use + bytes > pool->limit) return NULL;
  pool->in_use += bytes;
  if (pool->in_use > pool->most) pool->most = pool->in_use;
  return aligned_alloc(64, (bytes + 63) / 64 * 64);
}

static void give(void* context, void* memory, size_t bytes) {
  ((struct pool*)context)->in_use -= bytes;
  free(memory);
}

void test_memory(void) {
  struct pool pool = {.limit = 100};
  swiftgs_renderer_options options = {
      .size = sizeof(options), .allocate = &take, .release = &give, .context = &pool};
  struct drawing d;
  set_up(&d, small_renderer);
  swiftgs_renderer* renderer = NULL;
  CHECK_OK(swiftgs_renderer_create(small_renderer, &options, &renderer));
  swiftgs_scene* const scene = make_scene();
  CHECK_OK(swiftgs_renderer_set_scene(renderer, scene));
  swiftgs_scene_free(scene), swiftgs_renderer_free(d.renderer);
  CHECK_ERROR(swiftgs_renderer_render_into(renderer, &d.frame), SWIFTGS_OUT_OF_MEMORY, "out of memory");
  pool.limit = SIZE_MAX;
  CHECK_OK(swiftgs_renderer_render_into(renderer, &d.frame));
  CHECK(pool.most > 0 && pool.in_use > 0);
  swiftgs_renderer_free(renderer);
  CHECK(pool.in_use == 0);

  renderer = NULL;
  options.release = NULL;
  CHECK_INVALID(swiftgs_renderer_create(small_renderer, &options, &renderer),
                "memory hook: no function to release");
  options.release = &give, options.allocate = NULL;
  CHECK_INVALID(swiftgs_renderer_create(small_renderer, &options, &renderer),
                "memory hook: no function to allocate");
  CHECK(renderer == NULL);
}

void test_renderer_errors(void) {
  swiftgs_renderer* renderer = NULL;
  CHECK_INVALID(swiftgs_renderer_create("serial/late/per-pixel/ellipse", NULL, &renderer),
                "renderer 'serial/late/per-pixel/ellipse' is not known; expected BACKEND/SORT/RASTER/BOUNDS");
  CHECK_INVALID(swiftgs_renderer_create(NULL, NULL, &renderer), "name is NULL");
  CHECK_INVALID(swiftgs_renderer_create(small_renderer, NULL, NULL), "renderer is NULL");
  const swiftgs_renderer_options forgotten = {.size = 0};
  CHECK_INVALID(swiftgs_renderer_create(small_renderer, &forgotten, &renderer),
                "swiftgs_renderer_options: size is 0");
  const swiftgs_renderer_options unknown = {.size = sizeof(unknown), .harmonics = 3};
  CHECK_INVALID(swiftgs_renderer_create(small_renderer, &unknown, &renderer),
                "swiftgs_renderer_options: harmonics is 3, expected 0 to 2");
  const swiftgs_renderer_options newer = {.size = sizeof(newer), .reserved = 1};
  CHECK_INVALID(swiftgs_renderer_create(small_renderer, &newer, &renderer),
                "swiftgs_renderer_options: reserved is 1, expected 0");
  CHECK(renderer == NULL);

  /* The choice reaches the scene: halves cannot be replaced. */
  const swiftgs_renderer_options half = {.size = sizeof(half), .harmonics = SWIFTGS_HARMONICS_HALF};
  CHECK_OK(swiftgs_renderer_create(small_renderer, &half, &renderer));
  swiftgs_scene* const scene = make_scene();
  swiftgs_gaussians arrays = arrays_of(scene);
  CHECK_OK(swiftgs_renderer_set_scene(renderer, scene));
  CHECK_INVALID(
      swiftgs_renderer_update_scene(renderer, 0, 0, &arrays),
      "update: the scene keeps sh_rest as halves, expected floats: upload it with "
      "HarmonicsKept::floats; renderers of C and Python take SWIFTGS_HARMONICS_FLOAT and harmonics");
  swiftgs_scene_free(scene), swiftgs_renderer_free(renderer);

  CHECK_OK(swiftgs_renderer_create(small_renderer, NULL, &renderer));
  const char* name = NULL;
  CHECK_NULLS(swiftgs_renderer_name, renderer, "renderer", &name, "name");
  CHECK_NULLS(swiftgs_renderer_device_name, renderer, "renderer", &name, "name");
  swiftgs_renderer_free(renderer), swiftgs_renderer_free(NULL);
}
