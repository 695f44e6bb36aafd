// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The files that make up a SOG: `meta.json` and the images that it names.

#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <swiftgs/frame/math.hpp>

#include "bytes.hpp"
#include "mapped_file.hpp"

namespace swiftgs::io {

struct SogFile {
  Source source;
  std::uint64_t stored = 0;             ///< bytes that it takes on the disk
  FileIdentity identity{};              ///< of what takes them
  std::shared_ptr<const void> owner{};  ///< of `source`'s bytes, which are valid as long as it
};

/// Opens a file by its name. Throws `FormatError` or `FileError` if it is not there.
using SogFiles = std::function<SogFile(const std::string& name)>;

/// The entries of a bundle, a ZIP archive, which must outlive what this returns. An entry unpacks to at most
/// 16 times its packed size and 64 KiB more: images do not compress further, and `meta.json` is small.
/// Entries take no bytes of their own: theirs are the bundle's, and may overlap in it.
SogFiles files_of_bundle(const Source& bundle);

/// The names of the entries of a ZIP archive; none where they cannot be listed.
std::vector<std::string> names_in_bundle(std::string_view archive);

/// The files beside `meta`, which must outlive what this returns. Throws `FormatError` if it comes from
/// memory, where nothing lies beside it.
SogFiles files_beside(const Source& meta);

/// The files beside `name`, which `files` opens.
SogFiles files_beside(const std::string& name, const SogFiles& files);

/// Whether a name leads to a file of the folder that it is looked up in, or of a folder therein.
SWIFTGS_API bool stays_inside(const std::string& name);

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

/// The contents of `meta.json`. Versions 1 and 2 store values differently; here both are tables of values
/// that bytes stand for, activated.
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

/// A coordinate as SOG stores it, `sign(x) log(1 + |x|)`: rounding is finest near zero.
inline double signed_logarithm(double value) { return std::copysign(std::log1p(std::abs(value)), value); }

/// The coordinate of a signed logarithm.
inline double signed_exponential(double logarithm) {
  return std::copysign(std::exp(std::abs(logarithm)) - 1, logarithm);
}

}  // namespace swiftgs::io
