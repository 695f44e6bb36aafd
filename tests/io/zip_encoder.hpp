// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <string>

#include <zlib.h>

#include "files.hpp"

namespace swiftgs::test {

/// How the entries of an archive are written.
struct ZipStyle {
  bool deflate = false;
  bool sizes_follow = false;  ///< and the header before an entry has none, as PlayCanvas's writer does
};

/// Deflates `content`; `window`: negative without a header, 16 more than MAX_WBITS with that of gzip.
inline std::string deflated(const std::string& content, int window = -MAX_WBITS) {
  z_stream stream{};
  REQUIRE(deflateInit2(&stream, 9, Z_DEFLATED, window, 9, Z_DEFAULT_STRATEGY) == Z_OK);
  std::string packed(deflateBound(&stream, content.size()), '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(content.data()));
  stream.avail_in = uInt(content.size());
  stream.next_out = reinterpret_cast<Bytef*>(packed.data());
  stream.avail_out = uInt(packed.size());
  REQUIRE(deflate(&stream, Z_FINISH) == Z_STREAM_END);
  packed.resize(stream.total_out);
  deflateEnd(&stream);
  return packed;
}

inline std::string zip(const std::map<std::string, std::string>& files, ZipStyle style = {}) {
  std::string archive, directory;
  for (const auto& [name, content] : files) {
    const std::string packed = style.deflate ? deflated(content) : content;
    const auto check =
        std::uint32_t(crc32(0, reinterpret_cast<const Bytef*>(content.data()), uInt(content.size())));
    const auto append_fields = [&](std::string& to, bool sizes) {
      append(to, std::uint16_t(20)), append(to, std::uint16_t(style.sizes_follow ? 0x808 : 0));
      append(to, std::uint16_t(style.deflate ? 8 : 0));
      append(to, std::uint32_t(0x5a210000));  // a date
      append(to, sizes ? check : 0u);
      append(to, sizes ? std::uint32_t(packed.size()) : 0u);
      append(to, sizes ? std::uint32_t(content.size()) : 0u);
      append(to, std::uint16_t(name.size())), append(to, std::uint16_t(0));
    };
    const auto offset = std::uint32_t(archive.size());
    archive += "PK\3\4";
    append_fields(archive, !style.sizes_follow);
    archive += name + packed;
    if (style.sizes_follow) {
      archive += "PK\7\10";
      append(archive, check), append(archive, std::uint32_t(packed.size()));
      append(archive, std::uint32_t(content.size()));
    }
    directory += "PK\1\2";
    append(directory, std::uint16_t(20));
    append_fields(directory, true);
    directory += std::string(10, '\0');  // comment, disk, attributes
    append(directory, offset);
    directory += name;
  }
  const auto start = std::uint32_t(archive.size()), entries = std::uint32_t(files.size());
  archive += directory + "PK\5\6" + std::string(4, '\0');
  append(archive, std::uint16_t(entries)), append(archive, std::uint16_t(entries));
  append(archive, std::uint32_t(directory.size())), append(archive, start);
  return archive + std::string(2, '\0');
}

}  // namespace swiftgs::test
