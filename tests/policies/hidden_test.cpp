// SPDX-License-Identifier: Apache-2.0

// How many tile intersections an occluder hides, on every backend.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include "policies/image_parts.hpp"
#include "policies/rasterizers.hpp"
#include "policies/views.hpp"

namespace swiftgs::test::hidden_test {

namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();
constexpr float not_a_number = std::numeric_limits<float>::quiet_NaN();
constexpr int width = 70, height = 45;

/// A slope of depths. Of the upper left tiles, one has a pixel that hides nothing, one only such pixels, and
/// one is before all splats.
std::vector<float> slope() {
  std::vector<float> depths;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      depths.push_back(x == 3 && y == 9              ? not_a_number
                       : x >= 16 && x < 32 && y < 16 ? infinity
                       : x >= 32 && x < 48 && y < 16 ? -infinity
                                                     : 1.5f + 0.07f * float(x) + 0.03f * float(y));
  return depths;
}

struct OccludedView {
  std::vector<float> depths;  ///< none without an occluder
  StoredDepth stored{};
  Camera camera = forward_camera(width, height);
};

/// Pixel by pixel, by the lists of the last frame.
template <class B>
std::size_t brute_force(BoundRenderer<B>& renderer, const std::vector<View>& views,
                        const std::vector<OccludedView>& asked) {
  const auto& backend = renderer.backend();
  const HostLists lists = host_lists(backend, renderer.lists());
  const std::vector<float> depths = to_host(backend, renderer.splats().view().depths);
  const FrameTiles& tiles = renderer.tiles();
  std::size_t hidden = 0, row_of_tiles = 0;
  for (std::size_t v = 0; v < views.size(); ++v) {
    const int rows = (views[v].frame.height + tiles.side - 1) / tiles.side;
    for (int row = 0; row < rows; ++row, ++row_of_tiles)
      for (std::uint32_t column = 0; column < tiles.columns; ++column) {
        const TileRange range = lists.ranges[row_of_tiles * tiles.columns + column];
        for (std::uint32_t at = range.begin; at < range.end; ++at) {
          bool everywhere = !asked[v].depths.empty();
          for (int y = row * tiles.side; y < std::min((row + 1) * tiles.side, height) && everywhere; ++y)
            for (int x = int(column) * tiles.side; x < std::min(int(column + 1) * tiles.side, width); ++x)
              everywhere =
                  everywhere &&
                  depths[lists.ids[at]] >= asked[v].stored.depth(asked[v].depths[std::size_t(y * width + x)]);
          hidden += everywhere;
        }
      }
  }
  return hidden;
}

/// What `B` counts in a frame of the views, checked against `brute_force`.
template <class B>
Statistics counted(BoundRenderer<B>& renderer, const SceneView& scene, const std::vector<OccludedView>& asked,
                   int side = default_tile_side) {
  const auto& backend = renderer.backend();
  using Buffer = decltype(to_backend(backend, asked[0].depths));
  std::vector<Buffer> occluders;
  std::vector<PlanesOn<B>> colours;
  std::vector<View> views;
  for (const OccludedView& view : asked) {
    occluders.push_back(to_backend(backend, view.depths));
    FrameView frame = colours.emplace_back(backend, width, height, Outputs()).view();
    if (!view.depths.empty()) frame.occluder = {occluders.back().data(), 4 * width};
    frame.stored_depth = view.stored;
    views.push_back(make_view(view.camera, {}, frame));
    views.back().grid = TileGrid::covering(width, height, side);
  }
  renderer.render_into(scene, span_of(views), {.count = true});
  const Statistics statistics = renderer.statistics();
  CHECK(statistics.intersections_hidden == brute_force(renderer, views, asked));
  renderer.render_into(scene, span_of(views));
  CHECK(renderer.statistics().intersections_hidden == 0);
  return statistics;
}

}  // namespace

