// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

#include <swiftgs/frame/harmonics.hpp>
#include <swiftgs/pages/paged_scene.hpp>
#include <swiftgs/scene.hpp>
#include <swiftgs/tools/split_mix.hpp>

namespace swiftgs::pages {

static_assert(std::endian::native == std::endian::little, "page files are read and written as they lie");

inline constexpr std::array<char, 8> magic{'S', 'G', 'P', 'A', 'G', 'E', 'S', '\n'};
inline constexpr std::uint32_t version = 1;
/// Version of a build's files. A build resumes only with files of the same version. Raise it when merging,
/// ordering, packing or steps write other bytes.
inline constexpr std::uint32_t build_version = 1;
/// Most levels of pages below another: frames walk a tree by recursion. That of 2^32 Gaussians has 33.
inline constexpr int most_levels = 64;
/// Contents of pages begin at multiples of it. @units{bytes}
inline constexpr std::uint64_t alignment = 64;

/// The first bytes of a page file.
struct FileHeader {
  std::array<char, 8> magic = pages::magic;
  std::uint32_t version = pages::version;
  std::uint32_t page_size = 0;
  std::uint64_t gaussians = 0;
  std::uint32_t pages = 0;
  std::uint32_t sh_degree = 0;
  std::array<double, 3> origin{};
  std::uint64_t file_size = 0;
  std::uint64_t table = 0;  ///< offset of the table, which ends the file
  std::uint64_t table_checksum = 0;
  std::array<char, 104> model{};  ///< as `text_of`, filled up with zeros
  std::uint64_t checksum = 0;     ///< of all before it
};
static_assert(sizeof(FileHeader) == 192);
inline constexpr std::size_t checksum_offset = offsetof(FileHeader, checksum);

/// Goes on with a checksum. What lacks of the last word counts as zeros.
inline std::uint64_t checksum_of(std::span<const std::byte> bytes, std::uint64_t sum) {
  for (std::size_t at = 0; at < bytes.size(); at += 8) {
    std::uint64_t word = 0;
    std::memcpy(&word, bytes.data() + at, std::min<std::size_t>(8, bytes.size() - at));
    sum = SplitMix64::scrambled(sum ^ word) + SplitMix64::step;
  }
  return sum;
}
/// Any change of bytes of one word changes it.
inline std::uint64_t checksum_of(std::span<const std::byte> bytes) {
  return checksum_of(bytes, bytes.size());
}

/// Calls f(offset, bytes) for each array of a page's content, in order: means, scales, rotations, opacities,
/// harmonics of band 0, rows of harmonics, labels, ids. Returns where they end.
template <class F>
std::uint64_t for_each_part(const Page& page, const F& f) {
  const std::uint64_t count = page.count;
  const std::size_t row = padded_row(HarmonicFormat(page.harmonic_format), page.sh_degree);
  std::uint64_t offset = 0;
  for (const std::uint64_t bytes :
       {12 * count, 12 * count, 16 * count, 4 * count, 12 * count, page.rows * std::uint64_t(row),
        page.has_labels * 2 * count, page.has_ids * 4 * count}) {
    f(offset, bytes);
    offset += (bytes + 3) / 4 * 4;  // floats and ids begin at multiples of 4
  }
  return offset;
}
inline std::uint64_t content_size(const Page& page) {
  return for_each_part(page, [](std::uint64_t, std::uint64_t) {});
}

/// A page of a page file. Throws as `PagedScene::read`.
PageContent read_page(const PagedScene::State& file, const PageSource& source, std::uint32_t number);

/// Numbers of the leaves, those with the first Gaussians first.
std::vector<std::uint32_t> leaves_of(const PagedScene& pages);

}  // namespace swiftgs::pages
