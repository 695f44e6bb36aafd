/* SPDX-License-Identifier: Apache-2.0 */

/* Runs the case that its argument names. Exits with 77 if it was skipped. */
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "check.h"

static int failures = 0;

void check_that(bool holds, const char* expected, const char* file, int line) {
  if (holds) return;
  ++failures;
  fprintf(stderr, "%s:%d: expected %s\n", file, line, expected);
}

void check_status(swiftgs_status status, swiftgs_status expected, const char* call, const char* file,
                  int line) {
  if (status == expected) return;
  ++failures;
  fprintf(stderr, "%s:%d: %s is %s, expected %s; last error: %s\n", file, line, call,
          swiftgs_status_name(status), swiftgs_status_name(expected), swiftgs_last_error());
}

void check_error(swiftgs_status status, swiftgs_status expected, const char* part, const char* file,
                 int line) {
  check_status(status, expected, part, file, line);
  const char* const text = swiftgs_last_error();
  if (status == SWIFTGS_OK || (strstr(text, part) && !strchr(text, '\n'))) return;
  ++failures;
  fprintf(stderr, "%s:%d: the error is '%s', expected one line with '%s'\n", file, line, text, part);
}

void skip(const char* reason) {
  printf("skipped: %s\n", reason);
  exit(failures == 0 ? 77 : 1);
}

void give_up(const char* reason) {
  fprintf(stderr, "%s: %s\n", reason, swiftgs_last_error());
  exit(1);
}

const char* const small_renderer = "serial/early/axis-shared-threshold-float-cholesky/ellipse";

swiftgs_scene* make_scene(void) {
  swiftgs_scene* scene = NULL;
  if (swiftgs_scene_builtin(small_count, &scene) != SWIFTGS_OK) give_up("a scene");
  return scene;
}

swiftgs_gaussians arrays_of(const swiftgs_scene* scene) {
  swiftgs_gaussians arrays = {.size = sizeof(arrays)};
  CHECK_OK(swiftgs_scene_get_arrays(scene, &arrays));
  return arrays;
}

swiftgs_camera make_camera(int32_t width, int32_t height) {
  swiftgs_camera camera = {.size = sizeof(camera)};
  if (swiftgs_camera_builtin(width, height, &camera) != SWIFTGS_OK) give_up("a camera");
  return camera;
}

swiftgs_renderer* make_renderer(const char* name) {
  swiftgs_renderer* renderer = NULL;
  if (swiftgs_renderer_create(name, NULL, &renderer) != SWIFTGS_OK) give_up(name);
  swiftgs_scene* const scene = make_scene();
  if (swiftgs_renderer_set_scene(renderer, scene) != SWIFTGS_OK) give_up("set_scene");
  swiftgs_scene_free(scene);
  return renderer;
}

swiftgs_view make_view(const swiftgs_camera* camera, float* colour) {
  swiftgs_view view = {.size = sizeof(view), .camera = camera};
  view.colour.data = colour;
  view.colour.pitch = (int64_t)(3 * sizeof(float)) * camera->width;
  return view;
}

swiftgs_frame make_frame(const swiftgs_view* views, uint64_t count) {
  const swiftgs_frame frame = {.size = sizeof(frame), .views = views, .count = count};
  return frame;
}

void* make_memory(size_t bytes) {
  static void* kept[64]; /* so that it counts as no leak */
  static atomic_size_t count;
  void* const memory = calloc(1, bytes);
  const size_t at = atomic_fetch_add(&count, 1);
  if (!memory || at == sizeof(kept) / sizeof(kept[0])) give_up("memory");
  return kept[at] = memory;
}

float* make_floats(size_t count) { return make_memory(sizeof(float) * count); }

void write_text(const char* path, const char* text) {
  FILE* const file = fopen(path, "wb");
  if (!file || fputs(text, file) < 0 || fclose(file) != 0) give_up(path);
}

void set_up(struct drawing* drawing, const char* renderer) {
  drawing->renderer = make_renderer(renderer);
  drawing->camera = make_camera(small_width, small_height);
  drawing->colour = make_floats(3 * small_width * small_height);
  drawing->view = make_view(&drawing->camera, drawing->colour);
  drawing->frame = make_frame(&drawing->view, 1);
}

bool draws(struct drawing* drawing, const float* expected) {
  const size_t count = 3 * small_width * small_height;
  memset(drawing->colour, 0, sizeof(float) * count);
  CHECK_OK(swiftgs_renderer_render(drawing->renderer, &drawing->frame));
  return same_floats(drawing->colour, expected, count);
}

float* draw_plain(swiftgs_renderer* renderer, const swiftgs_camera* camera) {
  float* const colour = make_floats(3 * (size_t)camera->width * (size_t)camera->height);
  const swiftgs_view view = make_view(camera, colour);
  const swiftgs_frame frame = make_frame(&view, 1);
  CHECK_OK(swiftgs_renderer_render(renderer, &frame));
  return colour;
}

bool same_floats(const float* a, const float* b, size_t count) {
  return memcmp(a, b, sizeof(float) * count) == 0;
}

struct test_case {
  const char* name;
  void (*run)(void);
};

static const struct test_case cases[] = {
#define CASE(name, sentence) {#name, test_##name},
#include "cases.h"
};

int main(int argc, char** argv) {
  for (size_t i = 0; argc == 2 && i < sizeof(cases) / sizeof(cases[0]); ++i)
    if (strcmp(cases[i].name, argv[1]) == 0) {
      cases[i].run();
      return failures == 0 ? 0 : 1;
    }
  fprintf(stderr, "expected the name of a case\n");
  return 1;
}
