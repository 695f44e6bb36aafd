// SPDX-License-Identifier: Apache-2.0

// Several scenes in one frame.
#include <filesystem>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/edit.hpp>
#include <swiftgs/io/image.hpp>
#include <swiftgs/io/scene_file.hpp>
#include <swiftgs/metrics.hpp>

#include "cli/command.hpp"
#include "io/far_scene.hpp"

using namespace swiftgs::test;
using swiftgs::dmat3;
using swiftgs::dvec3;
using swiftgs::Scene;
using swiftgs::Similarity;

namespace {

/// A camera of 96x64 at `position` that looks along z.
std::string camera_at(const dvec3& position) {
  std::string text = R"([{"id": 0, "img_name": "a", "width": 96, "height": 64, "fx": 80, "fy": 80,
    "rotation": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "position": [)";
  for (int axis = 0; axis < 3; ++axis) text += (axis == 0 ? "" : ", ") + std::to_string(position[axis]);
  return text + "]}]";
}

Scene range_of(const Scene& scene, std::size_t first, std::size_t end) {
  return subset(scene, select(scene, [&](std::size_t i) { return i >= first && i < end; }));
}

/// The pixels that `render` draws of `scenes`.
std::vector<float> drawn(const TemporaryFolder& place, const std::string& scenes,
                         const std::string& cameras = " --cameras cameras.json") {
  run_noting(place, "render " + scenes + cameras + " --format pfm");
  return swiftgs::read_image(place / "renders" / (cameras.empty() ? "view.pfm" : "a.pfm")).pixels;
}

}  // namespace

TEST_CASE("cli placed: parts of a scene in one frame are the scene") {
  const TemporaryFolder place;
  const Scene whole = swiftgs::make_builtin_scene(3000);
  write_scene(place / "whole.ply", whole);
  write_scene(place / "a.ply", range_of(whole, 0, 2000));
  std::filesystem::create_directory(place / "parts");
  write_scene(place / "parts/b.ply", range_of(whole, 2000, 3000));
  place.write("cameras.json", camera_at(dvec3(0, -0.5, -4)));
  place.write("parts/scenes.json", R"([{"file": "../a.ply"}, {"file": "./b.ply"}])");
  place.write("ranges.json", R"([{"file": "whole.ply", "count": 700}, {"file": "a.ply", "first": 700},
    {"file": "whole.ply", "first": 2000, "count": 1000}])");
  place.write("parts/one.json",
              "\xef\xbb\xbf"
              R"(  [{"file": "b.ply"}])");  // with a byte order mark
  const std::vector<float> expected = drawn(place, "whole.ply");
  CHECK(drawn(place, "a.ply parts/b.ply --place") == expected);
  CHECK(drawn(place, "parts/scenes.json") == expected);
  CHECK(drawn(place, "ranges.json") == expected);
  CHECK(drawn(place, "parts/one.json a.ply --place") == expected);
  CHECK(drawn(place, "a.ply") != expected);

  check_holds(run_noting(place, "render parts/scenes.json --cameras cameras.json --stats --json -").out,
              {"\"scene\":\"a+b\"", "\"gaussians\":3000"});
}

TEST_CASE("cli placed: a list moves and clips scenes and makes them fainter") {
  const TemporaryFolder place;
  const Scene room = swiftgs::make_builtin_scene(3000);
  Scene thing = range_of(room, 800, 1800), moved = thing;
  write_scene(place / "room.ply", room);
  write_scene(place / "thing.ply", thing);
  place.write("cameras.json", camera_at(dvec3(0, -0.5, -4)));

  const Similarity turned{{dvec3(0, 0, -1), dvec3(0, 1, 0), dvec3(1, 0, 0)}, 1.5, dvec3(0.5, -0.25, -1)};
  transform(moved, turned);
  Scene clipped = crop(crop(thing, swiftgs::Sphere{dvec3(0), 1.4}), swiftgs::HalfSpace{dvec3(1, 0, 0), -0.1});
  for (float& opacity : clipped.opacities) opacity *= 0.5f;
  Scene both = room;
  append(both, moved), append(both, clipped);
  CHECK(clipped.size() > 100);
  CHECK(clipped.size() < 900);
  write_scene(place / "both.ply", both);
  const std::vector<float> expected = drawn(place, "both.ply");
  for (const std::string rotation : {"[[0, 0, 1], [0, 1, 0], [-1, 0, 0]]", "[2, 0, 2, 0]"}) {
    place.write("scenes.json", R"([{"file": "room.ply"},
      {"file": "thing.ply", "scale": 1.5, "translation": [0.5, -0.25, -1], "rotation": )" +
                                   rotation + R"(},
      {"file": "thing.ply", "opacity": 0.5,
       "clip": {"sphere": [0, 0, 0, 1.4], "half_spaces": [[1, 0, 0, -0.1]]}}])");
    const std::vector<float> found = drawn(place, "scenes.json");
    CHECK(swiftgs::psnr(found, expected) > 80);
    CHECK(swiftgs::psnr(found, drawn(place, "room.ply")) < 40);
  }

  // A view that is found for the first scene goes where the scene goes.
  place.write("alone.json", R"([{"file": "room.ply", "translation": [1, 2, 3], "rotation": [1, 1, 0, 0]}])");
  CHECK(swiftgs::psnr(drawn(place, "alone.json", ""), drawn(place, "room.ply", "")) > 80);
}

