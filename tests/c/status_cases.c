/* SPDX-License-Identifier: Apache-2.0 */

/* Versions, errors, threads, and structs of programs of another age. */
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "check.h"

void test_versions(void) {
  unsigned major = 0, minor = 0, patch = 0;
  CHECK(sscanf(swiftgs_version(), "%u.%u.%u", &major, &minor, &patch) == 3);
  CHECK(swiftgs_abi_version() == (uint32_t)SWIFTGS_ABI_MAJOR * 65536u + SWIFTGS_ABI_MINOR);

  CHECK(strcmp(swiftgs_last_error(), "") == 0);
  const char* name =
      "OK INVALID_ARGUMENT FORMAT_ERROR CANCELLED SYSTEM_ERROR DEVICE_ERROR CAPACITY_ERROR LOGIC_ERROR "
      "OUT_OF_MEMORY UNAVAILABLE INTERNAL_ERROR ";
  for (swiftgs_status status = SWIFTGS_OK; status <= SWIFTGS_INTERNAL_ERROR; ++status) {
    const size_t length = strcspn(name, " ");
    char expected[64] = "SWIFTGS_";
    CHECK(strcmp(swiftgs_status_name(status), strncat(expected, name, length)) == 0);
    name += length + 1;
  }
  CHECK(strcmp(swiftgs_status_name(-1), "unknown status") == 0);
  CHECK(strcmp(swiftgs_status_name(SWIFTGS_INTERNAL_ERROR + 1), "unknown status") == 0);
}

/* A camera of a program that is newer than the library. */
struct newer_camera {
  swiftgs_camera camera;
  uint64_t later;
};

void test_structs(void) {
  struct newer_camera newer;
  memset(&newer, 0xff, sizeof(newer));
  newer.camera.size = sizeof(newer);
  CHECK_OK(swiftgs_camera_builtin(64, 48, &newer.camera));
  CHECK(newer.camera.size == sizeof(newer));
  CHECK(newer.later == 0);
  CHECK(newer.camera.width == 64 && newer.camera.lens == SWIFTGS_LENS_PERSPECTIVE);

  /* It may leave what it has more at zero. */
  CHECK_OK(swiftgs_camera_scale(&newer.camera, 2));
  CHECK(newer.camera.width == 128 && newer.camera.size == sizeof(newer));
  newer.later = (uint64_t)1 << 32;
  CHECK_INVALID(swiftgs_camera_scale(&newer.camera, 2),
                "swiftgs_camera: byte 236 is 1, expected 0: the program is newer than the library");
  CHECK(newer.camera.width == 128);

  /* A size that was forgotten, or of another struct. */
  swiftgs_camera camera = make_camera(64, 48);
  camera.size = 0;
  CHECK_INVALID(swiftgs_camera_scale(&camera, 2),
                "swiftgs_camera: size is 0, expected 232, the struct's size");
  camera.size = 136;
  CHECK_INVALID(swiftgs_camera_builtin(64, 48, &camera), "size is 136, expected 232");
  CHECK_INVALID(swiftgs_camera_builtin(64, 48, NULL), "swiftgs_camera is NULL");

  /* A program that is older than lenses has pinholes, and is refused what it could not tell from one. */
  union {
    swiftgs_camera camera;
    unsigned char bytes[sizeof(swiftgs_camera)];
  } older;
  memset(&older, 0xff, sizeof(older));
  older.camera.size = 144;
  CHECK_OK(swiftgs_camera_builtin(64, 48, &older.camera));
  CHECK_OK(swiftgs_camera_scale(&older.camera, 2));
  CHECK(older.camera.width == 128 && older.camera.size == 144);
  for (size_t i = 144; i < sizeof(older); ++i) CHECK(older.bytes[i] == 0xff);
  older.camera.lens = SWIFTGS_LENS_FISHEYE;
  CHECK_INVALID(swiftgs_camera_scale(&older.camera, 2),
                "swiftgs_camera: size is 144, expected 232 for a camera with a lens that is no pinhole");

  /* Those of an array follow each other at the first one's size: that of a newer program, and of one that is
   * older than stored depths. */
  const size_t sizes[2] = {sizeof(swiftgs_view) + 8, offsetof(swiftgs_view, stored_depth)};
  camera = make_camera(small_width, small_height);
  swiftgs_renderer* const renderer = make_renderer(small_renderer);
  const float* const expected = draw_plain(renderer, &camera);
  for (int i = 0; i < 2; ++i) {
    char* const views = make_memory(2 * sizes[0]);
    if (i == 1) memset(views, 0xff, 2 * sizes[0]); /* what lies behind is not read: NaN */
    float colours[2][3 * small_width * small_height] = {{0}, {0}};
    for (size_t k = 0; k < 2; ++k) {
      swiftgs_view view = make_view(&camera, colours[k]);
      view.size = (uint32_t)sizes[i];
      memcpy(views + k * sizes[i], &view, i == 0 ? sizeof(view) : sizes[i]);
    }
    const swiftgs_frame frame = make_frame((const void*)views, 2);
    CHECK_OK(swiftgs_renderer_render_into(renderer, &frame));
    for (int k = 0; k < 2; ++k) CHECK(memcmp(colours[k], expected, sizeof(colours[k])) == 0);
    const uint32_t other = sizeof(swiftgs_view);
    memcpy(views + sizes[i], &other, sizeof(other));
    CHECK_INVALID(swiftgs_renderer_render_into(renderer, &frame), "swiftgs_view: size of number 1 is");
  }
  swiftgs_renderer_free(renderer);
}

