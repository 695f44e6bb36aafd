// SPDX-License-Identifier: Apache-2.0
// `swiftgs render --video`.
#include <cstdlib>
#include <string>

#include <doctest/doctest.h>

#include <swiftgs/io/image.hpp>
#include <swiftgs/metrics.hpp>

#include "cli/command.hpp"
#include "support/skip.hpp"

namespace swiftgs::test::video_test {

namespace {

/// Two frames of the built-in scene, 62 x 35 pixels, five a second.
const std::string path = R"({"camera_path": [
  {"camera_to_world": [1, 0, 0, 0.3, 0, -1, 0, -1, 0, 0, -1, -4, 0, 0, 0, 1], "fov": 50.0},
  {"camera_to_world": [1, 0, 0, 1.1, 0, -1, 0, -1, 0, 0, -1, -3, 0, 0, 0, 1], "fov": 50.0}],
  "render_width": 62, "render_height": 35, "fps": 5})";

bool has_ffmpeg() { return std::system("ffmpeg -version >/dev/null 2>&1") == 0; }

/// Runs a program in `place` and returns what it prints.
std::string output_of(const TemporaryFolder& place, const std::string& command) {
  const std::string out = (place / "out.txt").string();
  CHECK(std::system(("cd '" + place.path().string() + "' && " + command + " >'" + out + "'").c_str()) == 0);
  return content_of(out);
}

}  // namespace

TEST_CASE("cli: a video has each frame of a path at its rate") {
  if (!has_ffmpeg()) return skip("no ffmpeg here");
  const TemporaryFolder place;
  place.write("path.json", path);
  const Outcome said = run(place, "render builtin:2000 --cameras path.json --video flight.mp4");
  CHECK(said.out.starts_with("2 images with "));
  CHECK_FALSE(std::filesystem::exists(place / "renders"));
  // Of an odd height it has a row more.
  CHECK(output_of(place,
                  "ffprobe -v error -count_frames -of csv=p=0 -show_entries "
                  "stream=width,height,r_frame_rate,nb_read_frames flight.mp4") == "62,36,5/1,2\n");

  run(place, "render builtin:2000 --cameras path.json");
  output_of(place, "ffmpeg -v error -i flight.mp4 -vf crop=62:35:0:0:exact=1 video%d.png");
  for (const int frame : {0, 1}) {
    const Image image = read_image(place / ("renders/" + std::to_string(frame) + ".png"));
    const Image of_video = read_image(place / ("video" + std::to_string(frame + 1) + ".png"));
    REQUIRE(of_video.pixels.size() == image.pixels.size());
    CHECK(psnr(of_video.pixels, image.pixels) > 28);
  }
  const Image first = read_image(place / "video1.png"), second = read_image(place / "renders/1.png");
  CHECK(psnr(first.pixels, second.pixels) < 23);
}

TEST_CASE("cli: a video that cannot be made is refused in one line") {
  const TemporaryFolder place;
  const std::string render = "render builtin:100 --views 1-2 --scale 0.05 --video ";
  const Outcome without = run_after(place, "export PATH=/nowhere", render + "flight.mp4");
  CHECK(without.code == 1);
  CHECK(without.err.starts_with("swiftgs: --video flight.mp4: the program ffmpeg is not installed, "));
  fails(place, "render builtin:100 --cameras p.json --video p.json", {"--video p.json", "--cameras"});
  place.write("sizes.json", R"([{"id": 0, "img_name": "a", "width": 64, "height": 36, "position": [0, 0, 0],
    "rotation": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "fx": 40, "fy": 40},
    {"id": 1, "img_name": "b", "width": 66, "height": 36, "position": [0, 0, 0],
    "rotation": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "fx": 40, "fy": 40}])");
  fails(place, "render builtin:100 --cameras sizes.json --video v.mp4",
        {"--video v.mp4: view b has 66x36 pixels, expected 64x36 as a has"});
  if (!has_ffmpeg()) return skip("no ffmpeg here");
  fails(place, render + "v.nope", {"--video v.nope: ffmpeg failed: ", "'file:v.nope'"});
  fails(place, render + "none/v.mp4", {"--video none/v.mp4: ffmpeg failed: ", "No such file or directory"});
}

}  // namespace swiftgs::test::video_test
