// SPDX-License-Identifier: Apache-2.0

// Projection on the device against the serial backend's.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <tuple>

#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/edit.hpp>

#include "cuda/device.hpp"
#include "policies/contribution_sums.hpp"
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
  const bool same_place = within(a.mean.x, b.mean.x, 2) && within(a.mean.y, b.mean.y, 2);
  const bool same_form = within(a.l0, b.l0, 8) && within(a.l1, b.l1, 8) && within(a.l2, b.l2, 4);
  return same_place && same_form && within(a.opacity, b.opacity, 4) &&
         std::abs(a.cutoff - b.cutoff) <= 1e-6f * std::max(1.0f, b.cutoff) &&
         std::abs(a.half_width - b.half_width) <= 1e-5f * b.half_width + 1e-3f;
}

bool close(const SplatColour& a, const SplatColour& b) {
  bool same = within(a.depth, b.depth, 2);
  for (int c = 0; c < 3; ++c)
    same = same && std::abs(a.rgb[c] - b.rgb[c]) <= 1e-6f * std::max(1.0f, b.rgb[c]);
  return same;
}

/// How the splats of two backends go together.
struct Match {
  std::size_t matched = 0, alone = 0, different = 0;
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
      ++out.matched, ++i, ++j;
    } else if (j == b.shapes.size() || same(i + 1, j)) {
      ++out.alone, ++i;
    } else {
      ++out.alone, ++j;
    }
  }
  return out;
}

/// A projection stage on the device with its memory, which lives from frame to frame.
struct Stage {
  Cuda cuda;
  ProjectScratch<Cuda> scratch;
  Splats<Cuda> splats;
  Colours<Cuda> colours;
  Footprints<Cuda> footprints;

  template <class Bounds>
  SplatSet run(const SceneView& scene, const Camera& camera, const Conventions& conventions, Bounds bounds) {
    const OneView frame(camera, conventions, scene);
    project(cuda, frame.plan(), bounds, scratch, splats, footprints);
    Shading<Cuda> shading = shade(cuda, frame.plan(), splats, colours);
    bin(cuda, frame.plan(), bounds, splats, footprints);
    return to_host(cuda, splats.view(), shading.finish());
  }

  /// Whether the tiles of every splat are those of the bounds.
  template <class Bounds>
  bool found_tiles(const SplatSet& set, const Camera& camera, Bounds bounds) {
    const TileGrid grid = TileGrid::covering(camera.width, camera.height);
    const std::vector<Footprint> found = to_host(cuda, footprints.view().each);
    std::uint64_t sum = 0;
    bool same = found.size() == set.shapes.size() &&
                footprints.views.tiles == tiles_of_frame(view_without_camera(camera.width, camera.height));
    for (std::size_t i = 0; same && i < found.size(); ++i) {
      const Footprint expected = find_footprint(bounds, set.shapes[i], grid);
      same = found[i].count == expected.count &&
             (expected.count == 0 || (found[i].mask == expected.mask && found[i].first == expected.first));
      sum += found[i].count;
    }
    return same && sum == footprints.intersections.most;
  }
};

SplatSet project_on_host(const SceneView& scene, const Camera& camera, const Conventions& conventions) {
  Serial serial;
  ProjectScratch<Serial> scratch;
  Splats<Serial> splats;
  Footprints<Serial> footprints;
  const OneView frame(camera, conventions, scene);
  project(serial, frame.plan(), Ellipse{}, scratch, splats, footprints);
  Colours<Serial> colours;
  const ColoursView shaded = shade(serial, frame.plan(), splats, colours).finish();
  const auto to_vector = [](auto span) { return std::vector(span.begin(), span.end()); };
  const SplatsView view = splats.view();
  return {to_vector(view.shapes), to_vector(view.depths), to_vector(view.gaussians), to_vector(shaded.each)};
}

