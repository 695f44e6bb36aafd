// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <csetjmp>
#include <cstdint>
#include <cstdio>
#include <string>
#include <utility>
#include <vector>

#include <jpeglib.h>
// After jpeglib.h, which it needs.
#include <jerror.h>

#include "image_parsing.hpp"

namespace swiftgs::io {
namespace {

/// libjpeg-turbo reads a scan over all pixels however few bytes it has; real files have about ten.
constexpr int max_scans = 100;

/// Everything that a decode needs. libjpeg jumps over frames, so no local variable may own memory.
struct JpegDecode {
  explicit JpegDecode(const Source& file) : source(file) {}
  ~JpegDecode() { jpeg_destroy_decompress(&info); }

  const Source& source;
  jpeg_decompress_struct info{};
  jpeg_error_mgr errors{};
  jpeg_progress_mgr progress{};
  std::jmp_buf jump;
  char message[JMSG_LENGTH_MAX] = {};
  std::vector<std::uint8_t> row{};
  Image image{};
};

JpegDecode& decode_of(j_common_ptr info) { return *static_cast<JpegDecode*>(info->client_data); }

void on_error(j_common_ptr info) {
  JpegDecode& decode = decode_of(info);
  decode.errors.format_message(info, decode.message);
  std::longjmp(decode.jump, 1);
}

/// libjpeg makes up what is missing and calls it a warning. Only these leave the picture whole.
void on_message(j_common_ptr info, int level) {
  const int code = info->err->msg_code;
  if (level < 0 && code != JWRN_EXTRANEOUS_DATA && code != JWRN_JFIF_MAJOR && code != JWRN_ADOBE_XFORM)
    on_error(info);
}

void on_progress(j_common_ptr info) {
  JpegDecode& decode = decode_of(info);
  if (decode.info.input_scan_number <= max_scans) return;
  std::snprintf(decode.message, sizeof decode.message, "more than %d scans", max_scans);
  std::longjmp(decode.jump, 1);
}

/// False, with `decode.message` set, if libjpeg gave up.
bool read_header(JpegDecode& decode) {
  if (setjmp(decode.jump)) return false;
  jpeg_create_decompress(&decode.info);
  decode.info.progress = &decode.progress;
  jpeg_mem_src(&decode.info, reinterpret_cast<const unsigned char*>(decode.source.bytes.data()),
               static_cast<unsigned long>(decode.source.bytes.size()));
  jpeg_read_header(&decode.info, TRUE);
  decode.info.out_color_space = decode.info.num_components == 1 ? JCS_GRAYSCALE : JCS_RGB;
  return true;
}

bool start(JpegDecode& decode) {
  if (setjmp(decode.jump)) return false;
  jpeg_start_decompress(&decode.info);
  return true;
}

bool read_row(JpegDecode& decode) {
  if (setjmp(decode.jump)) return false;
  JSAMPROW to = decode.row.data();
  jpeg_read_scanlines(&decode.info, &to, 1);
  return true;
}

bool finish(JpegDecode& decode) {
  if (setjmp(decode.jump)) return false;
  jpeg_finish_decompress(&decode.info);
  return true;
}

[[noreturn]] void fail(const JpegDecode& decode) {
  const std::size_t left = decode.info.src ? decode.info.src->bytes_in_buffer : 0;
  const std::size_t size = decode.source.bytes.size();
  decode.source.fail(size - std::min(left, size), "a valid JPEG (" + std::string(decode.message) + ")");
}

/// Reads the header, and checks the size that it states.
ImageSize start_decode(JpegDecode& decode) {
  decode.info.err = jpeg_std_error(&decode.errors);
  decode.errors.error_exit = on_error;
  decode.errors.emit_message = on_message;
  decode.progress.progress_monitor = on_progress;
  decode.info.client_data = &decode;
  if (!read_header(decode)) fail(decode);

  // A block of 64 pixels takes a bit in the densest file.
  expect_plausible_size(decode.source, 0, decode.info.image_width, decode.info.image_height, 512);
  return {int(decode.info.image_width), int(decode.info.image_height)};
}

}  // namespace

ImageSize jpeg_size(const Source& source) {
  JpegDecode decode(source);
  return start_decode(decode);
}

Image parse_jpeg(const Source& source) {
  JpegDecode decode(source);
  start_decode(decode);
  if (!start(decode)) fail(decode);
  Image& image = decode.image;
  image.width = int(decode.info.output_width), image.height = int(decode.info.output_height);
  image.channels = decode.info.output_components;
  decode.row.resize(std::size_t(image.width) * image.channels);
  image.pixels.reserve(decode.row.size() * image.height);
  for (int row = 0; row < image.height; ++row) {
    if (!read_row(decode)) fail(decode);
    for (const std::uint8_t sample : decode.row) image.pixels.push_back(float(sample) / 255);
  }
  if (!finish(decode)) fail(decode);
  return std::move(image);
}

}  // namespace swiftgs::io
