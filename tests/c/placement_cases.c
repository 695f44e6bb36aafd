/* SPDX-License-Identifier: Apache-2.0 */

/* Placed scenes. What they show has the bits of the C++ interface in same_bits_test. */
#include <math.h>
#include <stdint.h>
#include <string.h>

#include "check.h"

enum { floats = 3 * small_width * small_height, half = small_count / 2 };

/* A drawing whose renderer has the scene twice. */
static void set_up_two(struct drawing* d) {
  set_up(d, small_renderer);
  swiftgs_scene* const scene = make_scene();
  uint64_t number = 7;
  CHECK_OK(swiftgs_renderer_add_scene(d->renderer, scene, &number));
  CHECK(number == 1);
  swiftgs_scene_free(scene);
}

void test_placed(void) {
  struct drawing d;
  set_up_two(&d);
  swiftgs_placement both[2] = {{.size = sizeof(both[0]), .count = half},
                               {.size = sizeof(both[0]), .scene = 1}};
  both[1].first = half;
  swiftgs_renderer* const whole = make_renderer(small_renderer);
  float* const expected = draw_plain(whole, &d.camera);
  CHECK_OK(swiftgs_renderer_place(d.renderer, both, 2));
  CHECK(draws(&d, expected));

  /* Each tells how many splats it had. */
  uint64_t visible[2] = {0};
  swiftgs_statistics counts = {.size = sizeof(counts)};
  CHECK_OK(swiftgs_renderer_visible_by_scene(d.renderer, visible, 2));
  CHECK_OK(swiftgs_renderer_statistics(d.renderer, &counts));
  CHECK(visible[0] > 100 && visible[1] > 100 && visible[0] + visible[1] == counts.visible);
  CHECK_INVALID(swiftgs_renderer_visible_by_scene(d.renderer, visible, 1),
                "visible_by_scene: count is 1, expected 2, the placed scenes of the frame");
  CHECK_INVALID(swiftgs_renderer_visible_by_scene(NULL, visible, 2), "renderer is NULL");
  CHECK_INVALID(swiftgs_renderer_visible_by_scene(d.renderer, NULL, 2), "visible is NULL");

  /* A program of before ranges shows all, and one of before tints the range without one. */
  both[0].size = offsetof(swiftgs_placement, first), both[0].first = 100;
  CHECK_OK(swiftgs_renderer_place(d.renderer, both, 1));
  CHECK(draws(&d, expected));
  both[0].size = sizeof(both[0]);
  CHECK_OK(swiftgs_renderer_place(d.renderer, both, 1));
  float* const range = draw_plain(d.renderer, &d.camera);
  both[0].size = offsetof(swiftgs_placement, tint), both[0].tint[0] = 1, both[0].tint_amount = 0.5f;
  CHECK_OK(swiftgs_renderer_place(d.renderer, both, 1));
  CHECK(draws(&d, range) && !same_floats(range, expected, floats));

  /* Another scene takes the place of all. */
  swiftgs_scene* const scene = make_scene();
  CHECK_OK(swiftgs_renderer_set_scene(d.renderer, scene));
  CHECK(draws(&d, expected));
  swiftgs_scene_free(scene);
  swiftgs_renderer_free(d.renderer), swiftgs_renderer_free(whole);
}

