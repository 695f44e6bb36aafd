/* SPDX-License-Identifier: Apache-2.0 */

/* Frames: conventions, and what cannot be drawn. What a frame shows has the bits of the C++ interface in
 * same_bits_test. */
#include <math.h>
#include <stddef.h>
#include <string.h>

#include "check.h"

enum { width = small_width, height = small_height, pixels = small_width * small_height };

/* Programs that are older than planes and than the first alpha. */
void test_older_frames(void) {
  struct drawing d;
  set_up(&d, small_renderer);
  float *const first = make_floats(pixels), *const usual = make_floats(pixels);
  d.view.first_depth = (swiftgs_plane){first, 4 * width};
  swiftgs_conventions conventions = {.size = sizeof(conventions)};
  CHECK_OK(swiftgs_conventions_named("gsplat", &conventions));
  d.view.conventions = &conventions;
  CHECK_OK(swiftgs_renderer_render(d.renderer, &d.frame));
  memcpy(usual, first, sizeof(float) * pixels);
  conventions.first_alpha = 0.5f;
  CHECK_OK(swiftgs_renderer_render(d.renderer, &d.frame));
  CHECK(!same_floats(first, usual, pixels));
  conventions.size = offsetof(swiftgs_conventions, first_alpha);
  CHECK_OK(swiftgs_renderer_render(d.renderer, &d.frame));
  CHECK(same_floats(first, usual, pixels));
  memset(first, 0, sizeof(float) * pixels);
  d.view.size = offsetof(swiftgs_view, squared_depth);
  CHECK_OK(swiftgs_renderer_render(d.renderer, &d.frame));
  for (int i = 0; i < pixels; ++i) CHECK(first[i] == 0);
  swiftgs_renderer_free(d.renderer);
}

void test_conventions(void) {
  swiftgs_conventions gsplat = {.size = sizeof(gsplat)}, inria = {.size = sizeof(inria)},
                      khronos = {.size = sizeof(khronos)};
  CHECK_OK(swiftgs_conventions_named("gsplat", &gsplat));
  CHECK_OK(swiftgs_conventions_named("inria", &inria));
  CHECK_OK(swiftgs_conventions_named("khronos", &khronos));
  CHECK(gsplat.blur == SWIFTGS_OF_SCENE && gsplat.antialiased == SWIFTGS_OF_SCENE);
  CHECK(gsplat.order == SWIFTGS_OF_SCENE && gsplat.colours == SWIFTGS_OF_SCENE);
  CHECK(gsplat.depth == SWIFTGS_DEPTH_OF_LENS && gsplat.depth_at == SWIFTGS_DEPTH_AT_CENTRE);
  CHECK(gsplat.footprint == SWIFTGS_FOOTPRINT_ALPHA &&
        inria.footprint == SWIFTGS_FOOTPRINT_THREE_SIGMA_SQUARE &&
        khronos.footprint == SWIFTGS_FOOTPRINT_THREE_SIGMA_ELLIPSE);
  CHECK(khronos.order == SWIFTGS_ORDER_DISTANCE && khronos.alpha_max == 1 && khronos.stop == 0);
  CHECK(gsplat.min_compensation == 2.5e-5f && inria.cull_at_near == 1 && isinf(inria.far_plane));

  struct drawing d;
  set_up(&d, small_renderer);
  const swiftgs_conventions usual = gsplat;
  d.view.conventions = &gsplat;
#define REFUSE(changes, part) \
  gsplat = usual, gsplat.changes, CHECK_INVALID(swiftgs_renderer_render_into(d.renderer, &d.frame), part)
  REFUSE(clamp = 2, "swiftgs_conventions: clamp is 2, expected 0 to 1");
  REFUSE(footprint = -1, "swiftgs_conventions: footprint is -1");
  REFUSE(depth = 3, "swiftgs_conventions: depth is 3, expected 0 to 2");
  REFUSE(depth_at = 2, "swiftgs_conventions: depth_at is 2, expected 0 to 1");
  REFUSE(order = 2, "swiftgs_conventions: order is 2, expected 0 to 1");
  REFUSE(colours = -2, "swiftgs_conventions: colours is -2, expected 0 to 1");
  REFUSE(size = 1, "swiftgs_conventions: size is 1");
#undef REFUSE
  CHECK_INVALID(swiftgs_conventions_named("gsplat", &gsplat), "size is 1");
  CHECK_INVALID(swiftgs_conventions_named("other", &inria), "expected gsplat, inria or khronos");
  CHECK_NULLS(swiftgs_conventions_named, "inria", "name", &inria, "swiftgs_conventions");
  swiftgs_renderer_free(d.renderer);
}

