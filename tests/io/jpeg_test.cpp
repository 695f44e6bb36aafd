// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include <jpeglib.h>

#include <swiftgs/io/image.hpp>

#include "files.hpp"
#include "image_parsing.hpp"

namespace swiftgs::test::jpeg_test {

namespace {

/// A smooth ramp of 40 x 24 pixels.
int ramp(int x, int y, int channel) { return x * 3 + y * 3 + channel * 20; }

std::string jpeg(int channels = 3, bool progressive = false) {
  jpeg_compress_struct info;
  jpeg_error_mgr errors;
  info.err = jpeg_std_error(&errors);
  jpeg_create_compress(&info);
  unsigned char* data = nullptr;
  unsigned long size = 0;
  jpeg_mem_dest(&info, &data, &size);
  info.image_width = 40, info.image_height = 24;
  info.input_components = channels;
  info.in_color_space = channels == 1 ? JCS_GRAYSCALE : JCS_RGB;
  jpeg_set_defaults(&info);
  jpeg_set_quality(&info, 95, TRUE);
  if (progressive) jpeg_simple_progression(&info);
  jpeg_start_compress(&info, TRUE);
  for (int y = 0; y < 24; ++y) {
    std::vector<JSAMPLE> row;
    for (int x = 0; x < 40; ++x)
      for (int c = 0; c < channels; ++c) row.push_back(JSAMPLE(ramp(x, y, c)));
    JSAMPROW from = row.data();
    jpeg_write_scanlines(&info, &from, 1);
  }
  jpeg_finish_compress(&info);
  jpeg_destroy_compress(&info);
  std::string content(reinterpret_cast<char*>(data), size);
  std::free(data);
  return content;
}

Image read(const std::string& content) { return read_image(as_bytes(content), "test.jpg"); }

}  // namespace

TEST_CASE("jpeg: grey and colour and progressive files are decoded") {
  for (const int channels : {1, 3})
    for (const bool progressive : {false, true}) {
      const Image image = read(jpeg(channels, progressive));
      CHECK(image.width == 40);
      CHECK(image.height == 24);
      REQUIRE(image.channels == channels);
      REQUIRE(image.pixels.size() == std::size_t(40 * 24 * channels));
      for (int y = 0; y < 24; ++y)
        for (int x = 0; x < 40; ++x)
          for (int c = 0; c < channels; ++c)
            CHECK(std::abs(image.pixels[std::size_t((y * 40 + x) * channels + c)] * 255 -
                           float(ramp(x, y, c))) < 8);
    }
}

TEST_CASE("jpeg: a file that ends early is refused wherever it ends and damage never crashes") {
  const auto decode = [](const std::string& content) { read(content); };
  for (const bool progressive : {false, true}) check_every_truncation(jpeg(3, progressive), decode);
  check_every_damage(jpeg(), 0x42, decode);
}

TEST_CASE("jpeg: a size that the file cannot hold is refused before memory is taken") {
  std::string file = jpeg();
  const std::size_t frame = file.find("\xff\xc0");
  REQUIRE(frame != std::string::npos);
  for (std::size_t i = 5; i < 9; ++i) file[frame + i] = '\xfa';
  CHECK(contains(complaint([&] { read(file); }), "a file that can hold 64250x64250 pixels"));
}

TEST_CASE("jpeg: the size is read from the header alone") {
  const std::string content = jpeg();
  const std::size_t scan = content.find("\xff\xda");
  REQUIRE(scan != std::string::npos);
  const auto size = [](const std::string& start) { return io::image_size({as_bytes(start), "test.jpg"}); };
  for (const std::size_t length : {content.size(), scan + 20}) {
    CHECK(size(content.substr(0, length)).width == 40);
    CHECK(size(content.substr(0, length)).height == 24);
  }
  CHECK(contains(complaint([&] { size(content.substr(0, 20)); }), "expected a valid JPEG"));
}

}  // namespace swiftgs::test::jpeg_test
