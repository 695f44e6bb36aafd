// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The smallest rows that hold the harmonics of a scene, and how they are written.

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string_view>
#include <vector>

#include <swiftgs/error.hpp>
#include <swiftgs/frame/half.hpp>
#include <swiftgs/frame/harmonics.hpp>
#include <swiftgs/frame/span.hpp>
#include <swiftgs/scene.hpp>

namespace swiftgs {

namespace detail {

/// The binary digits of numbers other than 0.
struct DigitRange {
  int lowest = 1000;  ///< exponent of the last digit of any
  int digits = 0;     ///< of the number that has the most, from the first to the last that is 1
  float least = 0, most = 0;

  void add(float value) {
    const auto bits = __builtin_bit_cast(std::uint32_t, value);
    const int exponent = int(bits >> 23 & 0xff);
    if ((bits & 0x7fffffffu) == 0) return;
    if (exponent == 0) {  // smaller than any format has
      lowest = -1000, digits = 24;
      return;
    }
    const int zeros = std::countr_zero((bits & 0x7fffffu) | 0x800000u);
    lowest = std::min(lowest, exponent - 150 + zeros), digits = std::max(digits, 24 - zeros);
    least = std::min(least, value), most = std::max(most, value);
  }
  void add(const DigitRange& other) {
    lowest = std::min(lowest, other.lowest), digits = std::max(digits, other.digits);
    least = std::min(least, other.least), most = std::max(most, other.most);
  }

  bool fit_halves() const { return digits <= 11 && lowest >= -24 && least >= -65504 && most <= 65504; }
  /// The largest that divides all numbers. A smaller scale needs larger multiples.
  float scale() const { return std::ldexp(1.0f, lowest); }
  bool fit_bytes() const {
    return digits <= 8 && lowest >= -126 && lowest <= 96 && least >= -128 * scale() && most <= 127 * scale();
  }
};

/// Coefficients of the lower bands of a scene's Gaussians.
struct UsedHarmonics {
  const Scene& scene;
  std::size_t each;  ///< floats that are used of a Gaussian

  UsedHarmonics(const Scene& of, int degree) : scene(of), each(3 * std::size_t(sh_rest_count(degree))) {}
  const float* of(std::size_t i) const {
    return scene.sh_rest.data() + i * 3 * std::size_t(sh_rest_count(scene.sh_degree));
  }
};

/// Gaussians that are looked at before it is asked whether more need be.
inline constexpr std::size_t harmonic_block = 4096;

/// Looks at a block of Gaussians, unless numbers were found that only floats hold.
struct FindDigits {
  UsedHarmonics harmonics;
  DigitRange* found;
  std::atomic<bool>* done;

  void operator()(std::size_t block) const {
    if (done->load(std::memory_order_relaxed)) return;
    const std::size_t begin = block * harmonic_block;
    const std::size_t end = std::min(begin + harmonic_block, harmonics.scene.size());
    DigitRange range;
    for (std::size_t i = begin; i < end && range.digits <= 11; ++i)
      for (std::size_t k = 0; k < harmonics.each; ++k) range.add(harmonics.of(i)[k]);
    found[block] = range;
    if (range.digits > 11) done->store(true, std::memory_order_relaxed);
  }
};

template <class B>
DigitRange find_digits(const B& loops, const UsedHarmonics& harmonics) {
  std::vector<DigitRange> found((harmonics.scene.size() + harmonic_block - 1) / harmonic_block);
  std::atomic<bool> done = false;
  loops.for_each(Count(found.size()), FindDigits{harmonics, found.data(), &done});
  DigitRange all;
  for (const DigitRange& range : found) all.add(range);
  return all;
}

/// A row for each Gaussian that is unlike those before it, and the row of each.
struct Palette {
  std::vector<std::uint32_t> first;  ///< Gaussian that each row is of
  std::vector<std::uint16_t> labels;
};

/// No value if there are more than `most` rows, of 65,536 at most. All threads hash the rows of a block, then
/// one looks them up in turn; a scene without a palette is given up after `most` of them.
template <class B>
std::optional<Palette> find_palette(const B& loops, const UsedHarmonics& harmonics, std::size_t most) {
  constexpr std::uint32_t none = ~0u;
  constexpr std::size_t block = 16 * harmonic_block;
  const std::size_t size = harmonics.scene.size(), bytes = harmonics.each * sizeof(float);
  std::vector<std::size_t> hashes(std::min(block, size));
  std::vector<std::uint32_t> table(std::bit_ceil(2 * std::min(most, size) + 1), none);
  Palette palette;
  palette.labels.reserve(size);
  for (std::size_t first = 0; first < size; first += block) {
    const std::size_t count = std::min(block, size - first);
    loops.for_each(Count(count), [&](std::size_t i) {
      const auto* const row = reinterpret_cast<const char*>(harmonics.of(first + i));
      hashes[i] = std::hash<std::string_view>()({row, bytes});
    });
    for (std::size_t i = first; i < first + count; ++i) {
      const auto is_row_of = [&](std::uint32_t label) {
        return std::memcmp(harmonics.of(palette.first[label]), harmonics.of(i), bytes) == 0;
      };
      std::size_t slot = hashes[i - first] % table.size();
      while (table[slot] != none && !is_row_of(table[slot])) slot = (slot + 1) % table.size();
      if (table[slot] == none) {
        if (palette.first.size() == most) return std::nullopt;
        table[slot] = std::uint32_t(palette.first.size());
        palette.first.push_back(std::uint32_t(i));
      }
      palette.labels.push_back(std::uint16_t(table[slot]));
    }
  }
  return palette;
}

}  // namespace detail

/// How the harmonics of a scene are kept, up to the highest band that is used. `scene` outlives it.
class HarmonicPacking {
 public:
  /// Loops of `loops` look at `scene`, which is valid and has finite numbers alone. Throws
  /// `InvalidArgument` for numbers beyond 65504 that should become halves.
  template <class B>
  HarmonicPacking(const B& loops, const Scene& scene, int degree, HarmonicsKept kept)
      : harmonics_(scene, degree), degree_(degree) {
    if (degree == 0 || kept == HarmonicsKept::floats) return;
    if (kept == HarmonicsKept::halves) {
      require_halves(loops);
      format_ = HarmonicFormat::halves;
    } else {
      find_smallest(loops);
    }
  }

