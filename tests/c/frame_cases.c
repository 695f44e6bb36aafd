/* SPDX-License-Identifier: Apache-2.0 */

/* Frames: planes, formats, pitches, views, and what cannot be drawn. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "check.h"

enum { width = small_width, height = small_height, pixels = small_width * small_height };

static float* render_plain(swiftgs_renderer* renderer, const swiftgs_camera* camera) {
  float* const colour = make_memory(sizeof(float) * 3 * (size_t)camera->width * (size_t)camera->height);
  const swiftgs_view view = make_view(camera, colour);
  const swiftgs_frame frame = make_frame(&view, 1);
  CHECK_OK(swiftgs_renderer_render(renderer, &frame));
  return colour;
}

/* Whether an image is more than one colour. */
static bool shows_something(const float* colour) {
  float least = INFINITY, most = -INFINITY;
  for (int i = 0; i < 3 * pixels; ++i) least = fminf(least, colour[i]), most = fmaxf(most, colour[i]);
  return most - least > 0.2f;
}

void test_formats(void) {
  swiftgs_renderer* const renderer = make_renderer(small_renderer);
  const swiftgs_camera camera = make_camera(width, height);
  float* const rgb = render_plain(renderer, &camera);
  CHECK(shows_something(rgb));

  float* const rgba = make_memory(sizeof(float) * 4 * pixels);
  float* const alpha = make_memory(sizeof(float) * pixels);
  float* const depth = make_memory(sizeof(float) * pixels);
  uint16_t* const half = make_memory(sizeof(uint16_t) * 4 * pixels);
  uint8_t* const bytes = make_memory(4 * pixels);
  swiftgs_view view = make_view(&camera, rgba);
  view.format = SWIFTGS_RGBA_FLOAT;
  view.colour.pitch = 16 * width;
  view.alpha = (swiftgs_plane){alpha, 4 * width};
  view.depth = (swiftgs_plane){depth, 4 * width};
  const swiftgs_frame frame = make_frame(&view, 1);
  CHECK_OK(swiftgs_renderer_render_into(renderer, &frame));
  bool same = true, opaque = false, far = false;
  for (int i = 0; i < pixels; ++i) {
    same &= memcmp(rgba + 4 * i, rgb + 3 * i, 3 * sizeof(float)) == 0 && rgba[4 * i + 3] == alpha[i];
    opaque |= alpha[i] > 0.9f, far |= depth[i] > 1;
  }
  CHECK(same && opaque && far);

  view.format = SWIFTGS_RGBA_8;
  view.colour = (swiftgs_plane){bytes, 4 * width};
  CHECK_OK(swiftgs_renderer_render_into(renderer, &frame));
  for (int i = 0; i < 4 * pixels; ++i)
    same &= fabsf((float)bytes[i] - 255 * fminf(fmaxf(rgba[i], 0), 1)) < 0.51f;
  CHECK(same);

  /* 1.0 is 0x3c00 as a half; a pixel is near it where its float is. */
  view.format = SWIFTGS_RGBA_HALF;
  view.colour = (swiftgs_plane){half, 8 * width};
  CHECK_OK(swiftgs_renderer_render_into(renderer, &frame));
  for (int i = 0; i < 4 * pixels; ++i) {
    if (rgba[i] < 0.5f || rgba[i] >= 1) continue;
    const float found = ldexpf((float)(1024 + (half[i] & 1023)), (half[i] >> 10) - 25);
    same &= fabsf(found - rgba[i]) <= ldexpf(1, -12);
  }
  CHECK(same);

  /* Planes without colours. */
  memset(alpha, 0, sizeof(float) * pixels);
  view.colour.data = NULL;
  CHECK_OK(swiftgs_renderer_render_into(renderer, &frame));
  for (int i = 0; i < pixels; ++i) same &= alpha[i] == rgba[4 * i + 3];
  CHECK(same);

  free(rgb), free(rgba), free(alpha), free(depth), free(half), free(bytes);
  swiftgs_renderer_free(renderer);
}

