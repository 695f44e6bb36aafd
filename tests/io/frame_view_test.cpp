// SPDX-License-Identifier: Apache-2.0

// Writers of what a view holds: formats, pitches, alpha and refusals.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

#include <swiftgs/frame/half.hpp>
#include <swiftgs/io/image.hpp>
#include <swiftgs/raster/store.hpp>

#include "files.hpp"

namespace swiftgs::test::frame_view_test {

namespace {

constexpr int width = 3, height = 2;
constexpr PixelFormat formats[] = {PixelFormat::rgb_float, PixelFormat::rgba_float, PixelFormat::rgba_half,
                                   PixelFormat::rgba_8, PixelFormat::bgra_8};

/// Memory of a view with gaps between rows, from the top or from the bottom. Channels and alpha are fifths,
/// which 255 divides by, so that straight colours of 8 bits are exact.
class Picture {
 public:
  Picture(PixelFormat format, bool upwards) : bytes_(row_bytes * height, 0xcd) {
    view.width = width, view.height = height, view.format = format;
    std::uint8_t* const first = bytes_.data();
    view.colour = upwards ? Plane<void>{first + row_bytes * (height - 1), -std::ptrdiff_t(row_bytes)}
                          : Plane<void>{first, std::ptrdiff_t(row_bytes)};
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x)
        detail::store_colour(view, std::size_t(x), std::size_t(y), premultiplied(x, y));
  }

  bool has_alpha() const { return view.format != PixelFormat::rgb_float; }
  float alpha(int x, int y) const { return has_alpha() && x == 1 ? (y == 0 ? 0.6f : 0.0f) : 1.0f; }
  vec4 premultiplied(int x, int y) const {
    const float a = alpha(x, y);
    return vec4(a, a * 0.4f, a * float(y), a);
  }
  /// What an 8-bit file has of straight colours.
  std::vector<float> straight() const {
    std::vector<float> all;
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) {
        const float a = alpha(x, y), shown = a > 0 ? 1.0f : 0.0f;
        for (const float channel : {shown, shown * 0.4f, shown * float(y)}) all.push_back(channel);
        if (has_alpha()) all.push_back(a);
      }
    return all;
  }

  FrameView view;

 private:
  static constexpr std::size_t row_bytes = 64;
  std::vector<std::uint8_t> bytes_;
};

/// Within the rounding of a float, far below a step of 8 bits.
bool nearly_equal(const std::vector<float>& found, const std::vector<float>& expected) {
  bool all = found.size() == expected.size();
  for (std::size_t i = 0; all && i < found.size(); ++i) all = std::abs(found[i] - expected[i]) <= 1e-6f;
  return all;
}

std::vector<std::byte> bytes_of(const std::filesystem::path& path) {
  const std::string text = content_of(path);
  const auto* first = reinterpret_cast<const std::byte*>(text.data());
  return {first, first + text.size()};
}

std::string refusal(const FrameView& view) {
  try {
    (void)encode_png(view);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

}  // namespace

TEST_CASE("frame view: a PNG has straight colours of every format and of rows down and up") {
  const TemporaryFolder folder;
  for (const PixelFormat format : formats)
    for (const bool upwards : {false, true}) {
      CAPTURE(int(format));
      CAPTURE(upwards);
      const Picture picture(format, upwards);
      write_png(folder / "a.png", picture.view);
      const Image image = read_image(folder / "a.png");
      CHECK(image.width == width);
      CHECK(image.height == height);
      CHECK(image.channels == (picture.has_alpha() ? 4 : 3));
      CHECK(nearly_equal(image.pixels, picture.straight()));
      CHECK(encode_png(picture.view) == bytes_of(folder / "a.png"));
    }
}

TEST_CASE("frame view: a PFM has the colours as they are") {
  const TemporaryFolder folder;
  for (const PixelFormat format : formats)
    for (const bool upwards : {false, true}) {
      CAPTURE(int(format));
      CAPTURE(upwards);
      const Picture picture(format, upwards);
      write_pfm(folder / "a.pfm", picture.view);
      const Image image = read_image(folder / "a.pfm");
      REQUIRE(image.channels == 3);
      for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
          const vec4 expected = detail::load_colour(picture.view, std::size_t(x), std::size_t(y));
          for (int c = 0; c < 3; ++c)
            CHECK(image.pixels[std::size_t(3 * (y * width + x) + c)] == expected[c]);
        }
    }
}