void test_placed_recorded(void) {
  struct drawing d;
  set_up_two(&d);
  float* const recorded = make_floats(floats);
  swiftgs_placement both[2] = {{.size = sizeof(both[0])}, {.size = sizeof(both[0]), .scene = 1}};
  CHECK_OK(swiftgs_renderer_place(d.renderer, both, 2));
  const swiftgs_capacity capacity = {
      .size = sizeof(capacity), .splats = 2 * small_count, .intersections = 200000};
  d.view.colour.data = recorded;
  CHECK_INVALID(swiftgs_renderer_set_recorded_scenes(d.renderer), "expected reserve before set_scenes");
  CHECK_OK(swiftgs_renderer_reserve(d.renderer, &d.frame, &capacity));
  both[1].translation[0] = 0.5;
  CHECK_OK(swiftgs_renderer_place(d.renderer, both, 2));
  swiftgs_report report = {0};
  CHECK_OK(swiftgs_renderer_set_recorded_scenes(d.renderer));
  CHECK_OK(swiftgs_renderer_record(d.renderer, &report));
  CHECK(report.overflowed == 0 && same_floats(recorded, draw_plain(d.renderer, &d.camera), floats));

  /* Where they lie, others may change them: each number as another placement has it. */
  swiftgs_recorded_scenes scenes = {.size = sizeof(scenes)};
  CHECK_OK(swiftgs_renderer_recorded_scenes(d.renderer, &scenes));
  CHECK(scenes.count == 2 && scenes.size == sizeof(scenes));
  double* const x = (double*)((char*)scenes.translation + scenes.stride);
  CHECK(x[0] == 0.5 && scenes.translation[0] == 0 && scenes.scale[0] == 1 && scenes.opacity[0] == 1);
  for (int i = 0; i < 9; ++i) CHECK(scenes.rotation[i] == (i % 4 == 0));
  for (int i = 0; i < 4; ++i) CHECK(scenes.tint[i] == 0);
  both[1].translation[0] = 0, both[0].transparency = 0.75;
  both[1].tint[1] = 2, both[1].tint_amount = 0.25f;
  both[1].rotation[1] = 1, both[1].rotation[5] = 1, both[1].rotation[6] = 1, both[1].scale = 0.5;
  CHECK_OK(swiftgs_renderer_place(d.renderer, both, 2));
  float* const turned = draw_plain(d.renderer, &d.camera);
  x[0] = 0, scenes.opacity[0] = 0.25f;
  float* const tint = (float*)((char*)scenes.tint + scenes.stride);
  tint[1] = 2, tint[3] = 0.25f;
  double* const rotation = (double*)((char*)scenes.rotation + scenes.stride);
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column)
      rotation[3 * column + row] = both[1].rotation[3 * row + column];
  *(double*)((char*)scenes.scale + scenes.stride) = 0.5;
  CHECK(!same_floats(recorded, turned, floats));
  CHECK_OK(swiftgs_renderer_record(d.renderer, &report));
  CHECK(same_floats(recorded, turned, floats));
  uint8_t refused[2] = {7, 7};
  CHECK_OK(swiftgs_renderer_refused_scenes(d.renderer, refused, 2));
  CHECK(refused[0] == 0 && refused[1] == 0); /* a host refuses to record */
  scenes.scale[0] = NAN;
  CHECK_INVALID(swiftgs_renderer_record(d.renderer, &report),
                "placed scene: expected a finite scale above 0");
  CHECK_INVALID(swiftgs_renderer_refused_scenes(d.renderer, refused, 1),
                "refused_scenes: count is 1, expected 2, the placed scenes of the frame");
  CHECK_NULLS(swiftgs_renderer_recorded_scenes, d.renderer, "renderer", &scenes, "swiftgs_recorded_scenes");
  CHECK_INVALID(swiftgs_renderer_refused_scenes(NULL, refused, 2), "renderer is NULL");
  CHECK_INVALID(swiftgs_renderer_refused_scenes(d.renderer, NULL, 2), "refused is NULL");
  CHECK_INVALID(swiftgs_renderer_set_recorded_scenes(NULL), "renderer is NULL");
  swiftgs_renderer_free(d.renderer);
}

void test_placed_errors(void) {
  struct drawing d;
  set_up_two(&d);
  swiftgs_renderer* const renderer = d.renderer;
  const float* const expected = draw_plain(renderer, &d.camera);
  swiftgs_scene* const scene = make_scene();
  uint64_t number = 0;
  CHECK_INVALID(swiftgs_renderer_add_scene(NULL, scene, &number), "renderer is NULL");
  CHECK_INVALID(swiftgs_renderer_add_scene(renderer, NULL, &number), "scene is NULL");
  CHECK_INVALID(swiftgs_renderer_add_scene(renderer, scene, NULL), "number is NULL");
  const swiftgs_gaussians arrays = arrays_of(scene);
  CHECK_INVALID(swiftgs_renderer_update_scene(NULL, 0, 0, &arrays), "renderer is NULL");
  CHECK_INVALID(swiftgs_renderer_update_scene(renderer, 0, 0, NULL), "swiftgs_gaussians is NULL");
  CHECK_INVALID(swiftgs_renderer_update_scene(renderer, 2, 0, &arrays),
                "update_scene: the scene is number 2, expected less than 2");
  CHECK_INVALID(swiftgs_renderer_update_scene(renderer, 0, 1, &arrays),
                "update: 2000 Gaussians from number 1 on, expected some of the scene's 2000");

  const swiftgs_placement zeros = {.size = sizeof(zeros)};
  CHECK_INVALID(swiftgs_renderer_place(NULL, &zeros, 1), "renderer is NULL");
  CHECK_INVALID(swiftgs_renderer_place(renderer, NULL, 1), "swiftgs_placement is NULL");
  CHECK_INVALID(swiftgs_renderer_place(renderer, NULL, 0), "place: expected one placement or more");
  swiftgs_placement wrong;
#define REFUSE(change, part) \
  wrong = zeros, wrong.change, CHECK_INVALID(swiftgs_renderer_place(renderer, &wrong, 1), part)
  REFUSE(scale = -1, "placed scene: expected a finite scale above 0");
  REFUSE(transparency = 1.5, "swiftgs_placement: transparency is 1.5");
  REFUSE(transparency = NAN, "swiftgs_placement: transparency is nan");
  REFUSE(count = (uint64_t)-1, "swiftgs_placement: count is 18446744073709551615, expected fewer, or 0");
  REFUSE(size = 8, "swiftgs_placement: size is 8, expected 272");
#undef REFUSE
  const swiftgs_placement two[2] = {zeros, wrong};
  CHECK_INVALID(swiftgs_renderer_place(renderer, two, 2), "swiftgs_placement: size of number 1 is 8");
  CHECK(draws(&d, expected)); /* nothing has changed */
  swiftgs_scene_free(scene), swiftgs_renderer_free(renderer);
}