void test_pitches(void) {
  swiftgs_renderer* const renderer = make_renderer(small_renderer);
  const swiftgs_camera camera = make_camera(width, height);
  float* const plain = render_plain(renderer, &camera);

  /* Bottom row first, with two floats between rows that nothing writes. */
  enum { row = 3 * width + 2 };
  float* const up = make_memory(sizeof(float) * row * height);
  for (int i = 0; i < row * height; ++i) up[i] = -7;
  swiftgs_view view = make_view(&camera, up + row * (height - 1));
  view.colour.pitch = -(int64_t)sizeof(float) * row;
  const swiftgs_frame frame = make_frame(&view, 1);
  CHECK_OK(swiftgs_renderer_render_into(renderer, &frame));
  for (int y = 0; y < height; ++y) {
    const float* const at = up + row * (height - 1 - y);
    CHECK(memcmp(at, plain + 3 * width * y, 3 * width * sizeof(float)) == 0);
    CHECK(at[row - 2] == -7 && at[row - 1] == -7);
  }
  free(plain), free(up);
  swiftgs_renderer_free(renderer);
}

void test_views(void) {
  swiftgs_renderer* const renderer = make_renderer(small_renderer);
  const swiftgs_camera near = make_camera(width, height);
  swiftgs_camera aside = make_camera(80, 40);
  aside.translation[0] += 0.3;
  float* const first = render_plain(renderer, &near);
  float* const second = render_plain(renderer, &aside);

  float* const together = make_memory(sizeof(float) * 3 * (pixels + 80 * 40));
  swiftgs_view views[2] = {make_view(&near, together), make_view(&aside, together + 3 * pixels)};
  swiftgs_frame frame = make_frame(views, 2);
  CHECK_OK(swiftgs_renderer_render_into(renderer, &frame));
  CHECK(memcmp(together, first, sizeof(float) * 3 * pixels) == 0);
  CHECK(memcmp(together + 3 * pixels, second, sizeof(float) * 3 * 80 * 40) == 0);

  /* Four parts of an image make it up. */
  memset(together, 0, sizeof(float) * 3 * pixels);
  swiftgs_view parts[4];
  for (int i = 0; i < 4; ++i) {
    const int left = i % 2 * 32, top = i / 2 * 16;
    parts[i] = make_view(&near, together + 3 * (top * width + left));
    parts[i].left = left, parts[i].top = top;
    parts[i].width = 32, parts[i].height = i / 2 == 0 ? 16 : height - 16;
  }
  frame = make_frame(parts, 4);
  CHECK_OK(swiftgs_renderer_render_into(renderer, &frame));
  CHECK(memcmp(together, first, sizeof(float) * 3 * pixels) == 0);
  free(first), free(second), free(together);
  swiftgs_renderer_free(renderer);
}

void test_over(void) {
  swiftgs_renderer* const renderer = make_renderer(small_renderer);
  const swiftgs_camera camera = make_camera(width, height);
  float* const on_colour = make_memory(sizeof(float) * 3 * pixels);
  float* const over = make_memory(sizeof(float) * 3 * pixels);
  swiftgs_view view = make_view(&camera, on_colour);
  const float background[3] = {0.25f, 0.5f, 4};
  memcpy(view.background, background, sizeof(background));
  const swiftgs_frame frame = make_frame(&view, 1);
  CHECK_OK(swiftgs_renderer_render_into(renderer, &frame));

  /* Over an image of the background's colour the result is the same. */
  for (int i = 0; i < 3 * pixels; ++i) over[i] = background[i % 3];
  view.colour.data = over, view.over = 1;
  memset(view.background, 0, sizeof(view.background));
  CHECK_OK(swiftgs_renderer_render_into(renderer, &frame));
  CHECK(memcmp(over, on_colour, sizeof(float) * 3 * pixels) == 0);

  float* const plain = render_plain(renderer, &camera);
  CHECK(memcmp(plain, over, sizeof(float) * 3 * pixels) != 0);
  free(on_colour), free(over), free(plain);
  swiftgs_renderer_free(renderer);
}