/// Projects one scene on both. Returns the number of splats on the device.
std::size_t check_projection(Stage& stage, const SceneView& on_device, const SceneView& on_host,
                             const Camera& camera, const Conventions& conventions = Conventions::gsplat()) {
  const SplatSet expected = project_on_host(on_host, camera, conventions);
  const SplatSet set = stage.run(on_device, camera, conventions, Ellipse{});
  CHECK(stage.found_tiles(set, camera, Ellipse{}));
  const Match result = match(set, expected);
  CAPTURE(on_host.size());
  CHECK(result.different == 0);
  CHECK(result.alone <= 1 + expected.shapes.size() / 10'000);
  for_each_type(AllBounds(), [&]<class Bounds>(Bounds bounds) {
    CAPTURE(Bounds::name);
    const SplatSet again = stage.run(on_device, camera, conventions, bounds);
    CHECK(same_bits(again.shapes, set.shapes));
    CHECK(same_bits(again.depths, set.depths));
    CHECK(same_bits(again.gaussians, set.gaussians));
    CHECK(same_bits(again.colours, set.colours));
    CHECK(stage.found_tiles(again, camera, bounds));
  });
  return set.shapes.size();
}
std::size_t check_projection(Stage& stage, const Scene& scene, const Camera& camera,
                             const Conventions& conventions = Conventions::gsplat()) {
  const DeviceScene uploaded = stage.cuda.upload(scene);
  return check_projection(stage, uploaded.view(), view(scene), camera, conventions);
}

}  // namespace

