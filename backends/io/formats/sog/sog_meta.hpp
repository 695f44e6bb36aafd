// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include <swiftgs/math.hpp>

#include "bytes.hpp"

namespace swiftgs::io {

enum SogImageKind {
  sog_means_low,
  sog_means_high,
  sog_scales,
  sog_rotations,
  sog_colours,
  sog_sh_labels,
  sog_sh_palette,
  sog_image_kinds
};

/// What `meta.json` says. Versions 1 and 2 differ in what bytes stand for, which is a table here, activated.
struct SogMeta {
  using Table = std::array<float, 256>;

  int version = 0;
  std::uint32_t count = 0;
  std::array<std::string, sog_image_kinds> images{};  ///< names; empty: not there, as SH of degree 0
  dvec3 mean_min{0.0}, mean_max{0.0};                 ///< signed logarithms
  std::array<Table, 3> scales;                        ///< standard deviations along x, y, z
  std::array<Table, 3> colours;                       ///< SH coefficients of band 0: R, G, B
  Table opacities;
  Table sh;                                     ///< SH coefficients above band 0
  std::optional<int> sh_degree{};               ///< version 2 says; of version 1 the palette's image tells
  std::optional<std::uint32_t> palette_size{};  ///< the same: entries that are used
  RenderingModel model{};
  std::string unknown_model{};  ///< a rendering model that is none of these
};

/// Throws `FormatError` at the member that is missing or wrong.
SogMeta parse_sog_meta(const Source& source);

}  // namespace swiftgs::io