TEST_CASE("frame view: a whole frame is written as its view is") {
  Frame frame;
  const FrameView view = prepare(frame, width, height, {.alpha = true, .depth = true});
  for (std::size_t i = 0; i < frame.colour.size(); ++i) frame.colour[i] = float(i) / 40;
  for (std::size_t i = 0; i < frame.pixels(); ++i) frame.alpha[i] = 0.5f, frame.depth[i] = float(i);
  CHECK(encode_png(view) == encode_png(frame));
  try {
    const TemporaryFolder folder;
    write_exr(folder / "frame.exr", frame);
    write_exr(folder / "view.exr", view);
    CHECK(bytes_of(folder / "frame.exr") == bytes_of(folder / "view.exr"));
  } catch (const std::runtime_error& error) {
    CHECK(std::string(error.what()).find("this build is without OpenEXR") != std::string::npos);
  }
}

TEST_CASE("frame view: alpha is that of the colours") {
  // RGB over an image is opaque. The last channel of RGBA is its alpha, whatever the plane of the splats'.
  for (const PixelFormat format : {PixelFormat::rgb_float, PixelFormat::rgba_float}) {
    Picture picture(format, false);
    const std::vector<std::byte> alone = encode_png(picture.view);
    std::vector<float> splats(width * height, 0.25f);
    picture.view.alpha = {splats.data(), width * sizeof(float)};
    picture.view.over = true;
    CHECK(encode_png(picture.view) == alone);
  }
}

TEST_CASE("frame view: a picture before a background that is not black is opaque") {
  const Picture picture(PixelFormat::rgba_float, false);
  const TemporaryFolder folder;
  write_png(folder / "a.png", picture.view, vec3(0, 0.5f, 0));
  const Image image = read_image(folder / "a.png");
  REQUIRE(image.channels == 3);
  CHECK(image.pixels[3] == doctest::Approx(0.6));  // as it is, not over alpha
  CHECK(encode_png(picture.view, vec3(0, 0.5f, 0)) == bytes_of(folder / "a.png"));
}

TEST_CASE("frame view: what is no picture is refused") {
  const Picture picture(PixelFormat::rgba_8, false);
  FrameView view = picture.view;
  view.colour.data = nullptr;
  CHECK(refusal(view) == "image: the view's colour is null, expected a plane in host memory");
  CHECK(refusal({}) == "image: the view's colour is null, expected a plane in host memory");
  view = picture.view, view.format = PixelFormat(7);
  CHECK(refusal(view) == "image: the view's format is 7, expected a PixelFormat");
  view.format = PixelFormat(-1);
  CHECK(refusal(view) == "image: the view's format is -1, expected a PixelFormat");
  for (const int side : {0, -1}) {
    view = picture.view, view.width = side;
    CHECK(refusal(view).find("a frame with pixels") != std::string::npos);
    view = picture.view, view.height = side;
    CHECK(refusal(view).find("a frame with pixels") != std::string::npos);
  }
  for (const std::ptrdiff_t pitch : {0, 11, -11}) {
    view = picture.view, view.colour.pitch = pitch;
    CHECK(refusal(view).find("the pitch of colour is " + std::to_string(pitch)) != std::string::npos);
  }
  view = picture.view, view.format = PixelFormat::rgba_float, view.width = 1, view.colour.pitch = 18;
  CHECK(refusal(view).find("a multiple of 4") != std::string::npos);
  const TemporaryFolder folder;
  view.colour.data = nullptr;
  CHECK_THROWS_AS(write_png(folder / "a.png", view), std::invalid_argument);
  CHECK_THROWS_AS(write_pfm(folder / "a.pfm", view), std::invalid_argument);
  CHECK(!std::filesystem::exists(folder / "a.png"));
}

}  // namespace swiftgs::test::frame_view_test
