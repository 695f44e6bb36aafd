// SPDX-License-Identifier: Apache-2.0
#include <filesystem>
#include <set>

#include <swiftgs/edit/order.hpp>
#include <swiftgs/memory/harmonic_packing.hpp>
#include <swiftgs/serial.hpp>

#include "scenes.hpp"
#include "support/skip.hpp"

namespace swiftgs::test::real_formats_test {

namespace {

const std::filesystem::path folder =
#ifdef SWIFTGS_FORMATS_DIR
    SWIFTGS_FORMATS_DIR;
#else
    "";
#endif

const std::filesystem::path scenes =
#ifdef SWIFTGS_SCENES_DIR
    SWIFTGS_SCENES_DIR;
#else
    "";
#endif

bool skipped() {
  if (folder.empty()) test::skip("no folder of real files");
  return folder.empty();
}

}  // namespace

TEST_CASE("real files: files of other programs are read") {
  if (skipped()) return;
  const struct {
    const char *name, *format;
    std::size_t gaussians;
    int degree = 0;
  } cases[] = {{"fox_5k.ply", "INRIA PLY (binary_little_endian)", 5000, 3},
               {"biker.spz", "SPZ version 4", 152'746},
               {"massa.sog", "SOG version 2", 58'649},
               {"guitar.compressed.ply", "compressed PLY", 90'854},
               {"luma_seal.splat", ".splat", 101'780}};
  for (const auto& [name, format, gaussians, degree] : cases) {
    CAPTURE(name);
    const SceneFile file = read_scene(folder / name);
    CHECK(file.format == format);
    CHECK(file.stored == gaussians);
    CHECK(file.left_out.total() == 0);
    CHECK(file.scene.sh_degree == degree);
    if (contains(format, "SOG") || contains(format, "splat")) CHECK(file.notes.empty());
    for (const Quaternion& q : file.scene.rotations)
      REQUIRE(std::abs(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z - 1) < 1e-5);
    if (!contains(format, "INRIA"))
      for (const vec3& mean : file.scene.means)
        REQUIRE(std::abs(mean.x) + std::abs(mean.y) + std::abs(mean.z) < 100);
  }
}

TEST_CASE("real files: one Gaussian of a SOG is what PlayCanvas's own reader makes of it") {
  if (skipped()) return;
  const Scene scene = subset(load_scene(folder / "massa.sog"), {12'345});
  const Scene expected{.means = {{0.166090608f, -1.39745462f, -0.274810314f}},
                       .scales = {{0.000969918328f, 0.0115040196f, 0.00292622228f}},
                       .rotations = {{0.732478261f, 0.457539678f, 0.047140453f, -0.50190717f}},
                       .opacities = {0.984313726f},
                       .sh0 = {{-0.354490757f, -0.590817928f, -0.938357949f}},
                       .sh_rest = {}};
  const Difference apart = difference(expected, scene);
  CHECK(apart.means == 0);
  for (const double difference : {apart.scales, apart.rotations, apart.opacities, apart.sh0})
    CHECK(difference < 1e-6);
}

TEST_CASE("real files: a PLY and an SPZ of one scene have the same axes") {
  if (skipped()) return;
  if (scenes.empty()) return test::skip("no folder of real scenes");
  // The PLY holds some Gaussians of the SPZ, whose grid is 1/4096 wide.
  using Cell = std::array<long, 3>;
  const auto cell = [](const vec3& p) {
    return Cell{std::lround(p.x * 4096), std::lround(p.y * 4096), std::lround(p.z * 4096)};
  };
  std::set<Cell> cells;
  for (const vec3& mean : load_scene(scenes / "fox/fox.spz").means) cells.insert(cell(mean));
  std::size_t found = 0;
  for (const vec3& mean : load_scene(folder / "fox_5k.ply").means) found += cells.count(cell(mean));
  CHECK(found == 5000);
}

TEST_CASE("real files: a scene that was once an SPZ is written as SPZ without loss") {
  if (skipped()) return;
  const Scene scene = load_scene(folder / "fox_5k.ply");
  const TemporaryFolder temporary;
  for (const int version : {3, 4}) {
    const WrittenScene written = write_scene(temporary / "a.spz", scene, {.spz_version = version});
    CHECK(written.notes.empty());
    CHECK(written.bytes < 125'000);
    const Scene again = load_scene(temporary / "a.spz");
    CHECK(again.means == scene.means);
    CHECK(again.sh_rest == scene.sh_rest);
    const Difference apart = difference(scene, again);
    CHECK(apart.opacities < 1.1e-4);  // the PLY cannot hold 0 and 1
    CHECK(apart.sh0 < 1e-6);
    CHECK(apart.scales < 1e-5);
  }
}

TEST_CASE("real files: harmonics are kept as bytes of an SPZ and as the palette of a SOG") {
  if (skipped()) return;
  if (scenes.empty()) return test::skip("no folder of real scenes");
  const auto kept = [](const Scene& scene) {
    const HarmonicPacking packing(Serial(), scene, 3, HarmonicsKept::smallest);
    return std::string(name_of(packing.rows_at(nullptr, packing.labels().data)));
  };
  CHECK(kept(load_scene(folder / "fox_5k.ply")) == "bytes");  // was once an SPZ
  const Scene scene = load_scene(scenes / "fox/fox.spz");
  CHECK(kept(scene) == "bytes");
  const TemporaryFolder temporary;
  write_scene(temporary / "a.sog", scene);
  CHECK(kept(load_scene(temporary / "a.sog")) == "palette");
}

TEST_CASE("real files: a scene loses no more in a SOG than bytes for its numbers explain") {
  if (skipped()) return;
  const Scene scene = order_spatially(load_scene(folder / "fox_5k.ply"));
  const TemporaryFolder temporary;
  write_scene(temporary / "a.sog", scene);
  const SceneFile file = read_scene(temporary / "a.sog");
  CHECK(file.notes.empty());
  const Scene& read = file.scene;
  REQUIRE(read.size() == 5000);
  CHECK(read.sh0 == scene.sh0);  // the PLY holds fewer than 256 different numbers
  double squares = 0;
  for (std::size_t i = 0; i < scene.sh_rest.size(); ++i)
    squares += std::pow(double(read.sh_rest[i]) - scene.sh_rest[i], 2);
  CHECK(std::sqrt(squares / double(scene.sh_rest.size())) < 1e-3);
  const Difference apart = difference(scene, read);
  CHECK(apart.opacities <= 0.5001f / 255);
  CHECK(apart.means < 3e-4);
  CHECK(apart.scales < 1e-5);
}

}  // namespace swiftgs::test::real_formats_test
