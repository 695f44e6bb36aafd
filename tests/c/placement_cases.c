/* SPDX-License-Identifier: Apache-2.0 */

/* Placed scenes: several scenes in one frame. */
#include <math.h>
#include <stdint.h>
#include <string.h>

#include "check.h"

enum { pixels = small_width * small_height, floats = 3 * pixels, half = small_count / 2 };

/* Arrays of the Gaussians [first, first + count) of a scene. */
static swiftgs_gaussians range_of(const swiftgs_scene* scene, uint64_t first, uint64_t count) {
  swiftgs_gaussians arrays = arrays_of(scene);
  swiftgs_array* const all[] = {&arrays.means,     &arrays.scales, &arrays.rotations,
                                &arrays.opacities, &arrays.sh0,    &arrays.sh_rest};
  for (size_t i = 0; i < sizeof(all) / sizeof(all[0]); ++i)
    all[i]->data += first * (uint64_t)all[i]->stride / sizeof(float);
  arrays.count = count;
  return arrays;
}

static swiftgs_scene* part_of(const swiftgs_scene* scene, uint64_t first, uint64_t count) {
  const swiftgs_gaussians arrays = range_of(scene, first, count);
  swiftgs_scene* part = NULL;
  CHECK_OK(swiftgs_scene_from_arrays(&arrays, &part));
  return part;
}

/* A drawing with ids, whose renderer has the two halves of the scene. */
struct halves {
  struct drawing d;
  uint32_t* id;
};

static void set_up_halves(struct halves* h) {
  set_up(&h->d, small_renderer);
  h->id = make_memory(sizeof(uint32_t) * pixels);
  h->d.view.id = (swiftgs_plane){h->id, (int64_t)sizeof(uint32_t) * small_width};
  swiftgs_renderer_free(h->d.renderer);
  CHECK_OK(swiftgs_renderer_create(small_renderer, NULL, &h->d.renderer));
  swiftgs_scene* const whole = make_scene();
  for (uint64_t i = 0; i < 2; ++i) {
    swiftgs_scene* const part = part_of(whole, i * half, half);
    uint64_t number = 7;
    CHECK_OK(swiftgs_renderer_add_scene(h->d.renderer, part, &number));
    CHECK(number == i);
    swiftgs_scene_free(part);
  }
  swiftgs_scene_free(whole);
}

