/* SPDX-License-Identifier: Apache-2.0 */

/* Frames: planes, views, conventions, and what cannot be drawn. Formats and planes have the bits of the C++
 * interface in same_bits_test. */
#include <math.h>
#include <stddef.h>
#include <string.h>

#include "check.h"

enum { width = small_width, height = small_height, pixels = small_width * small_height };

void test_planes(void) {
  struct drawing d;
  set_up(&d, small_renderer);
  swiftgs_scene* const scene = make_scene();
  swiftgs_gaussians arrays = arrays_of(scene);
  arrays.features.data = make_floats(2 * small_count), arrays.feature_channels = 2;
  CHECK_OK(swiftgs_renderer_set_gaussians(d.renderer, &arrays));

  /* The first Gaussian that shows is the median one if it has to show as much. */
  const swiftgs_view coloured = d.view;
  float *const first = make_floats(pixels), *const median = make_floats(pixels);
  d.view.first_depth = (swiftgs_plane){first, 4 * width};
  d.view.median_depth = (swiftgs_plane){median, 4 * width};
  swiftgs_conventions conventions = {.size = sizeof(conventions)};
  CHECK_OK(swiftgs_conventions_named("gsplat", &conventions));
  d.view.conventions = &conventions;
  CHECK_OK(swiftgs_renderer_render(d.renderer, &d.frame));
  CHECK(!same_floats(first, median, pixels));
  float* const usual = make_floats(pixels);
  memcpy(usual, first, sizeof(float) * pixels);
  conventions.first_alpha = 0.5f;
  CHECK_OK(swiftgs_renderer_render(d.renderer, &d.frame));
  CHECK(same_floats(first, median, pixels));
  conventions.first_alpha = 1;
  CHECK_INVALID(swiftgs_renderer_render(d.renderer, &d.frame), "a first alpha of 0 or more and below 1");
  /* A program that is older than this number has that of gsplat, and one older than the planes draws none. */
  conventions.size = offsetof(swiftgs_conventions, first_alpha);
  CHECK_OK(swiftgs_renderer_render(d.renderer, &d.frame));
  CHECK(same_floats(first, usual, pixels));
  memset(first, 0, sizeof(float) * pixels);
  d.view.size = offsetof(swiftgs_view, squared_depth);
  CHECK_OK(swiftgs_renderer_render(d.renderer, &d.frame));
  for (int i = 0; i < pixels; ++i) CHECK(first[i] == 0);

  d.view = coloured;
  d.view.features = (swiftgs_plane){d.colour, 12 * width}, d.view.feature_channels = 3;
  CHECK_INVALID(swiftgs_renderer_render(d.renderer, &d.frame),
                "the frame asks for 3 features a Gaussian, expected at most the 2 of the scene");
  swiftgs_scene_free(scene), swiftgs_renderer_free(d.renderer);
}

void test_views(void) {
  swiftgs_renderer* const renderer = make_renderer(small_renderer);
  const swiftgs_camera near = make_camera(width, height);
  swiftgs_camera aside = make_camera(80, 40);
  aside.translation[0] += 0.3;
  const float* const first = draw_plain(renderer, &near);
  const float* const second = draw_plain(renderer, &aside);

  /* One frame: four parts that make up an image, and another camera's image. */
  float* const together = make_floats(3 * (pixels + 80 * 40));
  swiftgs_view views[5];
  for (int i = 0; i < 4; ++i) {
    const int left = i % 2 * 32, top = i / 2 * 16;
    views[i] = make_view(&near, together + 3 * (top * width + left));
    views[i].left = left, views[i].top = top;
    views[i].width = 32, views[i].height = i / 2 == 0 ? 16 : height - 16;
  }
  views[4] = make_view(&aside, together + 3 * pixels);
  const swiftgs_frame frame = make_frame(views, 5);
  CHECK_OK(swiftgs_renderer_render_into(renderer, &frame));
  CHECK(same_floats(together, first, 3 * pixels));
  CHECK(same_floats(together + 3 * pixels, second, 3 * 80 * 40));
  swiftgs_renderer_free(renderer);
}

/* Alpha of a pixel whose centre a Gaussian of opacity 1/2 lies on, 2 in front of the camera. */
static float alpha_at(float x, double cx, float size, const swiftgs_conventions* conventions) {
  const float mean[3] = {x, 0, 2}, scale[3] = {size, size, size}, rotation[4] = {1, 0, 0, 0}, half = 0.5f;
  swiftgs_gaussians one = {.size = sizeof(one), .count = 1};
  one.means.data = one.sh0.data = mean, one.scales.data = scale, one.rotations.data = rotation;
  one.opacities.data = &half;
  swiftgs_renderer* const renderer = make_renderer("serial/early/per-pixel/ellipse");
  CHECK_OK(swiftgs_renderer_set_gaussians(renderer, &one));
  swiftgs_camera camera = {.size = sizeof(camera), .width = 1, .height = 1, .fx = 1, .fy = 1, .cx = cx};
  camera.rotation[0] = camera.rotation[4] = camera.rotation[8] = 1, camera.cy = 0.5;
  float alpha = -1;
  const swiftgs_view view = {
      .size = sizeof(view), .camera = &camera, .conventions = conventions, .alpha = {&alpha, sizeof(alpha)}};
  const swiftgs_frame frame = make_frame(&view, 1);
  CHECK_OK(swiftgs_renderer_render(renderer, &frame));
  swiftgs_renderer_free(renderer);
  return alpha;
}

