// SPDX-License-Identifier: Apache-2.0

// Projection on the device against the serial backend's.
#include <algorithm>
#include <cmath>
#include <cstdlib>

#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/edit/all.hpp>

#include "cuda/device.hpp"
#include "policies/contribution_sums.hpp"
#include "policies/views.hpp"
#include "support/one_view.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

namespace {

/// Whether two positive floats, or two that are equal, lie no more than `steps` floats apart.
bool within(float a, float b, std::int64_t steps) {
  const auto bits = [](float v) { return std::int64_t(__builtin_bit_cast(std::int32_t, v)); };
  return a == b || (a * b > 0 && std::abs(bits(a) - bits(b)) <= steps);
}

/// The logarithm, 1 / z and 1 / sqrt round differently, the last by up to 2 floats; what is made of them
/// follows. `l0` is made of the difference of two numbers with that root's square in them, up to twice as
/// large as what is left, and `l1` of `l0` and that square; 6 floats were measured. tests/stability compares
/// both with exact values.
bool close(const SplatShape& a, const SplatShape& b) {
  const auto same_place = [&](int k) {
    return within(a.mean[k], b.mean[k], 2) && std::abs(a.exact_mean()[k] - b.exact_mean()[k]) <= 0x1p-23;
  };
  const bool same_form = within(a.l0, b.l0, 8) && within(a.l1, b.l1, 8) && within(a.l2, b.l2, 4);
  return same_place(0) && same_place(1) && same_form && within(a.opacity, b.opacity, 4) &&
         std::abs(a.cutoff - b.cutoff) <= 1e-6f * std::max(1.0f, b.cutoff);
}

bool close(const SplatColour& a, const SplatColour& b) {
  bool same = within(a.depth, b.depth, 2);
  for (int c = 0; c < 3; ++c)
    same = same && std::abs(a.rgb[c] - b.rgb[c]) <= 1e-6f * std::max(1.0f, b.rgb[c]);
  return same;
}

/// How the splats of two backends go together.
struct Match {
  std::size_t alone = 0, different = 0;
};

/// Floats on the device without a byte behind the last, where a tool that checks memory sees what is read
/// beyond.
struct ExactMemory {
  explicit ExactMemory(const std::vector<float>& from)
      : data(static_cast<float*>(DeviceMemory::allocate(from.size() * sizeof(float)))) {
    check_cuda(cudaMemcpy(data, from.data(), from.size() * sizeof(float), cudaMemcpyHostToDevice),
               "cudaMemcpy");
    check_cuda(cudaStreamSynchronize(nullptr), "cudaStreamSynchronize");
  }
  ~ExactMemory() { DeviceMemory::release(data); }
  ExactMemory(const ExactMemory&) = delete;
  ExactMemory& operator=(const ExactMemory&) = delete;

  float* data;
};

/// Walks through both in order. Where they part, one has a splat at its border that the other has not.
Match match(const SplatSet& a, const SplatSet& b) {
  Match out;
  std::size_t i = 0, j = 0;
  const auto same = [&](std::size_t x, std::size_t y) {
    return x < a.shapes.size() && y < b.shapes.size() && within(a.depths[x], b.depths[y], 2) &&
           within(a.shapes[x].mean.x, b.shapes[y].mean.x, 2);
  };
  while (i < a.shapes.size() || j < b.shapes.size()) {
    if (same(i, j)) {
      out.different += !close(a.shapes[i], b.shapes[j]) || !close(a.colours[i], b.colours[j]);
      ++i, ++j;
    } else if (j == b.shapes.size() || same(i + 1, j)) {
      ++out.alone, ++i;
    } else {
      ++out.alone, ++j;
    }
  }
  return out;
}

/// Whether the tiles of every splat are those of the bounds. `of_view`: empty where there is one view.
template <class Bounds>
bool found_tiles(const Cuda& cuda, const std::vector<SplatShape>& shapes, const Footprints<Cuda>& footprints,
                 const Views& views, Bounds bounds, const std::vector<std::uint16_t>& of_view = {}) {
  const std::vector<Footprint> found = to_host(cuda, footprints.view().each);
  std::uint64_t sum = 0;
  bool same = found.size() == shapes.size() && footprints.views.tiles == views.tiles;
  for (std::size_t i = 0; same && i < found.size(); ++i) {
    const Footprint expected =
        find_footprint(bounds, shapes[i], views[of_view.empty() ? 0 : of_view[i]].grid);
    same = found[i].count == expected.count &&
           (expected.count == 0 || (found[i].mask == expected.mask && found[i].first == expected.first));
    sum += found[i].count;
  }
  return same && sum == footprints.intersections.most;
}

/// A projection stage with its memory, which lives from frame to frame.
template <class B>
struct StageOn {
  B backend;
  ProjectScratch<B> scratch;
  Splats<B> splats;
  Colours<B> colours;
  Footprints<B> footprints;