/* What placements have beside a scene's number has the bits of the C++ interface in same_bits_test. */
void test_placed(void) {
  struct halves h;
  set_up_halves(&h);
  struct drawing* const d = &h.d;
  swiftgs_renderer* const whole = make_renderer(small_renderer);
  float* const expected = draw_plain(whole, &d->camera);

  /* The halves are the whole, also with the second one first: then Gaussians have other numbers. */
  CHECK(draws(d, expected));
  uint32_t* const id = make_memory(sizeof(uint32_t) * pixels);
  memcpy(id, h.id, sizeof(uint32_t) * pixels);
  swiftgs_placement both[2] = {{.size = sizeof(both[0]), .scene = 1}, {.size = sizeof(both[0])}};
  CHECK_OK(swiftgs_renderer_place(d->renderer, both, 2));
  CHECK(draws(d, expected));
  for (int i = 0; i < pixels; ++i)
    CHECK(h.id[i] == (id[i] == SWIFTGS_NOTHING ? id[i] : (id[i] + half) % small_count));

  /* Each tells how many splats it had. */
  uint64_t visible[2] = {0}, swapped[2] = {0};
  swiftgs_statistics counts = {.size = sizeof(counts)};
  CHECK_OK(swiftgs_renderer_visible_by_scene(d->renderer, swapped, 2));
  CHECK_OK(swiftgs_renderer_statistics(d->renderer, &counts));
  CHECK(swapped[0] > 100 && swapped[1] > 100 && swapped[0] + swapped[1] == counts.visible);
  CHECK_INVALID(swiftgs_renderer_visible_by_scene(d->renderer, visible, 1),
                "visible_by_scene: count is 1, expected 2, the placed scenes of the frame");
  CHECK_INVALID(swiftgs_renderer_visible_by_scene(NULL, visible, 2), "renderer is NULL");
  CHECK_INVALID(swiftgs_renderer_visible_by_scene(d->renderer, NULL, 2), "visible is NULL");

  /* Views show some of them. */
  CHECK_OK(swiftgs_renderer_place(d->renderer, both, 1));
  float* const second = draw_plain(d->renderer, &d->camera);
  CHECK_OK(swiftgs_renderer_place(d->renderer, &both[1], 1));
  float* const first = draw_plain(d->renderer, &d->camera);
  CHECK_OK(swiftgs_renderer_visible_by_scene(d->renderer, visible, 1));
  CHECK(visible[0] == swapped[1] && !same_floats(first, second, floats));
  CHECK_OK(swiftgs_renderer_place(d->renderer, both, 2));
  d->view.first_shown = 1;
  CHECK(draws(d, first));
  d->view.first_shown = 0, d->view.shown_count = 1;
  CHECK(draws(d, second));

  /* A program of before ranges shows all. */
  d->view.shown_count = 0;
  both[0].size = offsetof(swiftgs_placement, first), both[0].first = 100;
  CHECK_OK(swiftgs_renderer_place(d->renderer, both, 1));
  CHECK(draws(d, second));

  /* One of before tints shows the range without one. */
  both[0].size = offsetof(swiftgs_placement, tint), both[0].first = 0, both[0].count = half;
  both[0].tint[0] = 1, both[0].tint_amount = 0.5f;
  CHECK_OK(swiftgs_renderer_place(d->renderer, both, 1));
  CHECK(draws(d, second));
  both[0].size = sizeof(both[0]);
  CHECK_OK(swiftgs_renderer_place(d->renderer, both, 1));
  CHECK(!draws(d, second));
  both[0].tint_amount = 0;
  CHECK_OK(swiftgs_renderer_place(d->renderer, both, 1));
  CHECK(draws(d, second));

  /* Another scene takes the place of all, and another renderer shares it. */
  swiftgs_scene* const scene = make_scene();
  CHECK_OK(swiftgs_renderer_set_scene(d->renderer, scene));
  CHECK(draws(d, expected));
  uint64_t number = 0;
  CHECK_OK(swiftgs_renderer_add_scene(d->renderer, scene, &number));
  CHECK(number == 1);
  CHECK_OK(swiftgs_renderer_share_scene(whole, d->renderer));
  CHECK_OK(swiftgs_renderer_render(whole, &d->frame));
  CHECK_OK(swiftgs_renderer_statistics(whole, &counts));
  CHECK(counts.gaussians == 2 * small_count);
  swiftgs_scene_free(scene);
  swiftgs_renderer_free(d->renderer), swiftgs_renderer_free(whole);
}

void test_update(void) {
  struct halves h;
  set_up_halves(&h);
  struct drawing* const d = &h.d;
  swiftgs_scene* const scene = make_scene();
  float* const before = draw_plain(d->renderer, &d->camera);

  /* The other half takes the place of the first, in two steps, and then its means alone. */
  swiftgs_gaussians some = range_of(scene, half, 300);
  CHECK_OK(swiftgs_renderer_update_scene(d->renderer, 0, 0, &some));
  float* const part = draw_plain(d->renderer, &d->camera);
  CHECK(!same_floats(part, before, floats));
  some = range_of(scene, half + 300, half - 300);
  CHECK_OK(swiftgs_renderer_update_scene(d->renderer, 0, 300, &some));
  swiftgs_renderer* const twice = make_renderer(small_renderer);
  swiftgs_scene* const second = part_of(scene, half, half);
  uint64_t number = 0;
  CHECK_OK(swiftgs_renderer_set_scene(twice, second));
  CHECK_OK(swiftgs_renderer_add_scene(twice, second, &number));
  CHECK(same_floats(draw_plain(d->renderer, &d->camera), draw_plain(twice, &d->camera), floats));
  const swiftgs_gaussians means = {
      .size = sizeof(means), .count = half, .means = range_of(scene, 0, half).means};
  CHECK_OK(swiftgs_renderer_update_scene(d->renderer, 0, 0, &means));
  CHECK_OK(swiftgs_renderer_update_scene(twice, 0, 0, &means));
  float* const moved = draw_plain(twice, &d->camera);
  CHECK(same_floats(draw_plain(d->renderer, &d->camera), moved, floats) && !same_floats(moved, part, floats));

  /* What is refused changes nothing. */
  CHECK_INVALID(swiftgs_renderer_update_scene(NULL, 0, 0, &means), "renderer is NULL");
  CHECK_INVALID(swiftgs_renderer_update_scene(twice, 0, 0, NULL), "swiftgs_gaussians is NULL");
  CHECK_INVALID(swiftgs_renderer_update_scene(twice, 2, 0, &means),
                "update_scene: the scene is number 2, expected less than 2");
  CHECK_INVALID(swiftgs_renderer_update_scene(twice, 0, 1, &means),
                "update: 1000 Gaussians from number 1 on, expected some of the scene's 1000");
  CHECK(same_floats(draw_plain(twice, &d->camera), moved, floats));
  swiftgs_scene_free(scene), swiftgs_scene_free(second);
  swiftgs_renderer_free(d->renderer), swiftgs_renderer_free(twice);
}

