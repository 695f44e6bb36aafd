// SPDX-License-Identifier: Apache-2.0

#include <cstddef>
#include <memory>
#include <string_view>
#include <vector>

#include <text.hpp>

#include <swiftgs/c/view.h>
#include <swiftgs/conventions.hpp>
#include <swiftgs/frame.hpp>
#include <swiftgs/frame/views.hpp>
#include <swiftgs/io/image.hpp>

#include "error.hpp"
#include "objects.hpp"
#include "structs.hpp"

namespace swiftgs::c {
namespace {

static_assert(int(PixelFormat::rgb_float) == SWIFTGS_RGB_FLOAT &&
              int(PixelFormat::rgba_float) == SWIFTGS_RGBA_FLOAT &&
              int(PixelFormat::rgba_half) == SWIFTGS_RGBA_HALF &&
              int(PixelFormat::rgba_8) == SWIFTGS_RGBA_8 && int(PixelFormat::bgra_8) == SWIFTGS_BGRA_8);
static_assert(int(Conversion::as_is) == SWIFTGS_CONVERT_NOTHING &&
              int(Conversion::srgb_to_linear) == SWIFTGS_CONVERT_SRGB_TO_LINEAR &&
              int(Conversion::linear_to_srgb) == SWIFTGS_CONVERT_LINEAR_TO_SRGB);
static_assert(int(Conventions::JacobianClamp::around_image) == SWIFTGS_CLAMP_AROUND_IMAGE &&
              int(Conventions::JacobianClamp::around_centre) == SWIFTGS_CLAMP_AROUND_CENTRE &&
              int(Conventions::Footprint::alpha) == SWIFTGS_FOOTPRINT_ALPHA &&
              int(Conventions::Footprint::three_sigma_square) == SWIFTGS_FOOTPRINT_THREE_SIGMA_SQUARE &&
              int(Conventions::Footprint::three_sigma_ellipse) == SWIFTGS_FOOTPRINT_THREE_SIGMA_ELLIPSE &&
              int(Conventions::Depth::of_lens) == SWIFTGS_DEPTH_OF_LENS &&
              int(Conventions::Depth::z) == SWIFTGS_DEPTH_Z &&
              int(Conventions::Depth::distance) == SWIFTGS_DEPTH_DISTANCE &&
              int(Conventions::DepthAt::centre) == SWIFTGS_DEPTH_AT_CENTRE &&
              int(Conventions::DepthAt::ray) == SWIFTGS_DEPTH_AT_RAY && no_gaussian == SWIFTGS_NOTHING);

constexpr int of_scene = SWIFTGS_OF_SCENE;

swiftgs_conventions to_struct(const Conventions& from) {
  swiftgs_conventions to{};
  to.near_plane = from.near_plane, to.cull_at_near = from.cull_at_near, to.far_plane = from.far_plane;
  to.clamp = int(from.clamp);
  to.blur = from.blur.value_or(of_scene);
  to.antialiased = from.antialiased ? int(*from.antialiased) : of_scene;
  to.order = from.order ? int(*from.order) : of_scene;
  to.colours = from.colours ? int(*from.colours) : of_scene;
  to.min_compensation = from.min_compensation;
  to.alpha_min = from.alpha_min, to.alpha_max = from.alpha_max;
  to.stop = from.stop, to.stop_at_equal = from.stop_at_equal;
  to.footprint = int(from.footprint);
  to.depth = int(from.depth);
  to.depth_at = int(from.depth_at);
  to.first_alpha = from.first_alpha;
  return to;
}

Conventions to_conventions(const swiftgs_conventions* given) {
  if (!given) return Conventions::gsplat();
  const swiftgs_conventions from =
      read_struct(given, "swiftgs_conventions", to_struct(Conventions::gsplat()));
  require_choice(from.clamp, 2, "swiftgs_conventions: clamp");
  require_choice(from.footprint, 3, "swiftgs_conventions: footprint");
  require_choice(from.depth, 3, "swiftgs_conventions: depth");
  require_choice(from.depth_at, 2, "swiftgs_conventions: depth_at");
  if (from.order != of_scene) require_choice(from.order, 2, "swiftgs_conventions: order");
  if (from.colours != of_scene) require_choice(from.colours, 2, "swiftgs_conventions: colours");
  Conventions to;
  to.near_plane = from.near_plane, to.cull_at_near = from.cull_at_near != 0, to.far_plane = from.far_plane;
  to.clamp = Conventions::JacobianClamp(from.clamp);
  if (from.blur != of_scene) to.blur = from.blur;
  if (from.antialiased != of_scene) to.antialiased = from.antialiased != 0;
  if (from.order != of_scene) to.order = SplatOrder(from.order);
  if (from.colours != of_scene) to.colours = ColourSpace(from.colours);
  to.min_compensation = from.min_compensation;
  to.alpha_min = from.alpha_min, to.alpha_max = from.alpha_max;
  to.stop = from.stop, to.stop_at_equal = from.stop_at_equal != 0;
  to.footprint = Conventions::Footprint(from.footprint);
  to.depth = Conventions::Depth(from.depth);
  to.depth_at = Conventions::DepthAt(from.depth_at);
  to.first_alpha = from.first_alpha;
  return to;
}

View to_view(const swiftgs_view& from) {
  require_choice(from.format, format_count, "swiftgs_view: format");
  require_choice(from.conversion, 3, "swiftgs_view: conversion");
  require_pointer(from.camera, "swiftgs_view: camera");
  const Camera camera = to_camera(from.camera);
  FrameView frame;
  frame.width = from.width != 0 ? from.width : camera.width;
  frame.height = from.height != 0 ? from.height : camera.height;
  frame.format = PixelFormat(from.format);
  set_planes(frame, from);
  frame.occluder = to_plane<const float>(from.occluder);
  if (const auto& by = from.stored_depth; by.p != 0 || by.q != 0 || by.r != 0 || by.s != 0)
    frame.stored_depth = {by.p, by.q, by.r, by.s};
  frame.over = from.over != 0, frame.conversion = Conversion(from.conversion);
  const vec3 background(from.background[0], from.background[1], from.background[2]);
  View view = make_view(camera, to_conventions(from.conventions), frame, background, {from.left, from.top});
  view.shows.first = from.first_shown;
  if (from.shown_count != 0) view.shows.count = from.shown_count;
  return view;
}

}  // namespace

void read_views(const swiftgs_frame& frame, std::vector<View>& views) {
  if (frame.count < 1 || frame.count > max_views)
    refuse("swiftgs_frame: count is ", frame.count, ", expected 1 to ", max_views, " views");
  require_pointer(frame.views, "swiftgs_frame: views");
  views.clear();
  for_each_struct(frame.views, frame.count, "swiftgs_view",
                  [&](const swiftgs_view& view) { views.push_back(to_view(view)); });
}

}  // namespace swiftgs::c