struct given {
  swiftgs_conventions conventions;
  swiftgs_camera camera;
  swiftgs_placement placement;
};

static swiftgs_status draw_given(swiftgs_renderer* renderer, const struct given* given, float* colour) {
  const swiftgs_status placed = swiftgs_renderer_place(renderer, &given->placement, 1);
  if (placed != SWIFTGS_OK) return placed;
  swiftgs_view view = make_view(&given->camera, colour);
  view.conventions = &given->conventions;
  const swiftgs_frame frame = make_frame(&view, 1);
  return swiftgs_renderer_render(renderer, &frame);
}

void test_refusals(void) {
  struct drawing d;
  set_up(&d, small_renderer);
  struct given usual = {.conventions = {.size = sizeof(usual.conventions)},
                        .camera = d.camera,
                        .placement = {.size = sizeof(usual.placement)}};
  CHECK_OK(swiftgs_conventions_named("gsplat", &usual.conventions));
  CHECK_OK(draw_given(d.renderer, &usual, d.colour));
  struct given given;
#define REFUSED(what, member, value, part)  \
  given = usual, given.what.member = value; \
  CHECK_INVALID(draw_given(d.renderer, &given, d.colour), part);
#include "support/refusals.inc"
#undef REFUSED
  CHECK_OK(draw_given(d.renderer, &usual, d.colour));
  swiftgs_renderer_free(d.renderer);
}

/* Every function that takes a frame refuses it alike. */
static void refuse(swiftgs_renderer* renderer, const swiftgs_frame* frame, const char* part) {
  CHECK_INVALID(swiftgs_renderer_render_into(renderer, frame), part);
  CHECK_INVALID(swiftgs_renderer_render(renderer, frame), part);
  CHECK_INVALID(swiftgs_renderer_reserve(renderer, frame, NULL), part);
  CHECK_INVALID(swiftgs_renderer_set_views(renderer, frame), part);
}

void test_frame_errors(void) {
  struct drawing d;
  set_up(&d, small_renderer);
  const swiftgs_view valid = d.view;
  const swiftgs_frame whole = d.frame;
  const float* const expected = draw_plain(d.renderer, &d.camera);
  refuse(NULL, &whole, "renderer is NULL");
  refuse(d.renderer, NULL, "swiftgs_frame is NULL");
#define REFUSE(changes, part) d.view = valid, d.frame = whole, d.changes, refuse(d.renderer, &d.frame, part)
  REFUSE(frame.count = 0, "swiftgs_frame: count is 0, expected 1 to 65536 views");
  REFUSE(frame.count = 65537, "count is 65537");
  REFUSE(frame.views = NULL, "swiftgs_frame: views is NULL");
  REFUSE(frame.measure = 4, "measure is 4, expected a sum of 1 and 2");
  REFUSE(frame.size = 3, "swiftgs_frame: size is 3");
  REFUSE(view.size = 0, "swiftgs_view: size is 0");
  REFUSE(view.format = 5, "swiftgs_view: format is 5, expected 0 to 4");
  REFUSE(view.conversion = 3, "swiftgs_view: conversion is 3, expected 0 to 2");
  REFUSE(view.camera = NULL, "swiftgs_view: camera is NULL");
  REFUSE(view.colour.pitch = 4, "the pitch of colour is 4 bytes");
#undef REFUSE

  /* The renderer works on. */
  d.view = valid;
  CHECK(draws(&d, expected));
  swiftgs_renderer_free(d.renderer);
}
