// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <numbers>
#include <numeric>
#include <stdexcept>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/edit/all.hpp>
#include <swiftgs/edit/pruning.hpp>
#include <swiftgs/reference.hpp>

#include "policies/contribution_sums.hpp"
#include "policies/placed_list.hpp"
#include "policies/random_splats.hpp"

namespace swiftgs::test::contribution_test {

namespace {

/// Weight of each Gaussian in the float64 reference's image, in pixels: in a colour of its own, three of them
/// a frame. The scenes have no bands above 0.
std::vector<double> reference_weights(List list, const Camera& camera, const Conventions& conventions) {
  const float one = float(0.5 / 0.28209479177387814);  // SH coefficient of colour 1; minus that is colour 0
  std::vector<ReferenceScene> placed;
  std::vector<vec3*> colours;  // of all Gaussians
  for (Placed& p : list) {
    placed.push_back({p.scene, p.pose, p.opacity, p.clip, p.tint});
    for (vec3& colour : p.scene.sh0) colours.push_back(&colour);
  }
  std::vector<double> weights(colours.size());
  for (std::size_t first = 0; first < colours.size(); first += 3) {
    for (vec3* const colour : colours) *colour = vec3(-one);
    const int shown = int(std::min<std::size_t>(3, colours.size() - first));
    for (int c = 0; c < shown; ++c) (*colours[first + std::size_t(c)])[c] = one;
    const ReferenceFrame frame = render_reference({placed.data(), placed.size()}, camera, conventions);
    for (std::size_t i = 0; i < frame.colour.size(); ++i)
      if (int(i % 3) < shown) weights[first + i % 3] += frame.colour[i];
  }
  return weights;
}

/// Checks sums of 60 Gaussians at most, in a view of 64x48 pixels, and that they are not few.
[[maybe_unused]] void check_against_reference(const Sums& sums, const std::vector<double>& expected) {
  REQUIRE(sums.size() == expected.size());
  for (std::size_t i = 0; i < sums.size(); ++i) {
    CAPTURE(i);
    // A weight is a product of alphas, 60 at most, each with a few roundings of 2^-24; and a pixel cuts
    // 2^-31.
    CHECK(std::abs(weight_of_parts(sums[i]) - expected[i]) <= 60 * 0x1p-22 * expected[i] + 64 * 48 * 0x1p-31);
    if (expected[i] == 0) CHECK(sums[i] == 0);
  }
  CHECK(total(sums) == doctest::Approx(std::accumulate(expected.begin(), expected.end(), 0.0)).epsilon(1e-5));
  CHECK(total(sums) > 500);
}

Scene flat_scene(std::size_t count, std::uint64_t seed) { return random_scene(count, 0, seed); }

/// A random scene, many deep, so that transmittance matters.
Scene deep_scene(std::size_t count, std::uint64_t seed) {
  Scene scene = random_scene(count, 0, seed);
  for (vec3& scale : scene.scales) scale *= 8.0f;
  for (float& opacity : scene.opacities) opacity = std::sqrt(opacity);
  return scene;
}

/// Scenes of `count` Gaussians each, in spaces of their own, and an empty one.
List some_placed(Scene (*make)(std::size_t, std::uint64_t), std::size_t count) {
  Placed cut = placed_by(make(count, 24), moved(30, dvec3(1, 2, 3)), 0.7f);
  cut.clip = Clip::sphere(cut.scene.means[0], 0.2f), cut.clip.half_space_count = 1;
  cut.clip.half_spaces[0] = vec4(0, 0, -1, cut.scene.means[0].z + 0.1f);
  return {{make(count, 21), {}, 0.6f},
          placed_by(make(count, 22), moved(1e-3)),
          {Scene()},
          placed_by(make(count, 23), moved(1e3), 0.9f),
          cut};
}

/// As `sums_of`, of placed scenes.
template <class B>
Sums sums_of_placed(const PlacedScenes& placed, const std::vector<Camera>& cameras,
                    const Conventions& conventions = Conventions::gsplat()) {
  Contributions<B> contributions(placed, test::make_backend<B>());
  for (const Camera& camera : cameras) contributions.add(camera, conventions);
  return contributions.sums();
}
template <class B>
Sums sums_of_placed(const List& list, const std::vector<Camera>& cameras, const Conventions& conventions) {
  return sums_of_placed<B>(ListOn<B>(test::make_backend<B>(), list).placed, cameras, conventions);
}

/// Compares with the serial backend. Exponentials differ by 2 units in the last place; and where alpha or
/// transmittance is at a threshold, a pixel more or less keeps a splat: with a weight of 1/255 at most at
/// the first, of 0.01 at most at the second, where transmittance was 1e-4 / (1 - 0.99).
void check_close_to_serial(const Sums& sums, const Sums& expected) {
  REQUIRE(sums.size() == expected.size());
  std::size_t at_threshold = 0;
  for (std::size_t i = 0; i < sums.size(); ++i) {
    CAPTURE(i);
    const double weight = weight_of_parts(expected[i]);
    const double difference = std::abs(weight_of_parts(sums[i]) - weight);
    CHECK(difference <= 1e-4 * weight + 0.02);
    at_threshold += difference > 1e-4 * weight + 1e-6;
  }
  CHECK(double(at_threshold) <= 0.02 * double(sums.size()));
  CHECK(total(sums) == doctest::Approx(total(expected)).epsilon(1e-5));
  CHECK(total(sums) > 1000);
}
template <class B>
void check_against_serial(const Scene& scene, const std::vector<Camera>& cameras,
                          const Conventions& conventions) {
  check_close_to_serial(sums_of<B>(scene, cameras, conventions),
                        sums_of<Serial>(scene, cameras, conventions));
}

}  // namespace

SWIFTGS_CONTRACT("contribution: sums are those of Serial but for roundings at thresholds") {
  Conventions antialiased;
  antialiased.antialiased = true;
  for (const Conventions& conventions : {Conventions::gsplat(), Conventions::inria(), antialiased}) {
    check_against_serial<B>(random_scene(3000, 0, 13), {forward_camera(131, 77), forward_camera(64, 64)},
                            conventions);
    check_against_serial<B>(make_builtin_scene(8000), builtin_cameras(3, 192, 108), conventions);
    const List placed = some_placed(flat_scene, 1000);
    const std::vector<Camera> cameras{forward_camera(131, 77), forward_camera(64, 64)};
    check_close_to_serial(sums_of_placed<B>(placed, cameras, conventions),
                          sums_of_placed<Serial>(placed, cameras, conventions));
  }
  if (on_host<B>) return;
  // An image of more than 65,536 tiles.
  check_against_serial<B>(random_scene(200, 0, 14), {forward_camera(4600, 4000)}, Conventions::gsplat());
}

TEST_CASE("contribution: a weight is a number of parts without rounding but for a cut of the least") {
  CHECK(weight_parts(1) == std::uint32_t(1) << 31);
  CHECK(weight_parts(0) == 0);
  CHECK(weight_of_parts(std::uint64_t(3) << 30) == 1.5);
  for (const float weight : {0.99f, 0.5f, 1.0f / 255, std::nextafter(1.0f, 0.0f)})
    CHECK(float(weight_of_parts(weight_parts(weight))) == weight);
  const float least = 1e-4f / 255;
  CHECK(weight_of_parts(weight_parts(least)) <= least);
  CHECK(weight_of_parts(weight_parts(least)) > double(least) - 0x1p-31);
}

SWIFTGS_CONTRACT("contribution: what Gaussians get is what covers the pixels") {
  const Scene scene = random_scene(2000, 0, 11);
  Camera panorama = forward_camera(256, 128);
  panorama.lens.model = LensModel::equirectangular;
  panorama.fx = panorama.fy = 256 / (2 * std::numbers::pi);
  const auto check = [&](const Camera& camera, const Conventions& conventions) {
    Usual<std::conditional_t<on_host<B>, Serial, B>> renderer;
    RenderSettings settings;
    settings.conventions = conventions, settings.outputs.alpha = true, settings.count = true;
    const Frame frame = renderer.render(renderer.backend().upload(scene), camera, settings);
    const double covered = std::accumulate(frame.alpha.begin(), frame.alpha.end(), 0.0);
    const Statistics statistics = renderer.statistics();

    // Transmittance is at most 1: a pair rounds its weight and what is left of the light by 2^-25 each, and
    // loses 2^-31 in the cut. A pixel rounds 1 - T by 2^-25. A device divides by the largest alpha besides.
    const double of_pair = 0x1p-24 + 0x1p-31 + (on_host<B> ? 0 : 0x1p-25);
    const double bound =
        double(statistics.raster.contributing_pairs) * of_pair + double(frame.pixels()) * 0x1p-25;
    const double sum = total(sums_of<B>(scene, {camera}, conventions));
    CHECK(sum > 1000);
    CHECK(std::abs(sum - covered) <= bound);
    CHECK(bound < 1e-5 * sum);
  };
  for (const Conventions& conventions : {Conventions::gsplat(), Conventions::inria()}) {
    check(forward_camera(150, 93), conventions);
    check(panorama, conventions);
  }
}

TEST_CASE("contribution: sums are the same bits on any number of threads and twice") {
  const Scene scene = make_builtin_scene(4000);
  const std::vector<Camera> cameras = builtin_cameras(5, 160, 90);
  const Sums expected = sums_of(scene, cameras, Conventions::gsplat(), Cpu(1));
  CHECK(close(expected, sums_of<Serial>(scene, cameras)));
  for (const int threads : {1, 2, 4, 8, 8}) {
    CAPTURE(threads);
    CHECK(sums_of(scene, cameras, Conventions::gsplat(), Cpu(threads)) == expected);
  }
}

TEST_CASE_TEMPLATE("contribution: of placed scenes is each Gaussian's weight in the reference's image", B,
                   SWIFTGS_TEST_HOSTS) {
  const Camera camera = forward_camera(64, 48);
  const List list = some_placed(deep_scene, 15);
  Conventions conventions = Conventions::gsplat();
  for (const bool antialiased : {false, true}) {
    conventions.antialiased = antialiased;
    const std::vector<double> expected = reference_weights(list, camera, conventions);
    check_against_reference(sums_of_placed<B>(list, {camera}, conventions), expected);
    const auto shown = [&](std::size_t scene) {  // Gaussians of `scene` with a weight
      return std::count_if(expected.begin() + std::ptrdiff_t(15 * scene),
                           expected.begin() + std::ptrdiff_t(15 * scene + 15),
                           [](double w) { return w > 0; });
    };
    for (const std::size_t scene : {0, 1, 2, 3}) CHECK(shown(scene) > 2);
    CHECK(shown(3) < shown(2));  // the clip left some out
  }
}

SWIFTGS_CONTRACT("contribution: a scene in placed pieces gets the bits of the whole") {
  const std::vector<Camera> cameras{forward_camera(131, 77), builtin_cameras(3, 192, 108)[1]};
  for (const Scene& scene :
       {random_scene(3000, 1, 13), make_builtin_scene(8000), scene_with_colourless(2000, 16)}) {
    const auto uploaded = backend.upload(scene);
    const Sums expected = sums_of<B>(scene, cameras);
    CHECK(total(expected) > 1000);
    CHECK(sums_of_placed<B>(uploaded, cameras) == expected);
    for (const std::size_t each : {1024, 700}) {
      std::vector<PlacedScene> pieces{{SceneView()}};
      for (std::size_t first = 0; first < scene.size(); first += each)
        pieces.push_back({range_of(uploaded.view(), first, std::min(each, scene.size() - first))});
      CHECK(sums_of_placed<B>(pieces, cameras) == expected);
    }
  }
}

SWIFTGS_CONTRACT("contribution: of placed scenes sees the Gaussians that a renderer sees under its numbers") {
  const List list = some_placed(flat_scene, 2000);
  Usual<B> renderer(test::make_backend<B>());
  const ListOn<B> on(backend, list);
  Contributions<B> contributions(on.placed, test::make_backend<B>());
  RenderSettings settings;
  settings.outputs.id = true, settings.conventions.near_plane = 4;  // nothing covers the whole image
  const Camera camera = forward_camera(200, 150);
  const Frame frame = renderer.render(on.placed, camera, settings);
  contributions.add(camera, settings.conventions);
  CHECK(contributions.visible() == renderer.statistics().visible);
  const Sums sums = contributions.sums();
  REQUIRE(sums.size() == 8000);
  CHECK(total(sums) > 1000);
  std::size_t seen[5] = {};
  for (const std::uint32_t id : frame.id) {
    if (id == no_gaussian) continue;
    CHECK(sums[id] > 0);
    ++seen[placed_index(on.placed, id).scene];
  }
  for (const std::size_t scene : {0, 1, 3, 4}) CHECK(seen[scene] > 0);
  CHECK(seen[2] == 0);
}

SWIFTGS_CONTRACT("contribution: placed scenes that cannot be drawn are refused and none have no sums") {
  const auto uploaded = backend.upload(random_scene(10, 0, 1));
  const auto make = [](const PlacedScene& placed) {
    Contributions<B>(std::vector<PlacedScene>{{placed.scene}, placed}, test::make_backend<B>());
  };
  CHECK_NOTHROW(make({uploaded.view()}));
  CHECK_THROWS_WITH_AS(make({uploaded.view(), {.scale = 0}}), "placed scene: expected a finite scale above 0",
                       std::invalid_argument);
  CHECK(sums_of_placed<B>(std::vector<PlacedScene>(), {forward_camera(20, 30)}).empty());
}

SWIFTGS_CONTRACT("contribution: Gaussians that frames hide get nothing and those behind them all") {
  const Scene scene = scene_with_colourless(2000, 16);
  const Camera camera = forward_camera(150, 93);
  Usual<B> renderer(std::move(backend));
  RenderSettings settings;
  settings.outputs.alpha = true;
  const Frame frame = renderer.render(renderer.backend().upload(scene), camera, settings);
  const double covered = std::accumulate(frame.alpha.begin(), frame.alpha.end(), 0.0);
  Contributions<B> contributions(std::make_shared<const Scene>(scene), test::make_backend<B>());
  contributions.add(camera, settings.conventions);
  const Sums sums = contributions.sums();
  for (std::size_t i = 0; i < sums.size(); i += 10) CHECK(sums[i] == 0);
  CHECK(total(sums) > 1000);
  CHECK(total(sums) == doctest::Approx(covered).epsilon(1e-4));
  CHECK(contributions.visible() == renderer.statistics().visible);
}

TEST_CASE("contribution: colours are looked at only in scenes whose numbers could overflow") {
  Scene scene = random_scene(100, 3, 17);
  CHECK_FALSE(colours_may_overflow(Scene()));
  CHECK_FALSE(colours_may_overflow(scene));
  for (vec3& coefficient : scene.sh0) coefficient = vec3(1e36f);
  for (float& coefficient : scene.sh_rest) coefficient = -1e36f;
  CHECK_FALSE(colours_may_overflow(scene));
  scene.sh_rest.back() = 1.1e36f;
  CHECK(colours_may_overflow(scene));
  scene.sh_rest.back() = 0, scene.sh0[50].y = -1.1e36f;
  CHECK(colours_may_overflow(scene));
  scene.sh0[50].y = 0, scene.means[99].z = 1.1e36f;
  CHECK(colours_may_overflow(scene));
}

SWIFTGS_CONTRACT("contribution: views add up in any order") {
  const Scene scene = random_scene(800, 0, 14);
  const Conventions conventions = Conventions::inria();
  const Camera large = forward_camera(130, 70), small = forward_camera(33, 17);
  Sums sum = sums_of<B>(scene, {large}, conventions);
  const Sums other = sums_of<B>(scene, {small}, conventions);
  for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += other[i];
  CHECK(sums_of<B>(scene, {large, small}, conventions) == sum);
  CHECK(sums_of<B>(scene, {small, large}, conventions) == sum);
}

SWIFTGS_CONTRACT("contribution: scenes of no and of one Gaussian have as many sums") {
  const Camera camera = forward_camera(20, 30);
  CHECK(sums_of<B>(Scene(), {camera}).empty());
  CHECK(sums_of<B>(Scene(), {}).empty());
  Scene one;
  append(one, vec3(0, 0, 1), 1000, 1);
  CHECK(sums_of<B>(one, {}) == Sums{0});
  CHECK(sums_of<B>(one, {camera}) == Sums{600 * std::uint64_t(weight_parts(0.99f))});
}

TEST_CASE_TEMPLATE("contribution: more pixels than sums have room for are refused and nothing is added", B,
                   SWIFTGS_TEST_HOSTS) {
  Scene scene;
  append(scene, vec3(0, 0, 1), 0.001f, 1);
  Contributions<B> contributions(std::make_shared<const Scene>(scene), test::make_backend<B>());
  const Camera huge = forward_camera(max_image_side, max_image_side), camera = forward_camera(20, 30);
  contributions.add(huge, Conventions::gsplat());
  const Sums before = contributions.sums();
  CHECK(before[0] > 0);
  CHECK_THROWS_WITH_AS(contributions.add(huge, Conventions::gsplat()),
                       "pixels of all views: 8589934592 needed, the limit is 8589934591", CapacityError);
  CHECK(contributions.sums() == before);
  contributions.add(camera, Conventions::gsplat());
  CHECK(contributions.sums()[0] > before[0]);
}

TEST_CASE("contribution: a camera that nothing can be rendered with is refused") {
  Contributions<Serial> contributions(std::make_shared<const Scene>(random_scene(3, 0, 1)));
  Camera camera = forward_camera(20, 30);
  camera.width = 0;
  CHECK_THROWS_AS(contributions.add(camera, Conventions::gsplat()), std::invalid_argument);
  CHECK_THROWS_AS(Contributions<Serial>(nullptr), std::invalid_argument);
}

SWIFTGS_CONTRACT("contribution: a backend is found by its name or is the first that runs here") {
  const auto scene = std::make_shared<const Scene>(random_scene(300, 0, 15));
  const Camera camera = forward_camera(40, 30);
  const ContributionsEntry& entry = contribution_backend(B::name);
  CHECK(entry.backend == B::name);
  CHECK(entry.usable);
  const auto contributions = entry.make(scene);
  contributions->add(camera, Conventions::gsplat());
  CHECK(close(contributions->sums(), sums_of<Serial>(*scene, {camera})));
  CHECK(entry.make(std::make_shared<const Scene>())->sums().empty());
  const std::string_view first = contribution_backend("").backend;
  CHECK(contribution_backend("").usable);
  CHECK((first == "cuda" || (B::name != "cuda" && first == "cpu")));
  CHECK_THROWS_AS(contribution_backend("gpu"), std::invalid_argument);
}

TEST_CASE(
    "pruning: the highest scores are kept in the order of the scene and of equal ones the lower index") {
  using Indices = std::vector<std::uint32_t>;
  CHECK(highest(std::vector<double>{3, 1, 4, 1, 5}, 3) == Indices{0, 2, 4});
  CHECK(highest(std::vector<double>{3, 1, 4}, 3) == Indices{0, 1, 2});
  CHECK(highest(std::vector<double>{3, 1, 4}, 0) == Indices{});
  CHECK(highest(std::vector<double>{}, 0) == Indices{});
  CHECK_THROWS_AS(highest(std::vector<double>{1}, 2), std::invalid_argument);
  CHECK(highest(std::vector<std::uint64_t>{7, 7, 9, 7, 7}, 3) == Indices{0, 1, 2});
  CHECK(highest(std::vector<std::uint64_t>(1000, 0), 400).back() == 399);
  // Scores that doubles could not tell apart.
  const std::uint64_t large = std::uint64_t(1) << 60;
  CHECK(highest(std::vector<std::uint64_t>{large, large + 1}, 1) == Indices{1});
}

TEST_CASE("pruning: a fraction is rounded to at least one Gaussian") {
  CHECK(kept_count(0.1, 1000) == 100);
  CHECK(kept_count(1, 7) == 7);
  CHECK(kept_count(0.26, 10) == 3);
  CHECK(kept_count(1e-9, 10) == 1);
  CHECK(kept_count(0.5, 0) == 0);
  for (const double fraction : {0.0, -0.5, 1.5, double(NAN), double(INFINITY)})
    CHECK_THROWS_AS(kept_count(fraction, 10), std::invalid_argument);
}

TEST_CASE("pruning: opacity times volume") {
  Scene scene = random_scene(1, 0, 3);
  scene.opacities[0] = 0.5f, scene.scales[0] = vec3(2, 4, 0.25f);
  CHECK(opacity_volumes(scene) == std::vector<double>{1});
  CHECK(opacity_volumes(Scene()).empty());
}

}  // namespace swiftgs::test::contribution_test