void test_each_convention(void) {
  swiftgs_conventions gsplat = {.size = sizeof(gsplat)};
  CHECK_OK(swiftgs_conventions_named("gsplat", &gsplat));
  swiftgs_conventions c = gsplat;
#define ALPHA(changes) (changes, alpha_at(0, 0.5, 0.01f, &c))
  CHECK(ALPHA(c = gsplat) == 0.5f);
  CHECK(ALPHA(c.far_plane = 1) == 0);
  CHECK(ALPHA((c = gsplat, c.near_plane = 2)) == 0.5f);
  CHECK(ALPHA(c.cull_at_near = 1) == 0);
  CHECK(ALPHA((c = gsplat, c.alpha_min = 0.6f)) == 0);
  CHECK(ALPHA((c = gsplat, c.alpha_max = 0.25f)) == 0.25f);
  CHECK(ALPHA((c = gsplat, c.stop = 0.5f)) == 0);
  CHECK(ALPHA(c.stop_at_equal = 0) == 0.5f);
  CHECK(ALPHA((c = gsplat, c.antialiased = 1)) < 0.25f); /* a splat much smaller than a pixel */
  CHECK(ALPHA(c.min_compensation = 1) == 0.5f);
#undef ALPHA
  /* Far off the axis and in the middle of the image; its blurred covariance depends on the tangent. */
  c = gsplat, c.antialiased = 1;
  const float around_image = alpha_at(8, -3.5, 1, &c);
  c.clamp = SWIFTGS_CLAMP_AROUND_CENTRE;
  CHECK(around_image > alpha_at(8, -3.5, 1, &c) + 0.01f);
  /* Its z is 2, and its distance 8.2. */
  c = gsplat, c.far_plane = 4;
  CHECK(alpha_at(8, -3.5, 1, &c) > 0);
  c.depth = SWIFTGS_DEPTH_Z;
  CHECK(alpha_at(8, -3.5, 1, &c) > 0);
  c.depth = SWIFTGS_DEPTH_DISTANCE;
  CHECK(alpha_at(8, -3.5, 1, &c) == 0);
}

void test_conventions(void) {
  swiftgs_conventions gsplat = {.size = sizeof(gsplat)}, inria = {.size = sizeof(inria)};
  CHECK_OK(swiftgs_conventions_named("gsplat", &gsplat));
  CHECK_OK(swiftgs_conventions_named("inria", &inria));
  /* The other numbers have the bits of the C++ interface in same_bits_test, whose frames do not show these.
   */
  CHECK(gsplat.blur == SWIFTGS_OF_SCENE && gsplat.antialiased == SWIFTGS_OF_SCENE);
  CHECK(gsplat.order == SWIFTGS_OF_SCENE && gsplat.colours == SWIFTGS_OF_SCENE);
  CHECK(gsplat.depth == SWIFTGS_DEPTH_OF_LENS && gsplat.depth_at == SWIFTGS_DEPTH_AT_CENTRE);
  CHECK(gsplat.min_compensation == 2.5e-5f && inria.cull_at_near == 1 && isinf(inria.far_plane));

  struct drawing d;
  set_up(&d, small_renderer);
  float* const plain = draw_plain(d.renderer, &d.camera);
  d.view.conventions = &gsplat;
  CHECK_OK(swiftgs_renderer_render_into(d.renderer, &d.frame));
  CHECK(same_floats(d.colour, plain, 3 * pixels));
  gsplat.blur = 1;
  CHECK_OK(swiftgs_renderer_render_into(d.renderer, &d.frame));
  CHECK(!same_floats(d.colour, plain, 3 * pixels));

#define REFUSE(changes, part) changes, CHECK_INVALID(swiftgs_renderer_render_into(d.renderer, &d.frame), part)
  REFUSE(gsplat.blur = -2, "a blur of 0 or more");
  REFUSE((gsplat.blur = 0, gsplat.clamp = 2), "swiftgs_conventions: clamp is 2, expected 0 to 1");
  REFUSE((gsplat.clamp = 0, gsplat.footprint = -1), "footprint is -1");
  REFUSE((gsplat.footprint = 0, gsplat.depth = 3), "swiftgs_conventions: depth is 3, expected 0 to 2");
  REFUSE((gsplat.depth = 0, gsplat.depth_at = 2), "swiftgs_conventions: depth_at is 2, expected 0 to 1");
  gsplat.size = 52; /* of a program that is older than this member */
  CHECK_OK(swiftgs_renderer_render_into(d.renderer, &d.frame));
  REFUSE(gsplat.size = 1, "swiftgs_conventions: size is 1");
#undef REFUSE
  CHECK_INVALID(swiftgs_conventions_named("gsplat", &gsplat), "size is 1");
  CHECK_INVALID(swiftgs_conventions_named("other", &inria), "expected gsplat or inria");
  CHECK_NULLS(swiftgs_conventions_named, "inria", "name", &inria, "swiftgs_conventions");
  swiftgs_renderer_free(d.renderer);
}

