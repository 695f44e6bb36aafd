// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

#include <swiftgs/frame/half.hpp>
#include <swiftgs/frame/math.hpp>
#include <swiftgs/frame/span.hpp>

namespace swiftgs {

/// Highest degree of spherical harmonics that is rendered.
inline constexpr int max_sh_degree = 3;

/// SH coefficients a channel above band 0: 0, 3, 8, 15 for degree 0 to 3.
SWIFTGS_HD constexpr int sh_rest_count(int degree) { return (degree + 1) * (degree + 1) - 1; }

/// How a coefficient is stored. Each stands for one float exactly; bytes have no -0, which no colour shows.
enum class HarmonicFormat : std::uint8_t {
  floats,
  halves,
  bytes  ///< signed, times the scale of all
};

/// @units{bytes}
SWIFTGS_HD constexpr std::size_t size_of(HarmonicFormat format) {
  return format == HarmonicFormat::floats ? 4 : format == HarmonicFormat::halves ? 2 : 1;
}

/// Rows of halves, bytes and palettes begin at multiples of this, and are padded to a multiple of it.
/// @units{bytes}
inline constexpr std::size_t harmonic_alignment = 16;

/// Size of the coefficients of a Gaussian where they are padded to that. @units{bytes}
SWIFTGS_HD constexpr std::size_t padded_row(HarmonicFormat format, int degree) {
  const std::size_t bytes = 3 * std::size_t(sh_rest_count(degree)) * size_of(format);
  return (bytes + harmonic_alignment - 1) / harmonic_alignment * harmonic_alignment;
}

/// Coefficients of one Gaussian above band 0, RGB innermost.
struct HarmonicRow {
  const void* values;
  HarmonicFormat format;
  float scale;

  SWIFTGS_HD float operator[](int k) const {
    switch (format) {
      case HarmonicFormat::halves:
        return to_float(static_cast<const Half*>(values)[k]);
      case HarmonicFormat::bytes:
        return scale * float(static_cast<const signed char*>(values)[k]);
      default:
        return static_cast<const float*>(values)[k];
    }
  }
};

/// Coefficients above band 0 of fewer than 2^32 Gaussians. Arrays of the caller are rows of floats; uploads
/// may keep them in fewer bytes.
struct HarmonicRows {
  const void* data = nullptr;  ///< the first row
  std::size_t size = 0;        ///< Gaussians
  std::uint32_t stride = 0;    ///< from a row to the next @units{bytes}
  HarmonicFormat format = HarmonicFormat::floats;
  float scale = 1;                        ///< of bytes: a power of two from 2^-126 to 2^96
  const std::uint16_t* labels = nullptr;  ///< the row of each Gaussian in a palette of floats; null: its own

  constexpr HarmonicRows() = default;
  /// Rows of floats.
  SWIFTGS_HD constexpr HarmonicRows(const StridedSpan<const float>& rows)
      : data(rows.data), size(rows.size), stride(rows.stride) {}
  SWIFTGS_HD constexpr HarmonicRows(const void* floats, std::size_t count, std::size_t bytes)
      : data(floats), size(count), stride(bytes >> 32 == 0 ? std::uint32_t(bytes) : ~0u) {}

  /// Whether rows are padded, and may not be replaced by floats.
  SWIFTGS_HD constexpr bool is_packed() const { return format != HarmonicFormat::floats || labels; }
  SWIFTGS_HD constexpr bool empty() const { return size == 0; }

  SWIFTGS_HD std::uint32_t row_of(std::size_t i) const { return labels ? labels[i] : std::uint32_t(i); }
  SWIFTGS_HD const unsigned char* row(std::uint32_t number) const {
    return static_cast<const unsigned char*>(data) + std::uint64_t(number) * stride;
  }
  SWIFTGS_HD HarmonicRow operator[](std::size_t i) const { return {row(row_of(i)), format, scale}; }
  /// Writes the coefficients of Gaussian `i` up to `degree`.
  SWIFTGS_HD void load(std::size_t i, int degree, float* to) const {
    const HarmonicRow from = (*this)[i];
    for (int k = 0; k < 3 * sh_rest_count(degree); ++k) to[k] = from[k];
  }

  /// Rows of `count` Gaussians from number `first` on; empty rows stay empty.
  SWIFTGS_HD HarmonicRows part(std::size_t first, std::size_t count) const {
    HarmonicRows some = *this;
    if (empty()) return some;
    if (labels)
      some.labels += first;
    else
      some.data = row(std::uint32_t(first));
    some.size = count;
    return some;
  }

  /// The same rows, which are not packed, as an array of floats.
  StridedSpan<const float> floats() const { return {static_cast<const float*>(data), size, stride}; }
};

/// How rows keep coefficients, in a word.
inline const char* name_of(const HarmonicRows& rows) {
  if (rows.labels) return "palette";
  return rows.format == HarmonicFormat::floats   ? "floats"
         : rows.format == HarmonicFormat::halves ? "halves"
                                                 : "bytes";
}

/// How an upload keeps harmonics above band 0.
enum class HarmonicsKept {
  floats,    ///< so that `update` may replace them
  smallest,  ///< in the fewest bytes that are exact; a host leaves a scene that it shares as it is
  /// Rounded to the nearest half, 96 bytes a Gaussian at degree 3. A coefficient c is off by
  /// at most max(2^-11 |c|, 2^-25), so a channel of a colour by no more than the sum of |basis_k| times that
  /// over all coefficients, of which each |basis_k| is below 1.2. Coefficients lie within -65504 and 65504.
  halves
};

}  // namespace swiftgs
