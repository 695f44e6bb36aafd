// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include <swiftgs/io/image.hpp>

#include "png_encoder.hpp"

namespace swiftgs::test::png_test {

namespace {

Image read(const std::string& content) { return read_image(as_bytes(content), "test.png"); }

std::string zero(std::string rows) { return std::string(1, '\0') + rows; }

/// Checks a picture of these numbers over `largest`.
void check_pixels(const Image& image, int width, int height, const std::vector<int>& expected,
                  double largest) {
  CHECK(image.width == width);
  CHECK(image.height == height);
  REQUIRE(image.pixels.size() == expected.size());
  CHECK(std::size_t(image.channels * width * height) == expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i)
    CHECK(image.pixels[i] == doctest::Approx(expected[i] / largest).epsilon(1e-7));
}

}  // namespace

TEST_CASE("png: 8-bit RGB is scaled to 0 to 1 from top to bottom and 16 bits keep their precision") {
  check_pixels(read(png({.width = 2,
                         .height = 2,
                         .rows = zero("\x01\x02\x03\xff\x05\x06") + zero("\x07\x08\x09\x0a\x0b\x0c")})),
               2, 2, {1, 2, 3, 255, 5, 6, 7, 8, 9, 10, 11, 12}, 255);
  check_pixels(read(png({.bits = 16, .colour = png_rgba, .rows = zero("\x12\x34\xff\xff\x80\x01\x40\x02")})),
               1, 1, {0x1234, 0xffff, 0x8001, 0x4002}, 65535);
}

TEST_CASE("png: grey of few bits and with alpha is expanded") {
  const Image bits = read(png({.width = 3, .bits = 1, .colour = png_grey, .rows = zero("\xa0")}));
  CHECK(bits.channels == 1);
  CHECK(bits.pixels == std::vector<float>{1, 0, 1});
  const Image alpha = read(png({.colour = png_grey_alpha, .rows = zero("\xff\x33")}));
  CHECK(alpha.channels == 2);
  CHECK(alpha.pixels[1] == doctest::Approx(0.2));
}

TEST_CASE("png: a palette becomes RGB and its transparency alpha") {
  const std::string palette = png_chunk("PLTE", "\x01\x02\x03\xff\xfe\xfd");
  PngParts parts{.width = 2, .bits = 2, .colour = png_palette, .rows = zero("\x40"), .before_rows = palette};
  const Image image = read(png(parts));
  CHECK(image.channels == 3);
  CHECK(image.pixels[0] == 1);
  CHECK(image.pixels[5] == doctest::Approx(3 / 255.0));
  parts.before_rows += png_chunk("tRNS", "\x80");
  const Image transparent = read(png(parts));
  CHECK(transparent.channels == 4);
  CHECK(transparent.pixels[3] == 1);
  CHECK(transparent.pixels[7] == doctest::Approx(128 / 255.0));
}

TEST_CASE("png: a gamma chunk changes nothing") {
  PngParts parts{.rows = zero("\x40\x80\xc0")};
  const Image plain = read(png(parts));
  parts.before_rows = png_chunk("gAMA", big_endian(100000));
  CHECK(read(png(parts)).pixels == plain.pixels);
}

TEST_CASE("png: a file that ends early or is damaged is refused") {
  const std::string file = png({.width = 2, .height = 2, .rows = zero("abcdef") + zero("ghijkl")});
  const auto decode = [](const std::string& content) { read(content); };
  check_every_truncation(file, decode);
  check_every_damage(file, 0x10, decode);
}

TEST_CASE("png: a size that the file cannot hold is refused before memory is taken") {
  for (const std::uint32_t side : {60'000u, 65'537u, 2'000'000'000u}) {
    const std::string file = png({.width = side, .height = side, .rows = zero("abc")});
    CHECK(complaint([&] { read(file); }) != "");
  }
}

TEST_CASE("png: a frame is written clamped and rounded and is read back") {
  Frame frame;
  frame.width = 3, frame.height = 2;
  frame.colour = {0,       1,      0.5f,   -1,   2,    NAN,  INFINITY, -INFINITY, 0.25f,
                  0.0019f, 0.002f, 0.999f, 0.1f, 0.2f, 0.3f, 1,        1,         1};
  const TemporaryFolder folder;
  write_png(folder / "a.png", frame);
  check_pixels(read_image(folder / "a.png"), 3, 2,
               {0, 255, 128, 0, 255, 0, 255, 0, 64, 0, 1, 255, 26, 51, 77, 255, 255, 255}, 255);
}

}  // namespace swiftgs::test::png_test