TEST_CASE("cuda project: splats are the serial backend's for every number of Gaussians and SH degree") {
  if (without_device()) return;
  for (const int degree : {0, 1, 2, 3})
    for (const std::size_t n : {0, 1, 2, 31, 33, 255, 256, 257, 20'000}) {
      CAPTURE(degree);
      Stage stage;
      check_projection(stage, random_scene(n, degree, n + 1), forward_camera(320, 200));
    }
}

TEST_CASE("cuda project: splats of a hundred thousand Gaussians are the serial backend's with both presets") {
  if (without_device()) return;
  Stage stage;
  const Scene scene = random_scene(100'000, 1, 3);
  Conventions antialiased = Conventions::gsplat();
  antialiased.antialiased = true;
  for (const Conventions& conventions : {Conventions::gsplat(), Conventions::inria(), antialiased})
    CHECK(check_projection(stage, scene, forward_camera(640, 360), conventions) > 10'000);
}

TEST_CASE("cuda project: splats of the built-in scene are the serial backend's from every side") {
  if (without_device()) return;
  Stage stage;
  const Scene scene = make_builtin_scene(20'000);
  for (const Camera& camera : builtin_cameras(6, 320, 180))
    CHECK(check_projection(stage, scene, camera) > 1000);
}

TEST_CASE("cuda project: a principal point may lie outside the image and the image be as large as it may") {
  if (without_device()) return;
  Stage stage;
  const Scene scene = random_scene(5000, 0, 4);
  Camera camera = forward_camera(200, 100);
  camera.cx = -60, camera.cy = 170;
  check_projection(stage, scene, camera);
  check_projection(stage, scene, forward_camera(max_image_side, 40));
  check_projection(stage, random_scene(300, 0, 5), forward_camera(max_image_side, max_image_side));
}

TEST_CASE("cuda project: only the bands that a view asks for are read") {
  if (without_device()) return;
  Stage stage;
  const Scene scene = random_scene(3000, 3, 5);
  const DeviceScene uploaded = stage.cuda.upload(scene);
  for (const int degree : {0, 1, 2}) {
    CAPTURE(degree);
    SceneView on_device = uploaded.view(), on_host = view(scene);
    on_device.sh_degree = on_host.sh_degree = degree;
    check_projection(stage, on_device, on_host, forward_camera(320, 200));
  }
}

TEST_CASE("cuda project: coefficients may lie further apart than their bands need and begin anywhere") {
  if (without_device()) return;
  Stage stage;
  const Camera camera = forward_camera(320, 200);
  for (const int degree : {1, 2, 3}) {
    const Scene scene = random_scene(1000, degree, 6);
    const DeviceScene uploaded = stage.cuda.upload(scene);
    const std::size_t used = 3 * std::size_t(sh_rest_count(degree));
    for (const std::size_t stride : {used, used + 1, used + 2, used + 3, used + 4, std::size_t(48)})
      for (const std::size_t begin : {0, 1, 2, 4}) {
        CAPTURE(degree);
        CAPTURE(stride);
        CAPTURE(begin);
        // What lies between must not be used, and nothing behind the last coefficient be touched.
        std::vector<float> spread(begin + (scene.size() - 1) * stride + used, NAN);
        for (std::size_t i = 0; i < scene.size(); ++i)
          std::copy_n(&scene.sh_rest[used * i], used, &spread[begin + stride * i]);
        const ExactMemory coefficients(spread);
        SceneView on_device = uploaded.view();
        on_device.sh_rest = {coefficients.data + begin, spread.size() - begin};
        on_device.sh_stride = int(stride);
        const SplatSet expected = project_on_host(view(scene), camera, Conventions::gsplat());
        const Match result = match(stage.run(on_device, camera, Conventions::gsplat(), Ellipse{}), expected);
        CHECK(result.different == 0);
        CHECK(result.alone <= 1);
      }
  }
}

TEST_CASE("cuda project: nothing may be visible or all") {
  if (without_device()) return;
  Stage stage;
  Scene scene = random_scene(3000, 1, 7);
  for (vec3& mean : scene.means) mean = vec3(mean.x, mean.y, -1 - std::abs(mean.z));
  CHECK(check_projection(stage, scene, forward_camera(320, 200)) == 0);
  CHECK(stage.footprints.intersections.most == 0);
  for (std::size_t i = 0; i < scene.size(); ++i) scene.means[i] = vec3(0, 0, 4), scene.opacities[i] = 0.7f;
  CHECK(check_projection(stage, scene, forward_camera(320, 200)) == 3000);
}

TEST_CASE("cuda project: scenes may grow and shrink from frame to frame") {
  if (without_device()) return;
  // Each number of frames before a larger scene, odd and even, since memory alternates.
  for (const int frames : {1, 2, 3}) {
    CAPTURE(frames);
    Stage stage;
    for (const std::size_t n : {100, 5000, 300, 9000, 9000, 0, 20'000}) {
      CAPTURE(n);
      const Scene scene = random_scene(n, 0, n + 1);
      const DeviceScene uploaded = stage.cuda.upload(scene);
      for (int frame = 0; frame < frames; ++frame) {
        CAPTURE(frame);
        const SplatSet set =
            stage.run(uploaded.view(), forward_camera(320, 200), Conventions::gsplat(), Ellipse{});
        CHECK(stage.found_tiles(set, forward_camera(320, 200), Ellipse{}));
        CHECK(
            match(set, project_on_host(view(scene), forward_camera(320, 200), Conventions::gsplat())).alone <=
            2);
      }
    }
  }
}

TEST_CASE("cuda project: chunks that a view cannot show change no splat") {
  if (without_device()) return;
  Stage stage, other;
  for (const std::size_t n : {400'000, 1'001, 500'001}) {
    CAPTURE(n);
    const Scene scene = make_builtin_scene(n);
    const DeviceScene uploaded = stage.cuda.upload(order_spatially(scene));
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
      const SplatSet expected = other.run(without, camera, Conventions::gsplat(), Ellipse{});
      const SplatSet set = stage.run(uploaded.view(), camera, Conventions::gsplat(), Ellipse{});
      CHECK(same_bits(set.shapes, expected.shapes));
      CHECK(same_bits(set.depths, expected.depths));
      CHECK(same_bits(set.gaussians, expected.gaussians));
      CHECK(same_bits(set.colours, expected.colours));
      CHECK(stage.found_tiles(set, camera, Ellipse{}));
      least = std::min(least, set.shapes.size());
    }
    CHECK(least == 0);
  }
}

TEST_CASE("cuda project: colours of a frame that is given up do not get into the next") {
  if (without_device()) return;
  Stage stage, other;
  const DeviceScene scene = stage.cuda.upload(random_scene(200'000, 3, 9));
  const Camera near = forward_camera(640, 360), wide = forward_camera(1280, 360);
  const SplatSet expected = other.run(scene.view(), near, Conventions::gsplat(), Ellipse{});
  for (int i = 0; i < 20; ++i) {
    const OneView frame(wide, Conventions::gsplat(), scene.view());
    project(stage.cuda, frame.plan(), Ellipse{}, stage.scratch, stage.splats, stage.footprints);
    (void)shade(stage.cuda, frame.plan(), stage.splats, stage.colours);
    CHECK(
        same_bits(stage.run(scene.view(), near, Conventions::gsplat(), Ellipse{}).colours, expected.colours));
  }
}

TEST_CASE("cuda project: whether a splat is hidden is said of each frame anew") {
  if (without_device()) return;
  Stage stage;
  const DeviceScene usual = stage.cuda.upload(random_scene(3000, 3, 10));
  const DeviceScene hiding = stage.cuda.upload(scene_with_hidden(3000, 10));
  const Camera camera = forward_camera(320, 200);
  const auto hides = [&](const DeviceScene& scene) {
    const OneView frame(camera, Conventions::gsplat(), scene.view());
    Footprints<Cuda>& footprints = stage.footprints;
    project(stage.cuda, frame.plan(), Ellipse{}, stage.scratch, stage.splats, footprints);
    const auto word = [&](Shading<Cuda> shading) {
      return to_host(stage.cuda, Span<const std::uint32_t>{shading.finish().hidden, 1}).at(0);
    };
    const std::uint32_t counted_there = word(shade(stage.cuda, frame.plan(), stage.splats, stage.colours));
    bin(stage.cuda, frame.plan(), Ellipse{}, stage.splats, footprints);
    REQUIRE(stage.splats.count > 100);
    CHECK(word(shade(stage.cuda, frame.plan(), stage.splats, stage.colours)) == counted_there);
    return counted_there != 0;
  };
  for (const bool hidden : {false, true, true, false, false}) CHECK(hides(hidden ? hiding : usual) == hidden);
}

TEST_CASE("cuda project: tiles of splats whose number the host knows are found within limits") {
  if (without_device()) return;
  Stage stage;
  const DeviceScene scene = stage.cuda.upload(random_scene(20'000, 0, 4));
  const Camera camera = forward_camera(320, 200);
  const SplatSet set = stage.run(scene.view(), camera, Conventions::gsplat(), Ellipse{});
  const OneView frame(camera, Conventions::gsplat(), scene.view());
  const std::uint64_t intersections = stage.footprints.intersections.get();
  REQUIRE(intersections > 1000);
  Footprints<Cuda> footprints;
  const auto report_within = [&](std::size_t capacity) {
    stage.splats.set_count(set.shapes.size());
    const Limits limits{{0, capacity}};
    bin(stage.cuda, frame.plan(limits), Ellipse{}, stage.splats, footprints);
    CHECK(footprints.intersections.most == capacity);
    return await_report(stage.cuda, stage.splats, footprints, limits);
  };
  for (const std::size_t capacity : {std::size_t(1), std::size_t(intersections - 1),
                                     std::size_t(intersections), 2 * std::size_t(intersections)}) {
    CAPTURE(capacity);
    const FrameReport report = report_within(capacity);
    CHECK(report.visible == set.shapes.size());
    CHECK(report.intersections == intersections);
    CHECK((report.overflowed != 0) == (capacity < intersections));
    CHECK(same_bits(to_host(stage.cuda, footprints.view().each),
                    to_host(stage.cuda, stage.footprints.view().each)));
  }
  stage.splats.set_count(0);
  bin(stage.cuda, frame.plan({{0, 10}}), Ellipse{}, stage.splats, footprints);
  CHECK(await_report(stage.cuda, stage.splats, footprints, {{0, 10}}).intersections == 0);
}

TEST_CASE("cuda project: every run gives the same bits") {
  if (without_device()) return;
  Stage stage;
  const DeviceScene scene = stage.cuda.upload(random_scene(100'000, 3, 8));
  const Camera camera = forward_camera(640, 360);
  const auto run = [&] { return stage.run(scene.view(), camera, Conventions::gsplat(), Ellipse{}); };
  const SplatSet first = run();
  const std::vector<Footprint> footprints = to_host(stage.cuda, stage.footprints.view().each);
  for (int i = 0; i < 10; ++i) {
    const SplatSet again = run();
    CHECK(same_bits(again.shapes, first.shapes));
    CHECK(same_bits(again.colours, first.colours));
    CHECK(same_bits(to_host(stage.cuda, stage.footprints.view().each), footprints));
  }
}

TEST_CASE("cuda project: footprints are found again where projection found those of another grid or bounds") {
  if (without_device()) return;
  Cuda cuda;
  const DeviceScene scene = cuda.upload(random_scene(3000, 0, 11));
  ProjectScratch<Cuda> scratch;
  Splats<Cuda> splats;
  Footprints<Cuda> boxes;
  Footprints<Cuda> ellipses;
  const OneView frame(forward_camera(700, 500), Conventions::gsplat(), scene.view());
  const View turned = view_without_camera(500, 700);
  project(cuda, frame.plan(), OpacityBox{}, scratch, splats, boxes);
  bin(cuda, frame.plan(), Ellipse{}, splats, ellipses);
  const SplatSet set = to_host(cuda, splats.view());
  const auto found_by = [&](const auto& bounds, const Footprints<Cuda>& footprints, const View& of) {
    std::uint64_t tiles = 0;
    for (const SplatShape& shape : set.shapes) tiles += find_footprint(bounds, shape, of.grid).count;
    return footprints.intersections.most == tiles && footprints.count == set.shapes.size() &&
           footprints.views.tiles == tiles_of_frame(of) && footprints.views[0].grid == of.grid;
  };
  REQUIRE(set.shapes.size() > 100);
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
}
