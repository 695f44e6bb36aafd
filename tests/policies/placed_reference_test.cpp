// SPDX-License-Identifier: Apache-2.0

// Frames of placed scenes, against the reference.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include <doctest/doctest.h>

#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/edit/all.hpp>

#include "policies/hooked.hpp"
#include "policies/lenses.hpp"
#include "policies/placed_list.hpp"
#include "policies/planes.hpp"
#include "policies/rasterizers.hpp"
#include "policies/views.hpp"

namespace swiftgs::test::placed_reference_test {

namespace {

constexpr int channels = 4;

Similarity pose_of(std::uint64_t seed, double scale, dvec3 to) {
  Random random(seed);
  return pose_of(random, scale, to);
}

Placed moved(Placed placed, dvec3 by) {
  placed.pose.translation += by;
  return placed;
}

/// Some of scale 1e-3 to 1e3, one where it stands by itself, one clipped and tinted, and one empty.
List list_of_scales(const Scene& each) {
  Scene none;
  none.feature_channels = each.feature_channels;
  const Placed small = placed_by(each, pose_of(1, 1e-3, dvec3(0.3, -0.2, 0.7)));
  const Placed large = placed_by(each, pose_of(2, 1e3, dvec3(-5, 2, 40)));
  Placed faint = placed_by(each, pose_of(3, 0.7, dvec3(0.1, 0.2, 1)), 0.3f);
  faint.tint = {vec3(1, 0.5f, 0.25f), 0.625f};
  faint.clip = Clip::sphere(faint.scene.means[0], 9), faint.clip.half_space_count = 1;
  const vec3 border = faint.scene.means[1];
  faint.clip.half_spaces[0] = vec4(0.3f, -1, 0.2f, border.y - 0.3f * border.x - 0.2f * border.z);
  return {moved(small, dvec3(0.2, 0.1, 0.3)),
          {each, {}, 0.6f},
          {none},
          moved(large, dvec3(-0.3, 0.1, 0.05)),
          moved(faint, dvec3(0, -0.2, -0.2)),
          placed_by(each, pose_of(4, 30, dvec3(9, 0.1, 0)))};
}

ReferencePlanes reference_of(const List& list, const Camera& camera, const Conventions& conventions,
                             const std::vector<float>& occluder = {}) {
  const std::vector<ReferenceScene> scenes = for_reference(list);
  return render_reference_planes(span_of(scenes), camera, conventions, 0, span_of(occluder));
}

/// Rounding alone reaches half of it.
template <class B>
constexpr double slack = on_host<B> ? 1 : 4;
template <class B>
PlaneBounds usual_bounds(double times = 1) {
  const double loose = slack<B> * times;
  return {.sum = 1.5e-5 * loose,
          .mean = 6e-5 * loose,
          .threshold = 1e-4 * times,
          .pick = 1e-5 * times,
          .picked = 3e-5 * times,  // of splats that the ray grazes
          .least = 1,
          .occluder = 1e-5 * times};
}

/// Draws the list and checks all planes of the frame.
template <class B>
void check_frame(BoundRenderer<B>& renderer, const List& list, const Camera& camera,
                 const Conventions& conventions, const PlaneBounds& bounds, double close = 0.02) {
  const ListOn on(renderer.backend(), list);
  const ReferencePlanes expected = reference_of(list, camera, conventions);
  const Frame frame = renderer.render(on.placed, camera, settings_of_all(channels, conventions));
  check_planes(frame, expected, bounds, close);
  double sum = 0;
  for (const float alpha : frame.alpha) sum += double(alpha);
  CHECK(sum >= 0.1 * double(frame.pixels()));
}

/// Depth of centres, and along the ray.
const Conventions both_depths[] = {Conventions(), along_ray()};

}  // namespace

SWIFTGS_CONTRACT("placed reference: scales of 1e-3 to 1e3 are those of the reference by every rasterizer") {
  Scene scene = with_features(random_scene(150, 3, 5), channels);
  for (std::size_t i = 0; i < scene.size(); i += 2) scene.sh0[i] *= 4.0f;  // many below 0, which are cut
  const List list = list_of_scales(scene);
  const Placed& cut = list[4];
  const auto shown = std::count_if(cut.scene.means.begin(), cut.scene.means.end(),
                                   [&](const vec3& mean) { return cut.clip.shows(mean); });
  CHECK(shown > 15);
  CHECK(shown < 135);
  const Camera camera = turned_camera(67, 45, 0.2, 0.3);
  for (const Conventions& conventions : both_depths) {
    const ReferencePlanes expected = reference_of(list, camera, conventions);
    with_each_renderer<B>([&](BoundRenderer<B>& renderer, std::string_view raster) {
      if (stores_half(raster)) return;
      const ListOn on(renderer.backend(), list);
      const PlaneBounds bounds = usual_bounds<B>(is_split(raster) ? 2 : 1);
      const Frame frame = renderer.render(on.placed, camera, settings_of_all(channels, conventions));
      check_planes(frame, expected, bounds);
    });
  }
}

SWIFTGS_CONTRACT("placed reference: every lens and preset shows them as the reference does") {
  Usual<B> renderer(make_backend<B>());
  const Scene scene = with_features(make_builtin_scene(2'500), channels);  // in chunks
  const List list = list_of_scales(scene);
  Conventions inria = Conventions::inria();
  inria.depth = Conventions::Depth::distance, inria.footprint = Conventions::Footprint::alpha;
  for (const Camera& camera : cameras_of_lenses()) {
    CAPTURE(name_of(camera.lens.model));
    CAPTURE(camera.lens.is_distorted());
    for (const Conventions& conventions : both_depths)
      check_frame(renderer, list, camera, conventions, usual_bounds<B>());
    if (camera.lens.model != LensModel::orthographic)
      check_frame(renderer, list, camera, inria, usual_bounds<B>());
  }
}

SWIFTGS_CONTRACT("placed reference: planes and occluders are at the world's depths") {
  Usual<B> renderer(make_backend<B>());
  const Scene scene = with_features(make_builtin_scene(2'500), channels);
  const List list = list_of_scales(scene);
  const Camera camera = scaled(builtin_camera(), 0.1);
  std::vector<float> occluder;
  for (int i = 0; i < camera.width * camera.height; ++i)
    occluder.push_back(i % 7 == 0 ? std::numeric_limits<float>::infinity()
                                  : 4.5f + 2.5f * std::sin(0.05f * float(i)));
  const ListOn on(renderer.backend(), list);
  for (Conventions conventions : both_depths)
    for (const auto depth : {Conventions::Depth::z, Conventions::Depth::distance}) {
      conventions.depth = depth, conventions.near_plane = 4, conventions.far_plane = 8;
      const ReferencePlanes expected = reference_of(list, camera, conventions, occluder);
      const Frame found =
          draw_over_sevens(renderer, on.placed, camera, settings_of_all(channels, conventions), occluder);
      check_planes(found, expected, usual_bounds<B>(), 0.05);
      CHECK(std::count_if(found.alpha.begin(), found.alpha.end(), [](float a) { return a > 0; }) > 1000);
    }
}

SWIFTGS_CONTRACT("placed reference: rotations may be as far from one as is accepted") {
  Usual<B> renderer(make_backend<B>());
  List list = list_of_scales(with_features(random_scene(150, 3, 6), channels));
  for (Placed& placed : list) {
    dmat3& rotation = placed.pose.rotation;
    rotation[0] *= 1 + 4e-7, rotation[1] -= 5e-7 * rotation[2];
    CHECK_NOTHROW(validate(placed.pose));
  }
  for (const Conventions& conventions : both_depths)
    check_frame(renderer, list, turned_camera(80, 60, 0.2, 0.3), conventions, usual_bounds<B>());
}

SWIFTGS_CONTRACT("placed reference: millimetres 1e7 from zero are seen by a camera as far") {
  Usual<B> renderer(make_backend<B>());
  const dvec3 far(1e7, -2e7, 3e6);
  const auto scene = [](std::uint64_t seed) {
    Scene out = with_features(random_scene(200, 2, seed), channels);
    transform(out, {dmat3(1.0), 1e-3, dvec3(0.0)}, dvec3(0.0));
    return out;
  };
  const List list{moved({scene(3)}, far),
                  moved(placed_by(scene(4), pose_of(5, 1e-3, dvec3(0, 0, 1e-3))), far),
                  moved(placed_by(scene(5), pose_of(6, 1e3, dvec3(1e-3, 0, 0)), 0.5f), far)};
  for (const double angle : {0.0, 0.3})
    for (Conventions conventions : both_depths) {
      CAPTURE(angle);
      conventions.near_plane = 1e-6f;
      Camera camera = turned_camera(90, 70, angle);
      for (int k = 0; k < 3; ++k) camera.translation -= far[k] * camera.rotation[k];
      // A turned camera's centre is known to some 4e-9, a 1000th of a pixel of what is 4e-4 away.
      PlaneBounds bounds = usual_bounds<B>(angle == 0 ? 2 : 40);
      bounds.least = 1e-3;
      check_frame(renderer, list, camera, conventions, bounds, angle == 0 ? 0.05 : 0.3);
    }
}

SWIFTGS_CONTRACT("placed reference: of equal depths the first scene's is in front") {
  Usual<B> renderer(make_backend<B>());
  Scene scene = with_features(random_scene(300, 0, 9), channels), other = scene;
  for (vec3& colour : other.sh0) colour = vec3(0.5f) - colour;
  const Similarity pose = pose_of(9, 5, dvec3(1, 2, 3));
  const Placed first = placed_by(scene, pose), second = placed_by(other, pose, 0.9f);
  const Camera camera = turned_camera(80, 60, 0.1, 0.2);
  for (const List& list : {List{first, second, first}, List{second, first}})
    check_frame(renderer, list, camera, {}, usual_bounds<B>());
}

SWIFTGS_CONTRACT("placed reference: each view shows its own, as alone, under the numbers of the frame") {
  Usual<B> renderer(make_backend<B>());
  const List list = list_of_scales(with_features(random_scene(200, 1, 10), channels));
  const ListOn on(renderer.backend(), list);
  const ShownScenes shown[] = {{0, 3}, {3, 3}, {4, 1}, {2, 1}, {5, 1}, {1, 4}, {3, 0}, {}};
  const auto camera_of = [](std::size_t v) {
    return turned_camera(60 + 7 * int(v), 50, 0.05 * double(v), 0.2);
  };
  std::vector<PlanesOn<B>> memory;
  std::vector<View> views;
  memory.reserve(std::size(shown));
  for (std::size_t v = 0; v < std::size(shown); ++v) {
    const Camera camera = camera_of(v);
    memory.emplace_back(renderer.backend(), camera.width, camera.height, all_planes(channels), 0);
    views.push_back(make_view(camera, both_depths[v % 2], memory.back().view()));
    views.back().shows = shown[v];
  }
  renderer.render_into(on.placed, span_of(views));
  for (std::size_t v = 0; v < views.size(); ++v) {
    CAPTURE(v);
    List own;
    std::vector<PlacedScene> own_placed;
    std::uint32_t before = 0;
    for (std::size_t i = 0; i < list.size(); ++i) {
      if (i < shown[v].first) before += std::uint32_t(list[i].scene.size());
      if (i < shown[v].first || i - shown[v].first >= shown[v].count) continue;
      own.push_back(list[i]), own_placed.push_back(on.placed[i]);
    }
    if (own.empty()) own = {list[2]}, own_placed = {on.placed[2]};  // without Gaussians
    ReferencePlanes expected = reference_of(own, camera_of(v), both_depths[v % 2]);
    for (auto* ids : {&expected.id, &expected.median_id})
      for (std::uint32_t& id : *ids)
        if (id != no_gaussian) id += before;
    const Frame found = memory[v].on_host(renderer.backend());
    check_planes(found, expected, usual_bounds<B>());
    const RenderSettings settings = settings_of_all(channels, both_depths[v % 2]);
    CHECK(same_but_ids(found, renderer.render(own_placed, camera_of(v), settings)));
  }
}

}  // namespace swiftgs::test::placed_reference_test
