// SPDX-License-Identifier: Apache-2.0
#include <map>
#include <memory>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include <doctest/doctest.h>
#include <oneapi/tbb/global_control.h>

#include <swiftgs/any_renderer.hpp>
#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/cpu.hpp>
#include <swiftgs/metrics.hpp>
#include <swiftgs/reference.hpp>
#include <swiftgs/swiftgs.hpp>

#include "policies/random_splats.hpp"

using namespace swiftgs;
using swiftgs::test::forward_camera;
using swiftgs::test::random_scene;

namespace {

/// What a renderer's name says about it.
struct Words {
  explicit Words(std::string_view name) {
    for (std::string* word : {&backend, &sort, &raster, &bounds}) {
      const std::size_t end = name.find('/');
      *word = name.substr(0, end);
      name.remove_prefix(end == std::string_view::npos ? name.size() : end + 1);
    }
  }
  bool half() const { return raster.find("half-split") != std::string::npos; }
  bool conservative() const { return bounds != "three-sigma-square"; }

  std::string backend, sort, raster, bounds;
};

struct Bits {
  std::vector<float> colour, alpha, depth;
  bool operator==(const Bits&) const = default;
};

/// Renders with all renderers and checks all that holds between them and the reference.
void check_all(const Scene& scene, const Camera& camera, Conventions conventions) {
  RenderSettings settings;
  settings.conventions = conventions, settings.background = vec3(0.2f, 0.3f, 0.4f);
  settings.outputs = {true, true};
  const dvec3 background(settings.background);
  conventions.footprint = Conventions::Footprint::alpha;
  const ReferenceFrame whole = render_reference(scene, camera, conventions, background, 2);
  conventions.footprint = Conventions::Footprint::three_sigma_square;
  const ReferenceFrame cut = render_reference(scene, camera, conventions, background, 2);

  const auto shared = std::make_shared<const Scene>(scene);
  std::map<std::string, Bits> first_of;
  std::set<std::string> backends;
  for (const RendererEntry& entry : renderers()) {
    const Words words(entry.name);
    if (words.backend == "cuda") continue;  // tests/cuda draws with these
    CAPTURE(entry.name);
    backends.insert(words.backend);
    const auto renderer = entry.make();
    renderer->set_scene(shared);
    Frame frame, again;
    renderer->render(camera, settings, frame);
    renderer->render(camera, settings, again);
    const Bits bits{frame.colour, frame.alpha, frame.depth};
    CHECK(bits == Bits{again.colour, again.alpha, again.depth});

    // Whatever the sort, and whatever the bounds as long as they are conservative, the bits are the same.
    const std::string group = words.backend + words.raster + (words.conservative() ? "" : words.bounds);
    CHECK(first_of.try_emplace(group, bits).first->second == bits);

    const ReferenceFrame& reference = words.conservative() ? whole : cut;
    CHECK(psnr(frame.colour, reference.colour) >= (words.half() ? 40 : 120));
    CHECK(psnr(frame.alpha, reference.alpha) >= (words.half() ? 40 : 120));
    if (words.half()) continue;
    CHECK(max_abs_difference(frame.colour, reference.colour) <= 1.0 / 255);
    CHECK(max_abs_difference(frame.alpha, reference.alpha) <= 1.0 / 255);
  }
  CHECK(backends.size() == 2);
  CHECK(first_of.size() == backends.size() * 7 * 2);
}

}  // namespace

TEST_CASE("parity: all renderers draw the reference's image for each SH degree") {
  for (const int degree : {0, 1, 2, 3}) {
    CAPTURE(degree);
    check_all(random_scene(250, degree, std::uint64_t(degree) + 1), forward_camera(67, 45),
              Conventions::gsplat());
  }
}

TEST_CASE("parity: all renderers draw the reference's image with the inria preset") {
  check_all(random_scene(400, 3, 5), forward_camera(97, 61), Conventions::inria());
}

TEST_CASE("parity: all renderers draw the reference's image in the antialiased mode") {
  Scene scene = random_scene(600, 1, 6);
  for (vec3& scale : scene.scales) scale *= 0.3f;  // a pixel or less, where it matters
  for (Conventions conventions : {Conventions::gsplat(), Conventions::inria()}) {
    conventions.antialiased = true;
    check_all(scene, forward_camera(80, 60), conventions);
  }
}

TEST_CASE("parity: all renderers draw the reference's image with a principal point outside the image") {
  Camera camera = forward_camera(64, 48);
  camera.cx = -20, camera.cy = 70;
  check_all(random_scene(400, 2, 7), camera, Conventions::gsplat());
}

TEST_CASE("parity: all renderers draw the reference's image of the built-in scene") {
  check_all(make_builtin_scene(4000), builtin_camera(128, 72), Conventions::gsplat());
}

TEST_CASE("parity: the depth output is the reference's mean depth") {
  const Scene scene = random_scene(300, 0, 8);
  const Camera camera = forward_camera(60, 40);
  const ReferenceFrame reference = render_reference(scene, camera, Conventions::gsplat(), dvec3(0), 2);
  RenderSettings settings;
  settings.outputs.depth = true;
  for (const char* name :
       {"serial/early/per-pixel/ellipse", "cpu/early/axis-shared-threshold-float-cholesky/ellipse"}) {
    CAPTURE(name);
    const auto renderer = make_renderer(name);
    renderer->set_scene(std::make_shared<const Scene>(scene));
    Frame frame;
    renderer->render(camera, settings, frame);
    // Depths reach 12.
    CHECK(psnr(frame.depth, reference.depth) >= 105);
    CHECK(max_abs_difference(frame.depth, reference.depth) <= 1e-3);
  }
}

TEST_CASE("parity: cpu renderers give the same bits on 1 2 4 and 8 threads") {
  const tbb::global_control eight(tbb::global_control::max_allowed_parallelism, 8);
  const Scene scene = make_builtin_scene(20'000);
  const Camera camera = builtin_camera(256, 144);
  RenderSettings settings;
  settings.outputs = {true, true};
  const auto same_bits = [&]<class Sort, class Raster, class Bounds>(Sort, Raster, Bounds) {
    Bits expected;
    for (const int threads : {1, 2, 4, 8}) {
      CAPTURE(threads);
      Renderer<Cpu, Sort, Raster, Bounds> renderer{Cpu(threads)};
      CAPTURE(renderer.name);
      const Frame frame = renderer.render(renderer.backend().upload(scene), camera, settings);
      const Bits bits{frame.colour, frame.alpha, frame.depth};
      if (threads == 1) expected = bits;
      CHECK(bits == expected);
    }
  };
  same_bits(StandardSort(), PerPixel(), ThreeSigmaSquare());
  same_bits(EarlySort(), AxisShared<FloatSplit>(), OpacityBox());
  same_bits(EarlySort(), AxisSharedThreshold<HalfSplit>(), Ellipse());
  same_bits(AdaptiveSort(), AxisSharedThreshold<FloatCholesky>(), Ellipse());
}
