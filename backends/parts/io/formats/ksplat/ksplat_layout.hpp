// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "bytes.hpp"

/// @file
/// Where the Gaussians of a `.ksplat` file are: a header, a header for each section, and the sections.

namespace swiftgs::io {

/// A run of Gaussians of one SH degree. At levels 1 and 2 each lies in a bucket, a cube whose centre its
/// position is relative to. The first buckets are full, the others have a count each.
struct KsplatSection {
  std::uint64_t first = 0, count = 0;  ///< Gaussians before this section, and in it
  int sh_degree = 0;
  std::uint64_t bucket_size = 0, full_buckets = 0;
  std::vector<std::uint64_t>
      partial_ends{};  ///< for each bucket that is not full, the Gaussian after its last
  const std::byte* centres = nullptr;
  double unit = 0, middle = 0;  ///< a coordinate is unit * (stored - middle) + that of the bucket's centre
  const std::byte* records = nullptr;
  std::size_t record_bytes = 0;
};

struct KsplatLayout {
  int level = 0;  ///< of compression: floats, halves, or halves with harmonics of a byte each
  std::uint64_t count = 0;
  int sh_degree = 0;                    ///< the highest of a section
  std::array<float, 256> sh_of_byte{};  ///< at level 2
  std::vector<KsplatSection> sections{};
};

/// Bytes of a Gaussian before its harmonics, and of one of those.
inline constexpr std::size_t ksplat_base_bytes[] = {44, 24, 24};
inline constexpr std::size_t ksplat_sh_bytes[] = {4, 2, 1};

/// Whether a file begins as a `.ksplat` does, whose mark is no more than a version. It asks for more zeros
/// and small numbers than other files without a mark begin with.
bool looks_like_ksplat(std::string_view text, std::string_view name);

KsplatLayout parse_ksplat(const Source& source);

}  // namespace swiftgs::io
