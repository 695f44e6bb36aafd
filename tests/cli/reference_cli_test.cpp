// SPDX-License-Identifier: Apache-2.0
#include <cstddef>
#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/metrics.hpp>
#include <swiftgs/stress.hpp>

#include "cli/pictures.hpp"

namespace swiftgs::test::reference_cli_test {

namespace {

/// The doubles of a .npy of this shape.
std::vector<double> array_in(const std::filesystem::path& file, const std::string& shape, std::size_t count) {
  const std::string bytes = content_of(file);
  CHECK(contains(bytes, "'descr': '<f8', 'fortran_order': False, 'shape': " + shape + ", }"));
  REQUIRE(bytes.size() > sizeof(double) * count);
  CHECK((bytes.size() - sizeof(double) * count) % 64 == 0);
  std::vector<double> values(count);
  std::memcpy(values.data(), bytes.data() + bytes.size() - sizeof(double) * count, sizeof(double) * count);
  return values;
}

}  // namespace

TEST_CASE("cli: render writes the reference's doubles and how far each pixel is ambiguous") {
  const TemporaryFolder place;
  const std::string render = "render builtin:300 --scale 0.05 --renderer reference --format ";
  check_holds(run(place, render + "npy").out, {"renders/front.npy  64x36\n"});
  const std::vector<double> image = array_in(place / "renders/front.npy", "(36, 64, 4, )", 36 * 64 * 4);
  const std::vector<double> ambiguous =
      array_in(place / "renders/front.ambiguous.npy", "(36, 64, )", 36 * 64);
  const Camera camera = scaled(builtin_camera(1280, 720), 0.05);
  const ConditionedFrame expected =
      render_conditioned(make_builtin_scene(300), camera, Conventions::gsplat());
  std::size_t wrong = 0;
  for (std::size_t i = 0; i < expected.frame.alpha.size(); ++i) {
    for (std::size_t c = 0; c < 3; ++c) wrong += image[4 * i + c] != expected.frame.colour[3 * i + c];
    wrong += image[4 * i + 3] != expected.frame.alpha[i];
    wrong += (ambiguous[i] > 0) != (expected.ambiguous[0][i] > 0);
  }
  CHECK(wrong == 0);
  run(place, render + "pfm");
  run(place, "render builtin:300 --scale 0.05 --format pfm --out floats");
  CHECK(psnr(read_image(place / "renders/front.pfm").pixels, read_image(place / "floats/front.pfm").pixels) >
        120);
}

TEST_CASE("cli: a list of scenes is the reference's as it is a renderer's") {
  const TemporaryFolder place;
  place.write("list.json", R"([{"file": "builtin:200"}, {"file": "builtin:300", "translation": [1, 0.5, 0],
      "opacity": 0.7, "first": 100, "count": 150, "tint": [1, 0, 0, 0.5]}])");
  const std::string render = "render list.json --place --scale 0.05 --format pfm --out ";
  run(place, render + "float64 --renderer reference");
  run(place, render + "floats");
  CHECK(psnr(read_image(place / "float64/front.pfm").pixels, read_image(place / "floats/front.pfm").pixels) >
        110);
}

TEST_CASE("cli: render refuses what the reference cannot follow by its name") {
  const TemporaryFolder place;
  for (const std::string option : {"--planes depth --format exr", "--video a.mp4", "--batch 2",
                                   "--json out.json", "--stats", "--depth-at ray", "--harmonics half"})
    fails(place, "render builtin:10 --renderer reference " + option,
          {option.substr(0, option.find(' ')) + ": expected another renderer than reference"});
  fails(place, "render builtin:10 --format npy", {"--format 'npy': expected png, pfm or exr, or npy with"});
}

}  // namespace swiftgs::test::reference_cli_test
