// SPDX-License-Identifier: Apache-2.0
#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <vector>

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputFile.h>

#include <swiftgs/io/image.hpp>

#include "files.hpp"

namespace swiftgs::test::exr_test {

namespace {
constexpr int width = 3, height = 2;
constexpr std::size_t pixels = 6;

/// One channel of a file with its own type.
template <class T>
std::vector<T> channel(Imf::InputFile& file, const char* name) {
  std::vector<T> values(pixels);
  const auto* const found = file.header().channels().findChannel(name);
  REQUIRE(found);
  CHECK(found->type == (std::is_same_v<T, float> ? Imf::FLOAT : Imf::UINT));
  Imf::FrameBuffer target;
  target.insert(
      name, Imf::Slice(found->type, reinterpret_cast<char*>(values.data()), sizeof(T), width * sizeof(T)));
  file.setFrameBuffer(target);
  file.readPixels(0, height - 1);
  return values;
}
}  // namespace

TEST_CASE("exr: every plane has channels of its own") {
  const TemporaryFolder folder;
  Frame frame;
  prepare(frame, width, height, {.features = 2});
  float value = 0.5f;
  for_each_plane(
      [&]<class T>(std::size_t channels, std::vector<T>& plane) {
        plane.resize(channels * pixels);
        for (T& at : plane) at = T(value += 0.25f);
      },
      frame);
  frame.id = {0, 1, 16777217, 4000000001u, no_gaussian, 7}, frame.median_id = {7, 6, 5, 4, 3, no_gaussian};
  write_exr(folder / "a.exr", frame);
  Imf::InputFile file((folder / "a.exr").c_str());
  const auto every = [](const std::vector<float>& plane, std::size_t channels, std::size_t c) {
    std::vector<float> values;
    for (std::size_t i = c; i < plane.size(); i += channels) values.push_back(plane[i]);
    return values;
  };
  CHECK(channel<float>(file, "G") == every(frame.colour, 3, 1));
  CHECK(channel<float>(file, "A") == frame.alpha);
  CHECK(channel<float>(file, "Z") == frame.depth);
  CHECK(channel<float>(file, "depth.squared") == frame.squared_depth);
  CHECK(channel<float>(file, "depth.first") == frame.first_depth);
  CHECK(channel<float>(file, "depth.median") == frame.median_depth);
  CHECK(channel<float>(file, "normal.X") == every(frame.normal, 3, 0));
  CHECK(channel<float>(file, "normal.Y") == every(frame.normal, 3, 1));
  CHECK(channel<float>(file, "normal.Z") == every(frame.normal, 3, 2));
  CHECK(channel<float>(file, "features.0") == every(frame.features, 2, 0));
  CHECK(channel<float>(file, "features.1") == every(frame.features, 2, 1));
  CHECK(channel<std::uint32_t>(file, "id.gaussian") == frame.id);
  CHECK(channel<std::uint32_t>(file, "id.median") == frame.median_id);

  const Image image = read_image(folder / "a.exr");
  REQUIRE(image.channels == 4);
  for (std::size_t i = 0; i < pixels; ++i) {
    for (std::size_t c = 0; c < 3; ++c) CHECK(image.pixels[4 * i + c] == frame.colour[3 * i + c]);
    CHECK(image.pixels[4 * i + 3] == frame.alpha[i]);
  }
  check_every_truncation(content_of(folder / "a.exr"),
                         [](const std::string& content) { read_image(as_bytes(content), "test image"); });
}

}  // namespace swiftgs::test::exr_test
