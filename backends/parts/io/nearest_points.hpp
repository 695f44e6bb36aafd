// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

/// @file
/// Comparing points of a few dozen numbers with each other, by vector instructions.

namespace swiftgs::io {

/// Points as they lie in memory, `width` floats each. Values are at most `largest_coordinate` in magnitude.
struct Points {
  const float* data = nullptr;
  std::size_t count = 0;
  std::size_t width = 0;

  const float* operator[](std::size_t i) const { return data + i * width; }
};

inline constexpr std::size_t most_width = 45;
inline constexpr float largest_coordinate = 1e18f;  ///< whose squares a float can add up

/// Points to search for the nearest one, in transposed tiles of 32. Padding of the last tile is never
/// nearest.
class PointTable {
 public:
  static constexpr std::size_t tile = 32;

  void assign(const Points& points, std::span<const std::uint32_t> ids);

  std::size_t width() const { return width_; }
  std::size_t tiles() const { return data_.size() / floats_of_tile(); }
  /// `width` times 32 coordinates, then -|p|^2 / 2 of each point.
  const float* tile_data(std::size_t i) const { return data_.data() + i * floats_of_tile(); }

 private:
  std::size_t floats_of_tile() const { return (width_ + 1) * tile; }

  std::size_t width_ = 0;
  std::vector<float> data_;
};

/// For each of the points `ids` the place in `table` of the nearest point, the first of equals.
void find_nearest(const Points& points, std::span<const std::uint32_t> ids, const PointTable& table,
                  std::uint32_t* nearest);

/// For each of the points `ids` how near each of the `table.tiles()` times 32 points is: p . q - |q|^2 / 2,
/// larger for nearer ones.
void score(const Points& points, std::span<const std::uint32_t> ids, const PointTable& table, float* scores);

/// Dot products of the points `ids` with `direction`, which has `most_width` numbers.
void project(const Points& points, std::span<const std::uint32_t> ids, const float* direction,
             float* products);

struct Sums {
  std::array<double, most_width> first{};  ///< of coordinates
  double second = 0;                       ///< of squares of all coordinates
};

/// Adds the points `ids`, in this order.
void add_up(const Points& points, std::span<const std::uint32_t> ids, Sums& sums);

/// Adds to `sums` the points `ids`, each times its weight.
void add_weighted(const Points& points, std::span<const std::uint32_t> ids, const float* weights,
                  std::array<double, most_width>& sums);

}  // namespace swiftgs::io