/* Every function that takes a frame refuses it alike. */
static void refuse(swiftgs_renderer* renderer, const swiftgs_frame* frame, swiftgs_status status,
                   const char* part) {
  CHECK_ERROR(swiftgs_renderer_render_into(renderer, frame), status, part);
  CHECK_ERROR(swiftgs_renderer_render(renderer, frame), status, part);
  CHECK_ERROR(swiftgs_renderer_reserve(renderer, frame, NULL), status, part);
  CHECK_ERROR(swiftgs_renderer_set_views(renderer, frame), status, part);
}

void test_frame_errors(void) {
  struct drawing d;
  set_up(&d, small_renderer);
  const swiftgs_view valid = d.view;
  const swiftgs_frame whole = d.frame;
  const float* const expected = draw_plain(d.renderer, &d.camera);
  refuse(NULL, &whole, SWIFTGS_INVALID_ARGUMENT, "renderer is NULL");
  refuse(d.renderer, NULL, SWIFTGS_INVALID_ARGUMENT, "swiftgs_frame is NULL");
#define REFUSE(changes, part) \
  d.view = valid, d.frame = whole, changes, refuse(d.renderer, &d.frame, SWIFTGS_INVALID_ARGUMENT, part)
  REFUSE(d.frame.count = 0, "swiftgs_frame: count is 0, expected 1 to 65536 views");
  REFUSE(d.frame.count = 65537, "count is 65537");
  REFUSE(d.frame.views = NULL, "swiftgs_frame: views is NULL");
  REFUSE(d.frame.measure = 4, "measure is 4, expected a sum of 1 and 2");
  REFUSE(d.frame.size = 3, "swiftgs_frame: size is 3");
  REFUSE(d.view.size = 0, "swiftgs_view: size is 0");
  REFUSE(d.view.format = 5, "swiftgs_view: format is 5, expected 0 to 4");
  REFUSE(d.view.camera = NULL, "swiftgs_view: camera is NULL");
  REFUSE(d.view.colour.pitch = 4, "the pitch of colour is 4 bytes");
  REFUSE(d.view.colour.data = (char*)d.colour + 1, "colour aligned to 4 bytes");
  REFUSE((d.view.colour.data = NULL, d.view.over = 1), "colour to render over");
  const swiftgs_plane narrow = {d.colour, 8}, odd = {(char*)d.colour + 1, 4 * width};
  REFUSE(d.view.normal = narrow, "the pitch of normal is 8 bytes, expected at least 768");
  REFUSE(d.view.median_id = odd, "median_id aligned to 4 bytes");
  REFUSE(d.view.features = narrow, "a frame with features to say how many channels");
  REFUSE((d.view.features = narrow, d.view.feature_channels = 2), "the pitch of features is 8 bytes");
  REFUSE(d.view.conversion = 3, "swiftgs_view: conversion is 3, expected 0 to 2");
  REFUSE(d.view.left = 8, "x is 8, expected a multiple of 16");
  REFUSE(d.view.top = 16, "48 pixels along y from 16");
  REFUSE(d.view.width = -1, "-1 pixels along x");
  REFUSE(d.view.background[2] = NAN, "in channel 2, expected finite numbers");
  REFUSE(d.view.stored_depth = swiftgs_stored_orthographic(5, 5), "stored depths that are finite and differ");
  REFUSE(d.camera.fx = 0, "focal lengths of 1e-6 to 1e12 pixels");
#undef REFUSE
  d.camera = make_camera(width, height);

  /* 200 images of 65536 pixels a side have more tiles than a frame may have. They point to no planes. */
  enum { many = 200 };
  const swiftgs_camera vast = make_camera(65536, 65536);
  swiftgs_view views[many];
  for (int i = 0; i < many; ++i) views[i] = (swiftgs_view){.size = sizeof(valid), .camera = &vast};
  const swiftgs_frame vast_frame = make_frame(views, many);
  refuse(d.renderer, &vast_frame, SWIFTGS_CAPACITY_ERROR, "tiles in one frame: ");

  /* The renderer works on. */
  d.view = valid;
  CHECK(draws(&d, expected));
  swiftgs_renderer_free(d.renderer);
}