  template <class Bounds = Ellipse>
  SplatSet run(const SceneView& scene, const Camera& camera,
               const Conventions& conventions = Conventions::gsplat(), Bounds bounds = {}) {
    const OneView frame(camera, conventions, scene);
    project(backend, frame.plan(), bounds, scratch, splats, footprints);
    auto shading = shade(backend, frame.plan(), splats, colours);
    bin(backend, frame.plan(), bounds, splats, footprints);
    return to_host(backend, splats.view(), shading.finish());
  }

  template <class Bounds = Ellipse>
  bool found_tiles(const SplatSet& set, const Camera& camera, Bounds bounds = {}) {
    const View view = view_without_camera(camera.width, camera.height);
    return ::found_tiles(backend, set.shapes, footprints, {&view, 1}, bounds);
  }
};
using Stage = StageOn<Cuda>;

bool same_splats(const SplatSet& a, const SplatSet& b) {
  return same_bits(a.shapes, b.shapes) && same_bits(a.depths, b.depths) &&
         same_bits(a.gaussians, b.gaussians) && same_bits(a.colours, b.colours);
}

/// Projects one scene on both. Returns the number of splats on the device.
std::size_t check_projection(Stage& stage, const Scene& scene, const Camera& camera,
                             const Conventions& conventions = Conventions::gsplat()) {
  const DeviceScene uploaded = stage.backend.upload(scene);
  const SplatSet expected = StageOn<Serial>().run(view(scene), camera, conventions);
  const SplatSet set = stage.run(uploaded.view(), camera, conventions);
  CHECK(stage.found_tiles(set, camera));
  const Match result = match(set, expected);
  CAPTURE(scene.size());
  CHECK(result.different == 0);
  CHECK(result.alone <= 1 + expected.shapes.size() / 10'000);
  for_each_type(AllBounds(), [&]<class Bounds>(Bounds bounds) {
    CAPTURE(Bounds::name);
    const SplatSet again = stage.run(uploaded.view(), camera, conventions, bounds);
    CHECK(same_splats(again, set));
    CHECK(stage.found_tiles(again, camera, bounds));
  });
  return set.shapes.size();
}

}  // namespace

SWIFTGS_DEVICE_CASE("cuda project: splats are Serial's for every number of Gaussians and SH degree") {
  for (const int degree : {0, 1, 2, 3})
    for (const std::size_t n : {0, 1, 2, 31, 33, 255, 256, 257, 20'000}) {
      CAPTURE(degree);
      Stage stage;
      check_projection(stage, random_scene(n, degree, n + 1), forward_camera(320, 200));
    }
}

SWIFTGS_DEVICE_CASE("cuda project: splats are Serial's with other presets, cameras and scenes") {
  Stage stage;
  const Scene large = random_scene(100'000, 1, 3), scene = random_scene(5000, 0, 4);
  Conventions antialiased = Conventions::gsplat();
  antialiased.antialiased = true;
  for (const Conventions& conventions : {Conventions::gsplat(), Conventions::inria(), antialiased})
    CHECK(check_projection(stage, large, forward_camera(640, 360), conventions) > 10'000);
  const Scene builtin = make_builtin_scene(20'000);
  for (const Camera& camera : builtin_cameras(6, 320, 180))
    CHECK(check_projection(stage, builtin, camera) > 1000);
  Camera camera = forward_camera(200, 100);
  camera.cx = -60, camera.cy = 170;
  check_projection(stage, scene, camera);
  check_projection(stage, scene, forward_camera(max_image_side, 40));
  check_projection(stage, random_scene(300, 0, 5), forward_camera(max_image_side, max_image_side));
}

SWIFTGS_DEVICE_CASE("cuda project: nothing behind the last coefficient of any stride is read") {
  Stage stage;
  const Camera camera = forward_camera(320, 200);
  for (const int degree : {1, 2, 3}) {
    const Scene scene = random_scene(1000, degree, 6);
    const DeviceScene uploaded = stage.backend.upload(scene);
    const SplatSet expected = stage.run(uploaded.view(), camera);
    const std::size_t used = 3 * std::size_t(sh_rest_count(degree));
    for (const std::size_t stride : {used, used + 1, used + 2, used + 3, used + 4, std::size_t(48)})
      for (const std::size_t begin : {0, 1, 2, 3, 4}) {
        CAPTURE(degree);
        CAPTURE(stride);
        CAPTURE(begin);
        std::vector<float> spread(begin + (scene.size() - 1) * stride + used, NAN);
        for (std::size_t i = 0; i < scene.size(); ++i)
          std::copy_n(&scene.sh_rest[used * i], used, &spread[begin + stride * i]);
        const ExactMemory coefficients(spread);
        SceneView on_device = uploaded.view();
        on_device.sh_rest = {coefficients.data + begin, scene.size(), stride * sizeof(float)};
        CHECK(same_splats(stage.run(on_device, camera), expected));
      }
  }
}

SWIFTGS_DEVICE_CASE("cuda project: nothing may be visible or all") {
  Stage stage;
  Scene scene = random_scene(3000, 1, 7);
  for (vec3& mean : scene.means) mean = vec3(mean.x, mean.y, -1 - std::abs(mean.z));
  CHECK(check_projection(stage, scene, forward_camera(320, 200)) == 0);
  CHECK(stage.footprints.intersections.most == 0);
  for (std::size_t i = 0; i < scene.size(); ++i) scene.means[i] = vec3(0, 0, 4), scene.opacities[i] = 0.7f;
  CHECK(check_projection(stage, scene, forward_camera(320, 200)) == 3000);
}

SWIFTGS_DEVICE_CASE("cuda project: chunks that a view cannot show change no splat") {
  Stage stage, other;
  for (const std::size_t n : {400'000, 1'001, 500'001}) {
    CAPTURE(n);
    const Scene scene = make_builtin_scene(n);
    const DeviceScene uploaded = stage.backend.upload(order_spatially(scene));
    SceneView without = uploaded.view();
    REQUIRE(without.chunks.size == (n + chunk_size - 1) / chunk_size);
    without.chunks = {};
    std::vector<Camera> cameras = builtin_cameras(4, 320, 180);
    Camera beyond = cameras[0], close = cameras[1];
    beyond.translation.z -= 1000;
    close.fx *= 12, close.fy *= 12;
    cameras.insert(cameras.end(), {beyond, close, cameras[2]});
    std::size_t least = n;
    for (const Camera& camera : cameras) {
      const SplatSet expected = other.run(without, camera);
      const SplatSet set = stage.run(uploaded.view(), camera);
      CHECK(same_splats(set, expected));
      CHECK(stage.found_tiles(set, camera));
      least = std::min(least, set.shapes.size());
    }
    CHECK(least == 0);
  }
}

SWIFTGS_DEVICE_CASE("cuda project: colours of a frame that is given up do not get into the next") {
  Stage stage, other;
  const DeviceScene scene = stage.backend.upload(random_scene(200'000, 3, 9));
  const Camera near = forward_camera(640, 360), wide = forward_camera(1280, 360);
  const SplatSet expected = other.run(scene.view(), near);
  for (int i = 0; i < 20; ++i) {
    const OneView frame(wide, Conventions::gsplat(), scene.view());
    project(stage.backend, frame.plan(), Ellipse{}, stage.scratch, stage.splats, stage.footprints);
    (void)shade(stage.backend, frame.plan(), stage.splats, stage.colours);
    CHECK(same_bits(stage.run(scene.view(), near).colours, expected.colours));
  }
}

SWIFTGS_DEVICE_CASE("cuda project: whether a splat is colourless is said of each frame anew") {
  Stage stage;
  const DeviceScene usual = stage.backend.upload(random_scene(3000, 3, 10));
  const DeviceScene overflowing = stage.backend.upload(scene_with_colourless(3000, 10));
  const Camera camera = forward_camera(320, 200);
  const auto has_colourless = [&](const DeviceScene& scene) {
    const OneView frame(camera, Conventions::gsplat(), scene.view());
    Footprints<Cuda>& footprints = stage.footprints;
    project(stage.backend, frame.plan(), Ellipse{}, stage.scratch, stage.splats, footprints);
    const auto word = [&](Shading<Cuda> shading) {
      return to_host(stage.backend, Span<const std::uint32_t>{shading.finish().colourless, 1}).at(0);
    };
    const std::uint32_t counted_there = word(shade(stage.backend, frame.plan(), stage.splats, stage.colours));
    bin(stage.backend, frame.plan(), Ellipse{}, stage.splats, footprints);
    REQUIRE(stage.splats.count > 100);
    CHECK(word(shade(stage.backend, frame.plan(), stage.splats, stage.colours)) == counted_there);
    return counted_there != 0;
  };
  for (const bool some : {false, true, true, false, false})
    CHECK(has_colourless(some ? overflowing : usual) == some);
}

SWIFTGS_DEVICE_CASE("cuda project: tiles of splats whose number the host knows are found within limits") {
  Stage stage;
  const DeviceScene scene = stage.backend.upload(random_scene(20'000, 0, 4));
  const Camera camera = forward_camera(320, 200);
  const SplatSet set = stage.run(scene.view(), camera);
  const OneView frame(camera, Conventions::gsplat(), scene.view());
  const std::uint64_t intersections = stage.footprints.intersections.get();
  REQUIRE(intersections > 1000);
  Footprints<Cuda> footprints;
  const auto report_within = [&](std::size_t capacity) {
    stage.splats.set_count(set.shapes.size());
    const Limits limits{{0, capacity}};
    bin(stage.backend, frame.plan(limits), Ellipse{}, stage.splats, footprints);
    CHECK(footprints.intersections.most == capacity);
    return await_report(stage.backend, stage.splats, footprints, limits);
  };
  for (const std::size_t capacity : {std::size_t(1), std::size_t(intersections - 1),
                                     std::size_t(intersections), 2 * std::size_t(intersections)}) {
    CAPTURE(capacity);
    const FrameReport report = report_within(capacity);
    CHECK(report.visible == set.shapes.size());
    CHECK(report.intersections == intersections);
    CHECK((report.overflowed != 0) == (capacity < intersections));
    CHECK(same_bits(to_host(stage.backend, footprints.view().each),
                    to_host(stage.backend, stage.footprints.view().each)));
  }
  stage.splats.set_count(0);
  bin(stage.backend, frame.plan({{0, 10}}), Ellipse{}, stage.splats, footprints);
  CHECK(await_report(stage.backend, stage.splats, footprints, {{0, 10}}).intersections == 0);
}

SWIFTGS_DEVICE_CASE("cuda project: footprints of another grid or other bounds are found again") {
  Cuda cuda;
  const DeviceScene scene = cuda.upload(random_scene(3000, 0, 11));
  ProjectScratch<Cuda> scratch;
  Splats<Cuda> splats;
  Footprints<Cuda> boxes, ellipses;
  const OneView frame(forward_camera(700, 500), Conventions::gsplat(), scene.view());
  const View turned = view_without_camera(500, 700);
  project(cuda, frame.plan(), OpacityBox{}, scratch, splats, boxes);
  bin(cuda, frame.plan(), Ellipse{}, splats, ellipses);
  const SplatSet set = to_host(cuda, splats.view());
  REQUIRE(set.shapes.size() > 100);
  const auto found_by = [&](const auto& bounds, const Footprints<Cuda>& footprints, const View& of) {
    return found_tiles(cuda, set.shapes, footprints, {&of, 1}, bounds) && footprints.views[0].grid == of.grid;
  };
  CHECK(found_by(Ellipse{}, ellipses, frame.view));
  bin(cuda, frame.plan(), OpacityBox{}, splats, boxes);
  CHECK(found_by(OpacityBox{}, boxes, frame.view));
  bin(cuda, plan_without_scene({&turned, 1}), OpacityBox{}, splats, boxes);
  CHECK(found_by(OpacityBox{}, boxes, turned));

  // Footprints that were found within other bounds are found again where they lie.
  project(cuda, frame.plan(), OpacityBox{}, scratch, splats, boxes);
  bin(cuda, frame.plan(), Ellipse{}, splats, boxes);
  CHECK(found_by(Ellipse{}, boxes, frame.view));

  // Footprints that are left over from a projection are not those of other splats.
  project(cuda, frame.plan(), OpacityBox{}, scratch, splats, boxes);
  Splats<Cuda> own;
  CopySplats<Cuda>::copy(SplatsOn<Cuda>(cuda, set).view(), own);
  bin(cuda, frame.plan(), OpacityBox{}, own, boxes);
  CHECK(found_by(OpacityBox{}, boxes, frame.view));

  // Of several views.
  const std::vector<View> asked = views_without_planes(different_views());
  ViewStorage<Cuda> storage;
  const FramePlan plan(store_views(cuda, Span<const View>{asked.data(), asked.size()}, storage),
                       scene.view());
  project(cuda, plan, OpacityBox{}, scratch, splats, boxes);
  bin(cuda, plan, Ellipse{}, splats, ellipses);
  const SplatsView found = splats.view();
  REQUIRE(found.size() > 500);
  CHECK(found_tiles(cuda, to_host(cuda, found.shapes), ellipses, plan.views, Ellipse{},
                    to_host(cuda, Span<const std::uint16_t>{found.of_view, found.size()})));
}