TEST_CASE("cli placed: scenes far from zero stand at their origins") {
  const TemporaryFolder place;
  const dvec3 far(431000.25, 4580000.5, 62.125), beside(0.5, -0.25, 1), ahead(0, 0, -3);
  const auto write = [&](const std::string& name, const dvec3& centre) {
    place.write(name + "a.ply", far_scene(centre, "double"));
    place.write(name + "b.ply", far_scene(centre + 3e3 * beside, "double"));
    place.write(name + "list.json",
                R"([{"file": ")" + name + R"(a.ply"}, {"file": ")" + name +
                    R"(b.ply", "translation": [-1499.5, 749.75, -2999], "clip": {"box": [)" +
                    std::to_string(centre.x + 1499) + ", " + std::to_string(centre.y - 760) + ", " +
                    std::to_string(centre.z + 2990) + ", " + std::to_string(centre.x + 1500.5) + ", " +
                    std::to_string(centre.y - 740) + ", " + std::to_string(centre.z + 3010) + "]}}]");
    place.write("cameras.json", camera_at(centre + ahead));
    return drawn(place, name + "list.json");
  };
  const std::vector<float> expected = write("near-", dvec3(0)), found = write("far-", far);
  CHECK(swiftgs::psnr(found, expected) > 80);
  CHECK(swiftgs::psnr(found, drawn(place, "far-a.ply")) < 40);
  CHECK(drawn(place, "far-a.ply far-a.ply --place") != drawn(place, "far-a.ply"));
}

TEST_CASE("cli placed: what cannot be placed is named") {
  const TemporaryFolder place;
  write_scene(place / "a.ply", swiftgs::make_builtin_scene(20));
  fails(place, "render a.ply a.ply builtin:10",
        {"swiftgs: render: found 3 scenes, expected one, or --place to show all in one frame\n"});
  fails(place, "render a.ply missing.ply --place", {"swiftgs: missing.ply: No such file or directory\n"});
  place.write("lists/missing.json", R"([{"file": "b.ply"}])");
  fails(place, "render lists/missing.json", {"swiftgs: lists/b.ply: No such file or directory\n"});
  place.write("list.json", R"([{"file": "a.ply", "scale": 0}])");
  fails(place, "render list.json", {"swiftgs: list.json: byte 1: expected a finite scale above 0\n"});
  place.write("list.json", R"([{"file": "a.ply"}, {"file": "a.ply", "first": 3, "count": 18}])");
  fails(place, "render list.json",
        {"swiftgs: place: placement 1 shows 18 Gaussians from number 3 on, expected some of the 20"});
  place.write("list.json", R"([{"file": "builtin:20"}, {"file": "a.ply"}])");
  fails(place, "render list.json --json a.ply",
        {"swiftgs: --json a.ply: expected another file than that of SCENE\n"});
  CHECK(run(place, "render list.json --scale 0.05").out.starts_with("renders/front.png  64x36"));
}

TEST_CASE("cli placed: each scene is drawn as it was trained, unless --model says otherwise") {
  const TemporaryFolder place;
  Scene scene = swiftgs::make_builtin_scene(20);
  write_scene(place / "a.spz", scene);
  scene.model.antialiased = true;
  write_scene(place / "b.spz", scene);
  const auto picture = [&](const std::string& scenes) {
    run(place, "render " + scenes + " --place --scale 0.05 --format pfm");
    return content_of(place / "renders/view.pfm");
  };
  const std::string both = picture("a.spz b.spz");
  CHECK(both != picture("a.spz a.spz"));
  CHECK(both != picture("b.spz b.spz"));
  CHECK(picture("a.spz b.spz --model antialiased=no") == picture("a.spz a.spz"));
  CHECK(picture("a.spz b.spz --model antialiased=yes") == picture("b.spz b.spz"));
}
