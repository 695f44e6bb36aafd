// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Frames of parts of an image against frames of the image.

#include <cmath>
#include <cstddef>
#include <vector>

#include <doctest/doctest.h>

#include <swiftgs/project/project.hpp>
#include <swiftgs/renderer.hpp>

#include "policies/random_splats.hpp"
#include "policies/views.hpp"

namespace swiftgs::test {

/// A rectangle of an image. @units{pixels}
struct Part {
  FirstPixel first;
  int width, height;
};

/// The rectangles that an image is cut into at these columns and rows.
inline std::vector<Part> cut(int width, int height, std::vector<int> columns, std::vector<int> rows) {
  columns.push_back(width), rows.push_back(height);
  std::vector<Part> parts;
  for (std::size_t row = 0; row + 1 < rows.size(); ++row)
    for (std::size_t column = 0; column + 1 < columns.size(); ++column)
      parts.push_back(
          {{columns[column], rows[row]}, columns[column + 1] - columns[column], rows[row + 1] - rows[row]});
  return parts;
}

/// The first column or row of each part of an image that is cut evenly.
inline std::vector<int> every(int size, int step) {
  std::vector<int> begins;
  for (int begin = 0; begin < size; begin += step) begins.push_back(begin);
  return begins;
}

/// Checks that the parts of an image have its bytes, drawn in one frame and in a frame each, counting and
/// not counting.
template <class B>
void check_parts(BoundRenderer<B>& renderer, const SceneView& scene, const AskedView& asked,
                 const std::vector<Part>& parts, bool count = true) {
  const PlanesMemory whole = draw_one(renderer, scene, asked, count);
  const RasterCounts counts = renderer.statistics().raster;

  for (const bool together : {true, false}) {
    CAPTURE(together);
    PlanesMemory memory = asked.memory();
    PlacedFrame<B> place(renderer.backend(), memory);
    std::vector<View> views;
    for (const Part& part : parts)
      views.push_back(
          make_view(asked.camera, asked.conventions,
                    asked.frame(place.frame()).part(part.first.x, part.first.y, part.width, part.height),
                    asked.background, part.first));
    RasterCounts sum;
    const auto render = [&](Span<const View> some) {
      renderer.render_into(scene, some, Measures{.count = count});
      sum += renderer.statistics().raster;
    };
    if (together) {
      render(span_of(views));
    } else {
      for (const View& view : views) render({&view, 1});
    }
    place.finish(renderer.backend());
    CHECK((memory.bytes == whole.bytes));
    CHECK(memory.kept_to_its_rows());
    CHECK(sum.rows_visited == counts.rows_visited);
    CHECK(sum.contributing_pairs == counts.contributing_pairs);
    CHECK(sum.pixels_stopped == counts.pixels_stopped);
  }
}

/// A Gaussian whose splat ends near the left or the upper border of the second tile.
inline Gaussian ends_near_a_border(Random& random, const ViewConstants& v) {
  Gaussian g;
  const double z = random.in(1, 5), angle = random.in(0, 6.2831853);
  const double size = random.scale(0.05, 30), thin = random.scale(1e-4, 1);
  g.scale = vec3(float(size), float(size * thin), float(size * thin));
  g.rotation = {float(std::cos(angle / 2)), 0, 0, float(std::sin(angle / 2))};
  g.opacity = float(random.scale(1.0 / 250, 0.1));
  g.mean = vec3(0, 0, float(z));
  // Its right or its lower end lies at the first centre of a tile, but for a part of a pixel.
  const bool right = random.bits() % 2;
  const double beside = random.scale(1e-6, 1e-2) * (random.bits() % 2 ? 1 : -1);
  const double end = 16.5 + beside, across = std::floor(random.in(0, 32)) + 0.5;
  for (int step = 0; step < 5; ++step) {  // its shape changes as it moves
    const SplatShape shape = project_shape(v, g).shape;
    const double tilt = -double(shape.l1) / double(shape.l0), height = double(EllipseExtent(shape).height);
    const double below =
        tilt * height * height / double(EllipseExtent(shape).width);  // y of the rightmost point
    const double x = right ? end - double(EllipseExtent(shape).width) : across - tilt * height;
    const double y = right ? across - below : end - height;
    g.mean = vec3(float((x - v.cx) / v.fx * z), float((y - v.cy) / v.fy * z), float(z));
  }
  return g;
}

/// Of the Gaussians that end near a border.
inline Camera bordered_camera() { return forward_camera(48, 48); }

/// `check_parts` of images cut in several ways.
template <class B>
void check_bands(BoundRenderer<B>& renderer, const SceneView& scene) {
  for (const AskedView& asked : different_views()) {
    const int width = asked.camera.width, height = asked.camera.height;
    CAPTURE(width);
    const std::vector<int> columns = every(width, default_tile_side), rows = every(height, default_tile_side);
    check_parts(renderer, scene, asked, cut(width, height, {0}, rows));
    check_parts(renderer, scene, asked, cut(width, height, columns, {0}));
    if (width < 64) continue;
    check_parts(renderer, scene, asked, cut(width, height, {0, 16, 48}, {0, 32}));
    check_parts(renderer, scene, asked, cut(width, height, columns, rows));
  }
}

}  // namespace swiftgs::test