using namespace swiftgs::c;

extern "C" swiftgs_status swiftgs_conventions_named(const char* name, swiftgs_conventions* conventions) {
  return guarded([&] {
    require_pointer(name, "name");
    write_struct(conventions, to_struct(swiftgs::conventions_named(name)), "swiftgs_conventions");
  });
}

struct swiftgs_picture {
  swiftgs::Image image;
};

namespace swiftgs::c {
namespace {

/// A view to write, and the background behind it.
struct Picture {
  FrameView view;
  vec3 background;
};

Picture read_picture(const swiftgs_image* image) {
  const swiftgs_image from = read_struct(image, "swiftgs_image");
  require_pointer(from.colour.data, "swiftgs_image: colour");
  require_choice(from.format, format_count, "swiftgs_image: format");
  require_zero(from.reserved, "swiftgs_image");
  FrameView view{.width = from.width, .height = from.height, .format = PixelFormat(from.format)};
  set_planes(view, from);
  view.over = from.over != 0;
  return {view, vec3(from.background[0], from.background[1], from.background[2])};
}

void write(std::string_view path, const Picture& picture) {
  if (io::has_ending(path, ".png")) return write_png(path, picture.view, picture.background);
  if (io::has_ending(path, ".pfm")) return write_pfm(path, picture.view);
  if (io::has_ending(path, ".exr")) return write_exr(path, picture.view);
  refuse(path, ": expected a name that ends in .png, .pfm or .exr");
}

}  // namespace
}  // namespace swiftgs::c

using namespace swiftgs::c;

extern "C" {

swiftgs_status swiftgs_image_write(const char* path, const swiftgs_image* image) {
  return guarded([&] {
    require_pointer(path, "path");
    write(path, read_picture(image));
  });
}

swiftgs_status swiftgs_png_encode(const swiftgs_image* image, swiftgs_take_bytes take, void* context) {
  return guarded([&] {
    if (!take) refuse("take is NULL, expected a function");
    const Picture picture = read_picture(image);
    const auto bytes = swiftgs::encode_png(picture.view, picture.background);
    take(context, bytes.data(), bytes.size());
  });
}

swiftgs_status swiftgs_picture_read(const char* path, swiftgs_picture** picture) {
  return guarded([&] {
    require_pointer(path, "path");
    require_pointer(picture, "picture");
    *picture = std::make_unique<swiftgs_picture>(swiftgs_picture{swiftgs::read_image(path)}).release();
  });
}

swiftgs_status swiftgs_picture_get(const swiftgs_picture* picture, swiftgs_pixels* pixels) {
  return guarded([&] {
    require_pointer(picture, "picture");
    const swiftgs::Image& image = picture->image;
    write_struct(pixels, {0, image.width, image.height, image.channels, image.pixels.data()},
                 "swiftgs_pixels");
  });
}

void swiftgs_picture_free(swiftgs_picture* picture) { delete picture; }

}  // extern "C"