static void* fail_elsewhere(void* unused) {
  (void)unused;
  CHECK(strcmp(swiftgs_last_error(), "") == 0);
  CHECK_INVALID(swiftgs_scene_builtin(1, NULL), "scene is NULL");
  return NULL;
}

void test_threads(void) {
  CHECK_INVALID(swiftgs_conventions_named("none", NULL), "'none'");
  pthread_t thread;
  if (pthread_create(&thread, NULL, &fail_elsewhere, NULL) != 0) give_up("a thread");
  pthread_join(thread, NULL);
  CHECK(strstr(swiftgs_last_error(), "'none'") != NULL);

  /* A call that succeeds keeps the text. */
  swiftgs_camera camera = make_camera(64, 48);
  CHECK(camera.width == 64 && strstr(swiftgs_last_error(), "'none'") != NULL);
}

struct turns {
  swiftgs_renderer* renderer;
  int32_t width, height;
  bool right;
};

/* Draws one view again and again, and sets a scene between: the images are all the same. */
static void* draw_often(void* given) {
  struct turns* const mine = given;
  const size_t bytes = sizeof(float) * 3 * (size_t)mine->width * (size_t)mine->height;
  const swiftgs_camera camera = make_camera(mine->width, mine->height);
  float *const first = make_memory(bytes), *const later = make_memory(bytes);
  swiftgs_scene* const scene = make_scene();
  const swiftgs_view view = make_view(&camera, first), again = make_view(&camera, later);
  const swiftgs_frame frame = make_frame(&view, 1), same = make_frame(&again, 1);
  mine->right = swiftgs_renderer_render(mine->renderer, &frame) == SWIFTGS_OK;
  for (int i = 0; i < 50; ++i) {
    if (i % 10 == 0) mine->right &= swiftgs_renderer_set_scene(mine->renderer, scene) == SWIFTGS_OK;
    mine->right &= swiftgs_renderer_render(mine->renderer, &same) == SWIFTGS_OK;
    mine->right &= memcmp(first, later, bytes) == 0 && first[bytes / sizeof(float) / 2] > 0;
  }
  swiftgs_scene_free(scene);
  free(first), free(later);
  return NULL;
}

void test_turns(void) {
  swiftgs_renderer* const renderer = make_renderer(small_renderer);
  struct turns each[2] = {{renderer, small_width, small_height, false}, {renderer, 200, 120, false}};
  pthread_t threads[2];
  for (int i = 0; i < 2; ++i)
    if (pthread_create(&threads[i], NULL, &draw_often, &each[i]) != 0) give_up("a thread");
  for (int i = 0; i < 2; ++i) pthread_join(threads[i], NULL);
  CHECK(each[0].right && each[1].right);
  CHECK_OK(swiftgs_renderer_share_scene(renderer, renderer));
  swiftgs_renderer_free(renderer);
}
