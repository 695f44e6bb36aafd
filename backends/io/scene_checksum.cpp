// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdio>
#include <map>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include <zlib.h>

#include <swiftgs/io/sort_calibrations.hpp>

#include "parallel.hpp"

namespace swiftgs {
namespace io {
namespace {

/// Goes on from `before` over `bytes`, in parallel: CRCs of parts can be joined.
uLong crc_after(uLong before, std::span<const std::byte> bytes) {
  struct Part {
    std::size_t size;
    uLong crc;
  };
  std::mutex mutex;
  std::map<std::size_t, Part> parts;  // by where they begin
  for_parts(bytes.size(), [&](std::size_t begin, std::size_t end) {
    const auto* data = reinterpret_cast<const Bytef*>(bytes.data()) + begin;
    const uLong crc = crc32_z(crc32(0, nullptr, 0), data, end - begin);
    const std::lock_guard lock(mutex);
    parts[begin] = {end - begin, crc};
  });
  for (const auto& [begin, part] : parts) before = crc32_combine(before, part.crc, z_off_t(part.size));
  return before;
}

template <class T>
uLong crc_after(uLong before, const std::vector<T>& array) {
  static_assert(sizeof(T) % sizeof(float) == 0 && alignof(T) == alignof(float), "no padding has a checksum");
  return crc_after(before, std::as_bytes(std::span(array)));
}

}  // namespace
}  // namespace io

std::string scene_checksum(const Scene& scene) {
  const std::array properties{std::byte(scene.sh_degree), std::byte(scene.antialiased)};
  uLong crc = io::crc_after(crc32(0, nullptr, 0), std::span<const std::byte>(properties));
  crc = io::crc_after(crc, scene.means);
  crc = io::crc_after(crc, scene.scales);
  crc = io::crc_after(crc, scene.rotations);
  crc = io::crc_after(crc, scene.opacities);
  crc = io::crc_after(crc, scene.sh0);
  crc = io::crc_after(crc, scene.sh_rest);
  std::array<char, 9> digits{};
  std::snprintf(digits.data(), digits.size(), "%08lx", crc);
  return std::string("crc32:") + digits.data();
}

}  // namespace swiftgs