void test_placed_recorded(void) {
  struct halves h;
  set_up_halves(&h);
  struct drawing* const d = &h.d;
  float* const recorded = make_floats(floats);
  swiftgs_placement both[2] = {{.size = sizeof(both[0])}, {.size = sizeof(both[0]), .scene = 1}};
  CHECK_OK(swiftgs_renderer_place(d->renderer, both, 2));
  const swiftgs_capacity capacity = {
      .size = sizeof(capacity), .splats = small_count, .intersections = 100000};
  float* const before = draw_plain(d->renderer, &d->camera);
  d->view.colour.data = recorded;
  CHECK_OK(swiftgs_renderer_reserve(d->renderer, &d->frame, &capacity));
  both[1].translation[0] = 0.5;
  CHECK_OK(swiftgs_renderer_place(d->renderer, both, 2));
  swiftgs_report report = {0};
  CHECK_OK(swiftgs_renderer_record(d->renderer, &report));
  CHECK(report.overflowed == 0 && same_floats(recorded, before, floats));
  CHECK_OK(swiftgs_renderer_set_recorded_scenes(d->renderer));
  CHECK_OK(swiftgs_renderer_record(d->renderer, &report));
  CHECK(!same_floats(recorded, before, floats));
  CHECK(same_floats(recorded, draw_plain(d->renderer, &d->camera), floats));

  /* Where they lie, others may change them: each number as another placement has it. */
  swiftgs_recorded_scenes scenes = {.size = sizeof(scenes)};
  CHECK_OK(swiftgs_renderer_recorded_scenes(d->renderer, &scenes));
  CHECK(scenes.count == 2 && scenes.size == sizeof(scenes));
  double* const x = (double*)((char*)scenes.translation + scenes.stride);
  CHECK(x[0] == 0.5 && scenes.translation[0] == 0 && scenes.scale[0] == 1 && scenes.opacity[0] == 1);
  for (int i = 0; i < 9; ++i) CHECK(scenes.rotation[i] == (i % 4 == 0));
  for (int i = 0; i < 4; ++i) CHECK(scenes.tint[i] == 0);
  both[1].translation[0] = 0, both[0].transparency = 0.75;
  both[1].tint[1] = 2, both[1].tint_amount = 0.25f;
  both[1].rotation[1] = 1, both[1].rotation[5] = 1, both[1].rotation[6] = 1, both[1].scale = 0.5;
  CHECK_OK(swiftgs_renderer_place(d->renderer, both, 2));
  float* const turned = draw_plain(d->renderer, &d->camera);
  CHECK(!same_floats(turned, before, floats));
  x[0] = 0, scenes.opacity[0] = 0.25f;
  float* const tint = (float*)((char*)scenes.tint + scenes.stride);
  tint[1] = 2, tint[3] = 0.25f;
  double* const rotation = (double*)((char*)scenes.rotation + scenes.stride);
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column)
      rotation[3 * column + row] = both[1].rotation[3 * row + column];
  *(double*)((char*)scenes.scale + scenes.stride) = 0.5;
  CHECK_OK(swiftgs_renderer_record(d->renderer, &report));
  CHECK(same_floats(recorded, turned, floats));
  uint8_t refused[2] = {7, 7};
  CHECK_OK(swiftgs_renderer_refused_scenes(d->renderer, refused, 2));
  CHECK(refused[0] == 0 && refused[1] == 0); /* a host refuses to record */
  scenes.scale[0] = NAN;
  CHECK_INVALID(swiftgs_renderer_record(d->renderer, &report),
                "placed scene: expected a finite scale above 0");
  CHECK_INVALID(swiftgs_renderer_refused_scenes(d->renderer, refused, 1),
                "refused_scenes: count is 1, expected 2, the placed scenes of the frame");
  CHECK_NULLS(swiftgs_renderer_recorded_scenes, d->renderer, "renderer", &scenes, "swiftgs_recorded_scenes");
  CHECK_INVALID(swiftgs_renderer_refused_scenes(NULL, refused, 2), "renderer is NULL");
  CHECK_INVALID(swiftgs_renderer_refused_scenes(d->renderer, NULL, 2), "refused is NULL");

  CHECK_INVALID(swiftgs_renderer_set_recorded_scenes(NULL), "renderer is NULL");
  CHECK_OK(swiftgs_renderer_place(d->renderer, both, 1));
  CHECK_INVALID(swiftgs_renderer_set_recorded_scenes(d->renderer),
                "the number of placed scenes is 1, expected 2 as reserved");
  swiftgs_renderer_free(d->renderer);
}