  HarmonicFormat format() const { return format_; }
  /// Whether rows are not just the scene's floats.
  bool is_packed() const { return format_ != HarmonicFormat::floats || palette_; }
  std::size_t rows() const { return palette_ ? palette_->first.size() : harmonics_.scene.size(); }
  /// @units{bytes}
  std::size_t stride() const { return padded_row(format_, degree_); }
  /// Size of rows and labels together. @units{bytes}
  std::size_t bytes() const { return rows() * stride() + labels().size * sizeof(std::uint16_t); }
  /// The row of each Gaussian in the palette; empty without a palette.
  Span<const std::uint16_t> labels() const {
    return palette_ ? Span<const std::uint16_t>{palette_->labels.data(), palette_->labels.size()}
                    : Span<const std::uint16_t>{};
  }

  /// Writes row `number`, `stride()` bytes.
  void write(std::size_t number, unsigned char* to) const {
    const std::size_t each = harmonics_.each;
    const float* const from = harmonics_.of(palette_ ? palette_->first[number] : number);
    if (format_ == HarmonicFormat::floats)
      std::memcpy(to, from, each * sizeof(float));
    else if (format_ == HarmonicFormat::halves)
      for (std::size_t k = 0; k < each; ++k) reinterpret_cast<Half*>(to)[k] = to_half(from[k]);
    else
      for (std::size_t k = 0; k < each; ++k) to[k] = static_cast<unsigned char>(int(from[k] / scale_));
    const std::size_t used = each * size_of(format_);
    std::memset(to + used, 0, stride() - used);
  }

  /// The rows, where they were written to `data` and labels copied to `labels`.
  HarmonicRows rows_at(const void* data, const std::uint16_t* labels) const {
    HarmonicRows rows;
    if (degree_ == 0) return rows;
    rows.data = data, rows.size = harmonics_.scene.size(), rows.stride = std::uint32_t(stride());
    rows.format = format_, rows.scale = scale_;
    if (palette_) rows.labels = labels;
    return rows;
  }

 private:
  template <class B>
  void require_halves(const B& loops) const {
    std::atomic<bool> found = false;
    const auto fits = [this](std::size_t i) {
      const float* const row = harmonics_.of(i);
      return std::all_of(row, row + harmonics_.each, [](float v) { return std::fabs(v) <= 65504; });
    };
    const auto look = [&](std::size_t block) {
      const std::size_t begin = block * detail::harmonic_block;
      const std::size_t end = std::min(begin + detail::harmonic_block, harmonics_.scene.size());
      for (std::size_t i = begin; i < end; ++i)
        if (!fits(i)) found.store(true, std::memory_order_relaxed);
    };
    const std::size_t n = harmonics_.scene.size();
    loops.for_each(Count((n + detail::harmonic_block - 1) / detail::harmonic_block), look);
    if (!found) return;
    std::size_t i = 0;
    while (fits(i)) ++i;
    const float* const row = harmonics_.of(i);
    const float value =
        *std::find_if(row, row + harmonics_.each, [](float v) { return std::fabs(v) > 65504; });
    detail::refuse("upload: sh_rest of Gaussian ", i, " is ", value, ", expected -65504 to 65504 for halves");
  }

  template <class B>
  void find_smallest(const B& loops) {
    const detail::DigitRange digits = detail::find_digits(loops, harmonics_);
    if (digits.fit_bytes())
      format_ = HarmonicFormat::bytes, scale_ = digits.scale();
    else if (digits.fit_halves())
      format_ = HarmonicFormat::halves;
    // A palette, if it is smaller still.
    const std::size_t row = padded_row(HarmonicFormat::floats, degree_), found = bytes();
    const std::size_t labels = harmonics_.scene.size() * sizeof(std::uint16_t);
    if (found <= labels + row) return;
    const std::size_t most = std::min<std::size_t>((found - labels - 1) / row, 1 << 16);
    palette_ = detail::find_palette(loops, harmonics_, most);
    if (palette_) format_ = HarmonicFormat::floats, scale_ = 1;
  }

  detail::UsedHarmonics harmonics_;
  int degree_;
  HarmonicFormat format_ = HarmonicFormat::floats;
  float scale_ = 1;
  std::optional<detail::Palette> palette_{};
};

}  // namespace swiftgs