void test_occluder(void) {
  swiftgs_renderer* const renderer = make_renderer(small_renderer);
  const swiftgs_camera camera = make_camera(width, height);
  float* const plain = render_plain(renderer, &camera);
  float* const colour = make_memory(sizeof(float) * 3 * pixels);
  float* const occluder = make_memory(sizeof(float) * pixels);
  /* The left half is hidden by what is directly before the camera, the right one by nothing. */
  for (int i = 0; i < pixels; ++i) occluder[i] = i % width < width / 2 ? 0 : INFINITY;
  swiftgs_view view = make_view(&camera, colour);
  view.occluder = (swiftgs_plane){occluder, 4 * width};
  view.background[1] = 2;
  const swiftgs_frame frame = make_frame(&view, 1);
  CHECK_OK(swiftgs_renderer_render_into(renderer, &frame));
  bool hidden = true, seen = true;
  for (int i = 0; i < pixels; ++i) {
    const float* const at = colour + 3 * i;
    if (i % width < width / 2)
      hidden &= at[0] == 0 && at[1] == 2 && at[2] == 0;
    else
      seen &= at[0] == plain[3 * i] && at[2] == plain[3 * i + 2];
  }
  CHECK(hidden && seen);
  free(plain), free(colour), free(occluder);
  swiftgs_renderer_free(renderer);
}

/* Alpha of a pixel whose centre a Gaussian of opacity 1/2 lies on, 2 in front of the camera. */
static float alpha_at(float x, double cx, float size, const swiftgs_conventions* conventions) {
  const float mean[3] = {x, 0, 2}, scale[3] = {size, size, size}, rotation[4] = {1, 0, 0, 0}, half = 0.5f;
  swiftgs_gaussians one = {.size = sizeof(one), .count = 1};
  one.means.data = one.sh0.data = mean, one.scales.data = scale, one.rotations.data = rotation;
  one.opacities.data = &half;
  swiftgs_scene* scene = NULL;
  swiftgs_renderer* renderer = NULL;
  CHECK_OK(swiftgs_scene_from_arrays(&one, &scene));
  CHECK_OK(swiftgs_renderer_create("serial/early/per-pixel/ellipse", NULL, &renderer));
  CHECK_OK(swiftgs_renderer_set_scene(renderer, scene));
  const swiftgs_camera camera = {.size = sizeof(camera),
                                 .width = 1,
                                 .height = 1,
                                 .rotation = {1, 0, 0, 0, 1, 0, 0, 0, 1},
                                 .fx = 1,
                                 .fy = 1,
                                 .cx = cx,
                                 .cy = 0.5};
  float alpha = -1;
  const swiftgs_view view = {
      .size = sizeof(view), .camera = &camera, .conventions = conventions, .alpha = {&alpha, sizeof(alpha)}};
  const swiftgs_frame frame = make_frame(&view, 1);
  CHECK_OK(swiftgs_renderer_render(renderer, &frame));
  swiftgs_renderer_free(renderer);
  swiftgs_scene_free(scene);
  return alpha;
}

static float alpha_of_one(const swiftgs_conventions* conventions) {
  return alpha_at(0, 0.5, 0.01f, conventions);
}