void test_placed_errors(void) {
  struct halves h;
  set_up_halves(&h);
  swiftgs_renderer* const renderer = h.d.renderer;
  swiftgs_scene* const scene = make_scene();
  uint64_t number = 0;
  CHECK_INVALID(swiftgs_renderer_add_scene(NULL, scene, &number), "renderer is NULL");
  CHECK_INVALID(swiftgs_renderer_add_scene(renderer, NULL, &number), "scene is NULL");
  CHECK_INVALID(swiftgs_renderer_add_scene(renderer, scene, NULL), "number is NULL");

  const swiftgs_placement zeros = {.size = sizeof(zeros)};
  CHECK_INVALID(swiftgs_renderer_place(NULL, &zeros, 1), "renderer is NULL");
  CHECK_INVALID(swiftgs_renderer_place(renderer, NULL, 1), "swiftgs_placement is NULL");
  CHECK_INVALID(swiftgs_renderer_place(renderer, NULL, 0), "place: expected one placement or more");
  swiftgs_placement wrong;
#define REFUSE(changes, part) \
  wrong = zeros, changes, CHECK_INVALID(swiftgs_renderer_place(renderer, &wrong, 1), part)
  REFUSE(wrong.scene = 2, "place: the scene is number 2, expected less than 2");
  REFUSE(wrong.scale = -1, "placed scene: expected a finite scale above 0");
  REFUSE(wrong.translation[1] = NAN, "placed scene: expected a finite translation");
  REFUSE(wrong.rotation[0] = 1, "placed scene: expected a rotation with orthonormal columns");
  REFUSE(wrong.transparency = 1.5, "swiftgs_placement: transparency is 1.5");
  REFUSE(wrong.transparency = NAN, "swiftgs_placement: transparency is nan");
  REFUSE(wrong.half_space_count = 7, "placed scene: expected a clip of 0 to 6 half-spaces");
  REFUSE(wrong.radius = -1, "placed scene: expected a clip with a radius of 0 or more");
  REFUSE(wrong.tint_amount = 1.5f, "placed scene: expected a tint with an amount of 0 to 1");
  REFUSE(wrong.tint_amount = NAN, "placed scene: expected a tint with an amount of 0 to 1");
  REFUSE(wrong.tint[2] = INFINITY, "placed scene: expected a tint with a finite colour of 0 or more");
  REFUSE(wrong.tint[0] = -1, "placed scene: expected a tint with a finite colour of 0 or more");
  REFUSE(wrong.count = (uint64_t)-1,
         "swiftgs_placement: count is 18446744073709551615, expected fewer, or 0");
  REFUSE((wrong.first = half, wrong.count = 1), "place: placement 0 shows 1 Gaussians from number");
  REFUSE(wrong.first = half + 1, "placement 0 shows all Gaussians from number");
  REFUSE(wrong.size = 8, "swiftgs_placement: size is 8, expected 272");
#undef REFUSE
  const swiftgs_placement two[2] = {zeros, wrong};
  CHECK_INVALID(swiftgs_renderer_place(renderer, two, 2), "swiftgs_placement: size of number 1 is 8");

  /* Nothing has changed: the halves are the whole. */
  swiftgs_renderer* const whole = make_renderer(small_renderer);
  CHECK(same_floats(draw_plain(renderer, &h.d.camera), draw_plain(whole, &h.d.camera), floats));
  h.d.view.first_shown = 1, h.d.view.shown_count = 2;
  CHECK_INVALID(swiftgs_renderer_render(renderer, &h.d.frame),
                "a view shows 2 placed scenes from number 1 on, expected some of the frame's 2");
  CHECK_INVALID(swiftgs_renderer_set_recorded_scenes(renderer), "expected reserve before set_scenes");
  swiftgs_scene_free(scene);
  swiftgs_renderer_free(renderer), swiftgs_renderer_free(whole);
}
