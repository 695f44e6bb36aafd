// SPDX-License-Identifier: Apache-2.0
#include "webp_write.hpp"

#include <memory>
#include <new>

#include <webp/encode.h>

#include <swiftgs/error.hpp>

namespace swiftgs::io {
namespace {

struct Encoding {
  const Stopping& stopping;
  std::string file{};
};

Encoding& encoding_of(const WebPPicture* picture) { return *static_cast<Encoding*>(picture->user_data); }

int append(const std::uint8_t* data, std::size_t size, const WebPPicture* picture) {
  encoding_of(picture).file.append(reinterpret_cast<const char*>(data), size);
  return 1;
}

int goes_on(int, const WebPPicture* picture) { return !encoding_of(picture).stopping; }

}  // namespace

std::string encode_webp(const RgbaImage& image, const Stopping& stopping) {
  // Method 4 makes files 2 % smaller than method 2 and 20 % smaller than method 0, in about the same time;
  // method 5 gains nothing.
  constexpr int method = 4;
  constexpr float effort = 75;
  WebPConfig config;
  WebPPicture picture;
  if (!WebPConfigPreset(&config, WEBP_PRESET_DEFAULT, effort) || !WebPPictureInit(&picture))
    throw Unavailable("WebP encoder: the library is of another version than its headers");
  config.lossless = 1;
  config.exact = 1;
  config.method = method;

  const std::unique_ptr<WebPPicture, void (*)(WebPPicture*)> owner(&picture, WebPPictureFree);
  Encoding encoding{stopping};
  picture.use_argb = 1;
  picture.width = int(image.width);
  picture.height = int(image.height);
  picture.user_data = &encoding;
  picture.writer = append;
  picture.progress_hook = goes_on;
  if (!WebPPictureImportRGBA(&picture, image.bytes.data(), int(4 * image.width))) throw std::bad_alloc();
  if (!WebPEncode(&config, &picture) && picture.error_code != VP8_ENC_ERROR_USER_ABORT)
    throw Unavailable("WebP encoder: error " + std::to_string(picture.error_code));
  return encoding.file;
}

}  // namespace swiftgs::io
