// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstddef>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include <doctest/doctest.h>
#include <sys/mman.h>
#include <unistd.h>

#include "policies/rasterizers.hpp"

namespace swiftgs::test::needless_work_test {

namespace {

/// Harmonics of `count` Gaussians, two pages each, so that the machine itself reports a read: the
/// coefficients of degree `degree` end where the second page begins, which nobody may touch.
class GuardedHarmonics {
 public:
  GuardedHarmonics(std::size_t count, int degree)
      : page_(std::size_t(sysconf(_SC_PAGESIZE))),
        bytes_(2 * page_ * count),
        used_(12 * std::size_t(sh_rest_count(degree))) {
    void* memory = mmap(nullptr, bytes_, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (memory == MAP_FAILED) throw std::runtime_error("mmap failed");
    memory_ = static_cast<char*>(memory);
    for (std::size_t i = 0; i < count; ++i) protect(2 * i + 1);
  }
  ~GuardedHarmonics() { munmap(memory_, bytes_); }
  GuardedHarmonics(const GuardedHarmonics&) = delete;
  GuardedHarmonics& operator=(const GuardedHarmonics&) = delete;

  /// From now on a read of the harmonics of Gaussian `i` ends the program.
  void forbid(std::size_t i) { protect(2 * i); }

  float* of(std::size_t i) { return reinterpret_cast<float*>(memory_ + 2 * page_ * i + page_ - used_); }
  StridedSpan<const float> rows() { return {of(0), bytes_ / (2 * page_), 2 * page_}; }

 private:
  void protect(std::size_t page) {
    if (mprotect(memory_ + page * page_, page_, PROT_NONE) != 0) throw std::runtime_error("mprotect failed");
  }
  std::size_t page_, bytes_, used_;
  char* memory_ = nullptr;
};

/// What projection and shading make of `scene`.
template <class B>
std::vector<SplatColour> colours(B& backend, const SceneView& scene, const Camera& camera) {
  ProjectScratch<B> scratch;
  Splats<B> splats;
  Footprints<B> footprints;
  const OneView frame(camera, Conventions::gsplat(), scene);
  project(backend, frame.plan(), Ellipse(), scratch, splats, footprints);
  Colours<B> colours;
  const ColoursView shaded = shade(backend, frame.plan(), splats, colours).finish();
  return {shaded.each.begin(), shaded.each.end()};
}

/// Notes what it is asked to sort.
class RecordingBackend : public Serial {
 public:
  template <class Key>
  void sort_pairs(Pairs<RecordingBackend, Key>&, Count n, int bits) {
    calls.push_back(std::to_string(8 * sizeof(Key)) + "-bit keys, " + std::to_string(n.get()) + " pairs, " +
                    std::to_string(bits) + " bits");
  }
  std::vector<std::string> calls;
};

}  // namespace

SWIFTGS_CASE_ON("no needless work: harmonics of culled Gaussians are not read", SWIFTGS_TEST_HOSTS) {
  Scene scene;
  const std::size_t count = 90;
  GuardedHarmonics harmonics(count, 3);
  std::size_t visible = 0;
  for (std::size_t i = 0; i < count; ++i) {
    append(scene, vec3(0, 0, 4), 0.05f, 0.8f);
    vec3& mean = scene.means[i];
    if (i % 9 == 0) ++visible;
    if (i % 9 == 1) mean.z = -4;                   // behind
    if (i % 9 == 2) mean.z = 0.009f;               // nearer than the near plane
    if (i % 9 == 3) mean.z = 2e10f;                // beyond the far plane
    if (i % 9 == 4) mean.x = 40;                   // right of the image
    if (i % 9 == 5) mean.y = -40;                  // above the image
    if (i % 9 == 6) scene.opacities[i] = 0.0039f;  // less than 1/255
    if (i % 9 == 7) scene.opacities[i] = 0;
    if (i % 9 == 8) mean = vec3(std::numeric_limits<float>::quiet_NaN());
    if (i % 9 != 0) harmonics.forbid(i);
  }
  SceneView view = swiftgs::view(scene);
  view.sh_rest = harmonics.rows(), view.sh_degree = 3;
  CHECK(colours(backend, view, forward_camera(64, 48)).size() == visible);
}

SWIFTGS_CASE_ON("no needless work: bands above the degree of the view are not read", SWIFTGS_TEST_HOSTS) {
  for (int degree = 0; degree <= max_sh_degree; ++degree) {
    CAPTURE(degree);
    Scene scene = random_scene(50, degree, 1);
    GuardedHarmonics harmonics(scene.size(), degree);
    const std::size_t used = 3 * std::size_t(sh_rest_count(degree));
    for (std::size_t i = 0; i < scene.size(); ++i)
      std::copy_n(scene.sh_rest.begin() + std::ptrdiff_t(i * used), used, harmonics.of(i));
    SceneView view = swiftgs::view(scene);
    const std::vector<SplatColour> expected = colours(backend, view, forward_camera(64, 48));
    view.sh_rest = harmonics.rows();
    const std::vector<SplatColour> guarded = colours(backend, view, forward_camera(64, 48));
    REQUIRE(guarded.size() == expected.size());
    CHECK(guarded.size() > 10);
    bool same = true;
    for (std::size_t i = 0; i < guarded.size(); ++i) same = same && guarded[i].rgb == expected[i].rgb;
    CHECK(same);
  }
}

SWIFTGS_CASE_ON("no needless work: bands that are all zero are not evaluated", SWIFTGS_TEST_HOSTS) {
  Scene scene = random_scene(100, 3, 2);
  for (std::size_t i = 0; i < scene.size(); ++i)
    for (std::size_t k = 9; k < 45; ++k) scene.sh_rest[45 * i + k] = 0;
  const auto uploaded = backend.upload(scene);
  CHECK(uploaded.view().sh_degree == 1);
  CHECK(uploaded.view().sh_rest.stride == 45 * sizeof(float));
  scene.sh_rest.assign(scene.sh_rest.size(), 0.0f);
  CHECK(backend.upload(scene).view().sh_degree == 0);
  scene.sh_rest.back() = -1e-20f;
  CHECK(backend.upload(scene).view().sh_degree == 3);
}

TEST_CASE("no needless work: only as many key bits are sorted as tell the tiles apart") {
  const SplatSet splats = random_splats(10, 640, 480, 3);
  RecordingBackend backend;
  const SortInput job = splats.job(640, 480);  // 1,200 tiles: 11 bits
  const std::size_t intersections = build_lists<StandardSort, Ellipse>(backend, job).intersections;
  build_lists<EarlySort, Ellipse>(backend, job);
  build_lists<StandardSort, Ellipse>(backend, splats.job(16, 16));
  const std::string pairs = std::to_string(intersections) + " pairs, ";
  CHECK(backend.calls[0] == "64-bit keys, " + pairs + "42 bits");
  CHECK(backend.calls[1] == "32-bit keys, 10 pairs, 31 bits");
  CHECK(backend.calls[2] == "32-bit keys, " + pairs + "11 bits");
  CHECK(backend.calls[3].find(", 31 bits") != std::string::npos);  // one tile: depth alone
}

SWIFTGS_CASE_ON("no needless work: tiles without splats cost nothing but the background",
                SWIFTGS_TEST_HOSTS) {
  SplatSet splats;
  splats.add(make_splat(40, 24, 1, 1, 0, 0.9), 1);  // inside tile (2, 1)
  const SortInput job = splats.job(96, 64);
  const TileLists<B> lists = build_lists<EarlySort, Ellipse>(backend, job);
  with_each_raster<B>([&](const BoundRaster<B>& raster) {
    Frame frame;
    const View view = view_into(prepare(frame, 96, 64, {}), {.background = vec3(2)});
    std::vector<RasterCounts> counts(RasterBlocks(tiles_of_frame(view)).size(), {9, 9, 9, 9});
    raster.rasterize(backend,
                     {splats.view(), splats.colours_view(), lists.view(), {&view, 1}, counts.data()});
    for (std::size_t block = 0; block < counts.size(); ++block) {
      CAPTURE(block);
      const std::uint64_t one = block == 8;
      CHECK(counts[block].intersections_visited == one);
      CHECK((counts[block].rows_visited > 0) == one);
      CHECK((counts[block].contributing_pairs > 0) == one);
    }
    CHECK(frame.colour[0] == 2);
  });
}

SWIFTGS_CASE_ON("no needless work: a tile stops when all its pixels have", SWIFTGS_TEST_HOSTS) {
  SplatSet splats;
  for (int i = 0; i < 1000; ++i) splats.add(make_splat(8, 8, 500, 500, 0, 0.99), 1.0f + float(i));
  with_each_raster<B>([&](const BoundRaster<B>& raster) {
    const RasterCounts counts = draw(backend, raster, splats, 32, 16).counts;
    CHECK(counts.pixels_stopped == 32 * 16);
    // Two splats fill a pixel and the third ends it; a backend may look at lists in batches.
    CHECK(counts.intersections_visited >= 2 * 3);
    CHECK(counts.intersections_visited <= 2 * 64);
    CHECK(counts.contributing_pairs < 32 * 16 * 3);
  });
}

SWIFTGS_CASE_ON("no needless work: rows outside a splat's extent are not visited", SWIFTGS_TEST_HOSTS) {
  // Of standard deviation 1 and opacity 1 it ends 3.33 pixels above and below its centre: seven rows.
  SplatSet splats;
  splats.add(make_splat(8.5, 8.5, 1, 1, 0, 1), 1);
  with_each_raster<B>([&](const BoundRaster<B>& raster) {
    const RasterCounts counts = draw(backend, raster, splats, 16, 16).counts;
    CHECK(counts.intersections_visited == 1);
    CHECK(counts.rows_visited == 7);
    CHECK(counts.contributing_pairs == 37);  // pixels whose distance from the centre is at most 3.33
  });
}

TEST_CASE_TEMPLATE("no needless work: outputs that are not asked for are not there", B, SWIFTGS_TEST_HOSTS) {
  Renderer<B, EarlySort, AxisSharedThreshold<FloatCholesky>, Ellipse> renderer(make_backend<B>());
  const auto scene = renderer.backend().upload(random_scene(50, 0, 4));
  RenderSettings settings;
  Frame frame = renderer.render(scene, forward_camera(40, 30), settings);
  CHECK(frame.colour.size() == 40 * 30 * 3);
  CHECK(frame.alpha.empty());
  CHECK(frame.depth.empty());
  settings.outputs.depth = true;
  renderer.render(scene, forward_camera(40, 30), settings, frame);
  CHECK(frame.alpha.empty());
  CHECK(frame.depth.size() == 40 * 30);
  CHECK(renderer.statistics().raster.contributing_pairs == 0);  // not asked for either
}

TEST_CASE("cpu: a device is named by the threads that oneTBB lets run") {
  const Cpu backend(4);
  CHECK(backend.device_name().ends_with(", 4 threads"));
  const tbb::global_control two(tbb::global_control::max_allowed_parallelism, 2);
  CHECK(backend.device_name().ends_with(", 2 threads"));
}

}  // namespace swiftgs::test::needless_work_test
