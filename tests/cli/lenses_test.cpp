// SPDX-License-Identifier: Apache-2.0
#include <cstddef>
#include <string>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/io/scene_file.hpp>

#include "cli/cameras.hpp"
#include "cli/json_in.hpp"
#include "cli/pictures.hpp"

namespace swiftgs::test::lenses_test {

namespace {

/// The front view of the built-in scene, before white.
Image front(const TemporaryFolder& place, const std::string& options) {
  return drawn(place, "builtin:2000 --background 1,1,1 " + options);
}

/// Part of the pixels that are not white.
double covered(const Image& image) {
  const std::size_t pixels = image.pixels.size() / 3;
  std::size_t white = 0;
  for (std::size_t i = 0; i < pixels; ++i)
    white += image.pixels[3 * i] == 1 && image.pixels[3 * i + 1] == 1 && image.pixels[3 * i + 2] == 1;
  return 1 - double(white) / double(pixels);
}

}  // namespace

TEST_CASE("cli lenses: render draws through the lens that was asked for and tells it") {
  const TemporaryFolder place;
  const Image plain = front(place, "--scale 0.1 --json plain.json");
  CHECK(json_in(place / "plain.json")["rows"][0]["lens"] == "perspective");
  CHECK(front(place, "--scale 0.1 --lens perspective").pixels == plain.pixels);
  for (const std::string lens : {"fisheye", "orthographic", "equirectangular"}) {
    CAPTURE(lens);
    const Image image = front(place, "--scale 0.1 --json lens.json --lens " + lens);
    CHECK(image.width == 128);
    CHECK(image.height == 72);
    CHECK(image.pixels != plain.pixels);
    CHECK(covered(image) > 0.1);
    CHECK(json_in(place / "lens.json")["rows"][0]["lens"] == lens);
    const std::string text = run(place, "render builtin:50 --scale 0.1 --lens " + lens).out;
    CHECK(contains(text, "renders/front.png  128x72  " + lens + "  "));
  }
}

TEST_CASE("cli lenses: a panorama is twice as wide as high and has depths by distance") {
  const TemporaryFolder place;
  const Image panorama = front(place, "--scale 0.1 --panorama --json all.json");
  CHECK(panorama.width == 128);
  CHECK(panorama.height == 64);
  CHECK(json_in(place / "all.json")["rows"][0]["lens"] == "equirectangular");
  CHECK(front(place, "--scale 0.1 --panorama --depth-by distance").pixels == panorama.pixels);
  CHECK(front(place, "--scale 0.1 --panorama --depth-by z").pixels != panorama.pixels);
}

TEST_CASE("cli lenses: unknown names are refused with what is expected") {
  const TemporaryFolder place;
  const std::string render = "render builtin:50 ";
  fails(place, render + "--lens round",
        {"swiftgs: --lens 'round': expected perspective, fisheye, orthographic or equirectangular\n"});
  fails(place, render + "--panorama --lens fisheye", {"swiftgs: --panorama: expected no --lens fisheye"});
  fails(place, render + "--depth-by y", {"swiftgs: --depth-by 'y': expected z or distance\n"});
  fails(place, render + "--depth-at edge", {"swiftgs: --depth-at 'edge': expected centre or ray\n"});
}

TEST_CASE("cli lenses: info tells those of a capture's cameras") {
  const TemporaryFolder place;
  place.write("garden/cameras.json", cameras_json({"a.jpg", "b.jpg"}));
  write_scene(place / "garden/scene.ply", swiftgs::make_builtin_scene(100));
  CHECK(contains(run(place, "info garden").out, "lenses          2 perspective\n"));
  CHECK(json::parse(run(place, "info garden --json -").out)["lenses"] == json{{"perspective", 2}});
  CHECK(json::parse(run(place, "info builtin:10 --json -").out)["lenses"].is_null());

  place.write("garden/cameras.json", "[{\"id\": 0}]");
  check_holds(run(place, "info garden").out,
              {"Gaussians       100\n", "note            garden/cameras.json"});
}

}  // namespace swiftgs::test::lenses_test
