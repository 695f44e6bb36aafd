// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <system_error>

#include <swiftgs/io/image.hpp>

#include "files.hpp"

namespace swiftgs::test::float_image_test {

namespace {

Image read(const std::string& content) { return read_image(as_bytes(content), "test image"); }

Frame some_frame() {
  Frame frame;
  frame.width = 3, frame.height = 2;
  for (int i = 0; i < 18; ++i) frame.colour.push_back(float(i) * 0.37f - 1);
  for (int i = 0; i < 6; ++i) frame.alpha.push_back(float(i) / 7), frame.depth.push_back(float(i) * 3);
  return frame;
}

std::string floats(std::initializer_list<float> values, bool big) {
  std::string bytes;
  for (const float value : values) {
    std::string raw;
    append(raw, value);
    if (big) std::reverse(raw.begin(), raw.end());
    bytes += raw;
  }
  return bytes;
}

}  // namespace

TEST_CASE("pfm: the bottom row comes first in both byte orders") {
  for (const bool big : {false, true}) {
    const std::string scale = big ? "1.0" : "-1.0";
    const Image grey = read("Pf\n1 2\n" + scale + "\n" + floats({1, 2}, big));
    CHECK(grey.channels == 1);
    CHECK(grey.pixels == std::vector<float>{2, 1});
    const Image rgb = read("PF 1 2 " + scale + " " + floats({1, 2, 3, 4, 5, 6}, big));
    CHECK(rgb.pixels == std::vector<float>{4, 5, 6, 1, 2, 3});
  }
  CHECK(read("Pf\n1 1\n-2\n" + floats({3}, false)).pixels[0] == 6);
}

TEST_CASE("pfm: a file that ends early or lies is refused") {
  const std::string file = "PF\n2 1\n-1.0\n" + floats({1, 2, 3, 4, 5, 6}, false);
  check_every_truncation(file, [](const std::string& content) { read(content); });
  const auto about = [](const std::string& content) { return complaint([&] { read(content); }); };
  CHECK(contains(about(file + "x"), "24 bytes of pixels"));
  for (const char* header : {"PF\n0 1\n-1\n", "PF\n65537 1\n-1\n", "PF\n65536 65536\n-1\n", "PF\n-1 1\n-1\n",
                             "PF\n1 1\n0\n", "PF\n1 1\nnan\n", "PF\n1 1\ninf\n", "PFX\n1 1\n-1\n"})
    CHECK(about(std::string(header) + "123456789012") != "");
}

TEST_CASE("image: what is no image is refused and what cannot be opened says why") {
  for (const char* content : {"", "P", "GIF89a", "ply\n"})
    CHECK(contains(complaint([&] { read(content); }), "test image: byte 0: expected an image"));
  const TemporaryFolder folder;
  CHECK_THROWS_AS(read_image(folder / "missing.png"), std::system_error);
}

TEST_CASE("image: a frame without colour or a path that cannot be written is an error") {
  const TemporaryFolder folder;
  const Frame frame = some_frame();
  CHECK_THROWS_AS(write_png(folder / "no" / "a.png", frame), std::system_error);
  CHECK_THROWS_AS(write_pfm(folder / "no" / "a.pfm", frame), std::system_error);
  CHECK_THROWS_AS(write_exr(folder / "no" / "a.exr", frame), std::runtime_error);
  Frame empty = frame;
  empty.colour.clear();
  CHECK_THROWS_AS(write_png(folder / "a.png", empty), std::invalid_argument);
  CHECK_THROWS_AS(write_pfm(folder / "a.pfm", Frame{}), std::invalid_argument);
}

}  // namespace swiftgs::test::float_image_test
