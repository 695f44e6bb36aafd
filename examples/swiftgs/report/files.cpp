// SPDX-License-Identifier: Apache-2.0
#include "report/files.hpp"

#include <cerrno>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string_view>
#include <system_error>

namespace swiftgs::cli {
namespace {

[[noreturn]] void fail_to_read(const std::string& name) {
  throw std::system_error(errno ? errno : EIO, std::generic_category(), name);
}

std::string base64(std::string_view bytes) {
  constexpr const char* digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t taken = std::min<std::size_t>(3, bytes.size() - i);
    unsigned group = 0;
    for (std::size_t k = 0; k < 3; ++k)
      group = group << 8 | (k < taken ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k) text += k <= taken ? digits[group >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

}  // namespace

std::string content_of_file(const std::string& name) {
  errno = 0;
  if (std::filesystem::is_directory(name)) throw std::system_error(EISDIR, std::generic_category(), name);
  std::ifstream file(name, std::ios::binary);
  std::string content{std::istreambuf_iterator<char>(file), {}};
  if (!file.is_open() || file.bad()) fail_to_read(name);
  return content;
}

std::string data_uri_of_image(const std::string& name, const std::string& wanted_by) {
  if (!std::filesystem::is_regular_file(name))
    throw std::invalid_argument(wanted_by + ": expected the image " + name + ", which is not there");
  const std::string content = content_of_file(name);
  const char* type = content.starts_with("\x89PNG\r\n\x1a\n") ? "png"
                     : content.starts_with("\xff\xd8\xff")    ? "jpeg"
                                                              : nullptr;
  if (!type) throw std::invalid_argument(wanted_by + ": expected " + name + " to be a PNG or JPEG image");
  return std::string("data:image/") + type + ";base64," + base64(content);
}

}  // namespace swiftgs::cli
