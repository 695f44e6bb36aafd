// SPDX-License-Identifier: Apache-2.0

// Frames in linear light or sRGB-encoded, on every backend.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string_view>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include "policies/rasterizers.hpp"
#include "policies/views.hpp"

namespace swiftgs::test::conversion_test {

namespace {

constexpr int width = 45, height = 37;
constexpr Conversion conversions[] = {Conversion::srgb_to_linear, Conversion::linear_to_srgb};

double curve(double x, bool encode) {
  if (x < 0) return -curve(-x, encode);
  if (encode) return x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1 / 2.4) - 0.055;
  return x <= 0.04045 ? x / 12.92 : std::pow((x + 0.055) / 1.055, 2.4);
}

struct Drawn {
  Image image;
  std::vector<float> alpha;
};

template <class B>
Drawn draw(BoundRenderer<B>& renderer, const SceneView& scene, Image image, Conversion conversion,
           bool over = false, vec3 background = vec3(0)) {
  const auto& backend = renderer.backend();
  auto bytes = to_backend(backend, image.bytes);
  auto alpha = to_backend(backend, std::vector<float>(width * height));
  FrameView frame = image.frame();
  frame.colour.data = bytes.data(), frame.over = over, frame.conversion = conversion;
  frame.alpha = {alpha.data(), 4 * width};
  RenderSettings settings;
  settings.background = background;
  renderer.render_into(scene, forward_camera(width, height), settings, frame);
  image.bytes = to_host(backend, std::as_const(bytes).span());
  CHECK(image.kept_to_its_rows());
  return {image, to_host(backend, std::as_const(alpha).span())};
}

/// How far a channel of `format` may be from `value`: what rounding moves it by, and a little.
double tolerance(PixelFormat format, double value) {
  const double float_error = 4e-6 * std::abs(value) + 2e-7;
  if (format == PixelFormat::rgba_half) return float_error + std::abs(value) * 0x1p-11 + 0x1p-25;
  return format == PixelFormat::rgba_8 || format == PixelFormat::bgra_8 ? float_error + 0.5 / 255
                                                                        : float_error;
}

}  // namespace

SWIFTGS_CONTRACT("conversion: every format holds the converted straight colours and the same alpha") {
  with_each_renderer<B>([&](BoundRenderer<B>& renderer, std::string_view) {
    const auto scene = renderer.backend().upload(random_scene(200, 1, 6));
    const Image nothing(width, height, PixelFormat::rgba_float);
    Drawn splats = draw(renderer, scene.view(), nothing, Conversion::as_is);
    for (const PixelFormat format : pixel_formats)
      for (const Conversion conversion : conversions)
        for (const int kind : {0, 1, 2}) {  // nothing behind the splats, a background, an image
          CAPTURE(int(format));
          CAPTURE(int(conversion));
          CAPTURE(kind);
          const vec3 background = kind == 1 ? vec3(0.4f, 1.5f, 0.02f) : vec3(0);
          const bool encode = conversion == Conversion::linear_to_srgb;
          Image below = pattern(width, height, format);
          Drawn found = draw(renderer, scene.view(), below, conversion, kind == 2, background);
          CHECK(same_bits(found.alpha, splats.alpha));
          double worst = 0;
          std::size_t changed = 0;
          for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x) {
              const vec4 own = splats.image.at(x, y), stored = found.image.at(x, y), image = below.at(x, y);
              const double behind = 1 - double(own.a), under = kind == 2 ? double(image.a) : 0;
              const double alpha = double(own.a) + behind * under;
              const double whole = format == PixelFormat::rgb_float || kind == 1 ? 1 : alpha;
              for (int c = 0; c < 3; ++c) {
                const double back = kind == 1   ? double(background[c])
                                    : under > 0 ? under * curve(double(image[c]) / under, !encode)
                                                : 0;
                const double laid = double(own[c]) + behind * back;
                double value = whole > 0 ? whole * curve(laid / whole, encode) : 0;
                if (bytes_per_pixel(format) == 4) value = std::clamp(value, 0.0, 1.0);
                // Straight colours of nearly no alpha have few digits.
                const double slack = whole > 1e-4 ? 0 : 1e-3;
                worst =
                    std::max(worst, std::abs(double(stored[c]) - value) - tolerance(format, value) - slack);
                changed += std::abs(value - laid) > 0.01;
              }
              if (format != PixelFormat::rgb_float)
                worst = std::max(worst, std::abs(double(stored.a) - alpha) - tolerance(format, alpha));
            }
          CHECK(worst <= 0);
          CHECK(changed > 300);
        }
  });
}

SWIFTGS_CONTRACT("conversion: an image of 8 bits or halves keeps its bytes where no splat is") {
  Usual<B> renderer(std::move(backend));
  const auto scene = renderer.backend().upload(Scene());
  for (const PixelFormat format : {PixelFormat::rgba_half, PixelFormat::rgba_8, PixelFormat::bgra_8})
    for (const Conversion conversion : conversions) {
      Image image = pattern(width, height, format);
      for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
          const vec4 at = image.at(x, y);
          image.set(x, y, vec4(at.r * at.a, at.g * at.a, at.b * at.a, at.a));  // straight colours up to 1
        }
      CHECK((draw(renderer, scene.view(), image, conversion, true).image.bytes == image.bytes));
    }
}

}  // namespace swiftgs::test::conversion_test