void test_each_convention(void) {
  swiftgs_conventions gsplat = {.size = sizeof(gsplat)};
  CHECK_OK(swiftgs_conventions_named("gsplat", &gsplat));
  CHECK(alpha_of_one(&gsplat) == 0.5f);
  swiftgs_conventions c = gsplat;
  c.far_plane = 1;
  CHECK(alpha_of_one(&c) == 0);
  c = gsplat, c.near_plane = 2;
  CHECK(alpha_of_one(&c) == 0.5f);
  c.cull_at_near = 1;
  CHECK(alpha_of_one(&c) == 0);
  c = gsplat, c.alpha_min = 0.6f;
  CHECK(alpha_of_one(&c) == 0);
  c = gsplat, c.alpha_max = 0.25f;
  CHECK(alpha_of_one(&c) == 0.25f);
  c = gsplat, c.stop = 0.5f;
  CHECK(alpha_of_one(&c) == 0);
  c.stop_at_equal = 0;
  CHECK(alpha_of_one(&c) == 0.5f);
  c = gsplat, c.antialiased = 1;
  CHECK(alpha_of_one(&c) < 0.25f); /* a splat much smaller than a pixel */
  c.min_compensation = 1;
  CHECK(alpha_of_one(&c) == 0.5f);
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
  CHECK(gsplat.near_plane == 0.01f && gsplat.stop_at_equal == 1 &&
        gsplat.clamp == SWIFTGS_CLAMP_AROUND_IMAGE && gsplat.footprint == SWIFTGS_FOOTPRINT_ALPHA &&
        gsplat.blur == 0.3f && gsplat.alpha_max == 0.99f && gsplat.depth == SWIFTGS_DEPTH_OF_LENS);
  CHECK(gsplat.far_plane == 1e10f && gsplat.cull_at_near == 0 && gsplat.antialiased == 0 &&
        gsplat.min_compensation == 2.5e-5f && gsplat.alpha_min == 1.0f / 255 && gsplat.stop == 1e-4f);
  CHECK(inria.near_plane == 0.2f && inria.cull_at_near == 1 && inria.stop_at_equal == 0 &&
        isinf(inria.far_plane) && inria.clamp == SWIFTGS_CLAMP_AROUND_CENTRE &&
        inria.footprint == SWIFTGS_FOOTPRINT_THREE_SIGMA_SQUARE);

  swiftgs_renderer* const renderer = make_renderer(small_renderer);
  const swiftgs_camera camera = make_camera(width, height);
  float* const plain = render_plain(renderer, &camera);
  float* const colour = make_memory(sizeof(float) * 3 * pixels);
  swiftgs_view view = make_view(&camera, colour);
  const swiftgs_frame frame = make_frame(&view, 1);
  view.conventions = &gsplat;
  CHECK_OK(swiftgs_renderer_render_into(renderer, &frame));
  CHECK(memcmp(colour, plain, sizeof(float) * 3 * pixels) == 0);
  gsplat.blur = 1;
  CHECK_OK(swiftgs_renderer_render_into(renderer, &frame));
  CHECK(memcmp(colour, plain, sizeof(float) * 3 * pixels) != 0);

  gsplat.blur = -1;
  CHECK_ERROR(swiftgs_renderer_render_into(renderer, &frame), SWIFTGS_INVALID_ARGUMENT,
              "a blur of 0 or more");
  gsplat.blur = 0, gsplat.clamp = 2;
  CHECK_ERROR(swiftgs_renderer_render_into(renderer, &frame), SWIFTGS_INVALID_ARGUMENT,
              "swiftgs_conventions: clamp is 2, expected 0 to 1");
  gsplat.clamp = 0, gsplat.footprint = -1;
  CHECK_ERROR(swiftgs_renderer_render_into(renderer, &frame), SWIFTGS_INVALID_ARGUMENT, "footprint is -1");
  gsplat.footprint = 0, gsplat.depth = 3;
  CHECK_ERROR(swiftgs_renderer_render_into(renderer, &frame), SWIFTGS_INVALID_ARGUMENT,
              "swiftgs_conventions: depth is 3, expected 0 to 2");
  gsplat.size = 52; /* of a program that is older than this member */
  CHECK_OK(swiftgs_renderer_render_into(renderer, &frame));
  gsplat.size = 1;
  CHECK_ERROR(swiftgs_renderer_render_into(renderer, &frame), SWIFTGS_INVALID_ARGUMENT,
              "swiftgs_conventions: size is 1");
  CHECK_ERROR(swiftgs_conventions_named("gsplat", &gsplat), SWIFTGS_INVALID_ARGUMENT, "size is 1");
  CHECK_ERROR(swiftgs_conventions_named("other", &inria), SWIFTGS_INVALID_ARGUMENT,
              "expected gsplat or inria");
  CHECK_ERROR(swiftgs_conventions_named(NULL, &inria), SWIFTGS_INVALID_ARGUMENT, "name is NULL");
  CHECK_ERROR(swiftgs_conventions_named("inria", NULL), SWIFTGS_INVALID_ARGUMENT,
              "swiftgs_conventions is NULL");
  free(plain), free(colour);
  swiftgs_renderer_free(renderer);
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
  swiftgs_renderer* const renderer = make_renderer(small_renderer);
  swiftgs_camera camera = make_camera(width, height);
  float* const colour = make_memory(sizeof(float) * 3 * pixels);
  const swiftgs_view valid = make_view(&camera, colour);
  swiftgs_view view = valid;
  swiftgs_frame frame = make_frame(&view, 1);
  refuse(NULL, &frame, SWIFTGS_INVALID_ARGUMENT, "renderer is NULL");
  refuse(renderer, NULL, SWIFTGS_INVALID_ARGUMENT, "swiftgs_frame is NULL");
  frame.count = 0;
  refuse(renderer, &frame, SWIFTGS_INVALID_ARGUMENT, "swiftgs_frame: count is 0, expected 1 to 65536 views");
  frame.count = 65537;
  refuse(renderer, &frame, SWIFTGS_INVALID_ARGUMENT, "count is 65537");
  frame.count = 1, frame.views = NULL;
  refuse(renderer, &frame, SWIFTGS_INVALID_ARGUMENT, "swiftgs_frame: views is NULL");
  frame.views = &view, frame.measure = 4;
  refuse(renderer, &frame, SWIFTGS_INVALID_ARGUMENT, "measure is 4, expected a sum of 1 and 2");
  frame.measure = 0, frame.size = 3;
  refuse(renderer, &frame, SWIFTGS_INVALID_ARGUMENT, "swiftgs_frame: size is 3");
  frame.size = sizeof(frame);

  view.size = 0;
  refuse(renderer, &frame, SWIFTGS_INVALID_ARGUMENT, "swiftgs_view: size is 0");
  view = valid, view.format = 4;
  refuse(renderer, &frame, SWIFTGS_INVALID_ARGUMENT, "swiftgs_view: format is 4, expected 0 to 3");
  view = valid, view.camera = NULL;
  refuse(renderer, &frame, SWIFTGS_INVALID_ARGUMENT, "swiftgs_view: camera is NULL");
  view = valid, view.colour.pitch = 4;
  refuse(renderer, &frame, SWIFTGS_INVALID_ARGUMENT, "the pitch of colour is 4 bytes");
  view = valid, view.colour.data = (char*)colour + 1;
  refuse(renderer, &frame, SWIFTGS_INVALID_ARGUMENT, "colour aligned to 4 bytes");
  view = valid, view.colour.data = NULL, view.over = 1;
  refuse(renderer, &frame, SWIFTGS_INVALID_ARGUMENT, "colour to render over");
  view = valid, view.left = 8;
  refuse(renderer, &frame, SWIFTGS_INVALID_ARGUMENT, "x is 8, expected a multiple of 16");
  view = valid, view.top = 16;
  refuse(renderer, &frame, SWIFTGS_INVALID_ARGUMENT, "48 pixels along y from 16");
  view = valid, view.width = -1;
  refuse(renderer, &frame, SWIFTGS_INVALID_ARGUMENT, "-1 pixels along x");
  view = valid, view.background[2] = NAN;
  refuse(renderer, &frame, SWIFTGS_INVALID_ARGUMENT, "in channel 2, expected finite numbers");
  view = valid, camera.fx = 0;
  refuse(renderer, &frame, SWIFTGS_INVALID_ARGUMENT, "focal lengths of 1e-6 to 1e12 pixels");
  camera.fx = camera.fy, camera.rotation[0] = 2;
  refuse(renderer, &frame, SWIFTGS_INVALID_ARGUMENT, "a rotation with orthonormal rows");
  camera = make_camera(width, height);

  /* 200 images of 65536 pixels a side have more tiles than a frame may have. They point to no planes. */
  enum { many = 200 };
  const swiftgs_camera vast = make_camera(65536, 65536);
  swiftgs_view* const views = make_memory(many * sizeof(*views));
  for (int i = 0; i < many; ++i) views[i] = (swiftgs_view){.size = sizeof(view), .camera = &vast};
  frame = make_frame(views, many);
  refuse(renderer, &frame, SWIFTGS_CAPACITY_ERROR, "tiles in one frame: ");

  /* The renderer works on. */
  frame = make_frame(&view, 1);
  view = valid;
  CHECK_OK(swiftgs_renderer_render_into(renderer, &frame));
  CHECK(shows_something(colour));
  free(views), free(colour);
  swiftgs_renderer_free(renderer);
}