SWIFTGS_CONTRACT("hidden: counted are the intersections that no pixel of their tile can show") {
  Usual<B> renderer(std::move(backend));
  const auto scene = renderer.backend().upload(random_scene(800, 0, 9));
  const OccludedView sloped{slope()}, plain{{}}, other{slope(), {}, turned_camera(width, height, 0.2, 0.4)};
  std::size_t one = 0;
  for (const int side : {16, 32, 128}) {
    CAPTURE(side);
    const Statistics statistics = counted(renderer, scene.view(), {sloped}, side);
    if (side == 16) one = statistics.intersections_hidden;
    CHECK((side == 128 ? statistics.intersections_hidden == 0 : statistics.intersections_hidden > 0));
    CHECK(statistics.intersections_hidden < statistics.intersections);
  }
  const std::size_t two = counted(renderer, scene.view(), {other}).intersections_hidden;
  CHECK(two != one);
  CHECK(counted(renderer, scene.view(), {sloped, plain, other}).intersections_hidden == one + two);
  CHECK(counted(renderer, scene.view(), {plain, plain}).intersections_hidden == 0);
}

SWIFTGS_CONTRACT("hidden: a depth buffer taken for depths hides all and its stored depths do not") {
  Usual<B> renderer(std::move(backend));
  Scene behind_1 = random_scene(1500, 0, 9);
  for (vec3& mean : behind_1.means) mean.z = std::max(mean.z, 1.1f);
  const auto scene = renderer.backend().upload(behind_1);
  const StoredDepth stored = StoredDepth::perspective(0.1, infinity);
  std::vector<float> buffer;  // of surfaces at 5 and more
  for (int i = 0; i < width * height; ++i) buffer.push_back(float(1 - 0.1 / (5 + i % 7)));
  const Statistics raw = counted(renderer, scene.view(), {{buffer}});
  CHECK(raw.intersections > 1000);
  CHECK(raw.intersections_hidden == raw.intersections);
  CHECK(raw.nearly_all_hidden());
  CHECK_FALSE(Statistics().nearly_all_hidden());
  CHECK_FALSE(Statistics{.intersections = 1000, .intersections_hidden = 989}.nearly_all_hidden());
  CHECK(Statistics{.intersections = 1000, .intersections_hidden = 990}.nearly_all_hidden());
  CHECK(raw.raster.contributing_pairs == 0);
  const Statistics meant = counted(renderer, scene.view(), {{buffer, stored}});
  CHECK(meant.intersections == raw.intersections);
  CHECK(meant.intersections_hidden > 0);
  CHECK(meant.intersections_hidden < raw.intersections / 2);
  CHECK_FALSE(meant.nearly_all_hidden());
}

SWIFTGS_CONTRACT("hidden: a splat at the depth of the occluder is hidden") {
  Usual<B> renderer(std::move(backend));
  const Scene scene = random_scene(300, 0, 9);
  const auto uploaded = renderer.backend().upload(scene);
  counted(renderer, uploaded.view(), {{slope()}});
  const std::vector<float> depths = to_host(renderer.backend(), renderer.splats().view().depths);
  const float depth = depths[depths.size() / 2];
  const auto hidden_by = [&](float surface) {
    const std::vector<float> flat(width * height, surface);
    return counted(renderer, uploaded.view(), {{flat}}).intersections_hidden;
  };
  CHECK(hidden_by(depth) > hidden_by(std::nextafter(depth, infinity)));
}

SWIFTGS_CONTRACT("hidden: counts of an image's parts are those of the image") {
  Usual<B> renderer(std::move(backend));
  const auto scene = renderer.backend().upload(random_scene(400, 0, 9));
  const std::vector<float> all = slope();
  const auto occluder = to_backend(renderer.backend(), all);
  PlanesOn<B> colour(renderer.backend(), width, height, {});
  FrameView frame = colour.view();
  frame.occluder = {occluder.data(), 4 * width};
  const Camera camera = forward_camera(width, height);
  std::size_t sum = 0;
  for (const Part& part : cut(width, height, {0, 32}, {0, 16})) {
    const View view = make_view(camera, {}, frame.part(part.first.x, part.first.y, part.width, part.height),
                                vec3(0), part.first);
    renderer.render_into(scene.view(), {&view, 1}, {.count = true});
    sum += renderer.statistics().intersections_hidden;
  }
  CHECK(sum > 0);
  CHECK(sum == counted(renderer, scene.view(), {{all}}).intersections_hidden);
}

}  // namespace swiftgs::test::hidden_test
