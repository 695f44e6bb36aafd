// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Which properties of a PLY hold what, and the rendering model in its comments.

#include <array>
#include <bit>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include <swiftgs/conventions.hpp>

#include "ply_header.hpp"

namespace swiftgs::io {

/// A scalar in a row of an element.
struct PlyField {
  PlyType type = PlyType::f32;
  std::size_t offset = 0;  ///< @units{bytes} from the start of the row
};

/// The number at `field` of a row. A double holds those of all types.
double scalar_at(const std::byte* row, PlyField field, std::endian order);

/// The coefficients f_rest_0, f_rest_1, ... of a row.
struct PlySh {
  std::vector<PlyField> fields;  ///< in the scene's order: a coefficient after another, RGB innermost
  int degree = 0;                ///< of what is kept
  int stored_degree = 0;
};

/// The properties of an element without lists, found by name. CloudCompare puts `scalar_` before the names of
/// properties that it does not know, and converters for it `scal_`; both are left out. All errors stand at
/// the element's line in the header.
class PlyFields {
 public:
  /// In an ascii file rows are taken to be parsed into an array of doubles first. Throws `FormatError` if
  /// there are lists.
  PlyFields(const Source& source, const PlyElement& element, PlyEncoding encoding);

  bool has(std::string_view name) const { return fields_.contains(name); }
  std::size_t row_bytes() const { return row_bytes_; }
  [[noreturn]] void fail(const std::string& expected) const { source_.fail(element_.declared_at, expected); }

  /// Throws `FormatError` if the property is missing.
  PlyField take(const std::string& name);

  /// The same, and throws if the header declares it with another type, which `type_name` names.
  PlyField take(const std::string& name, PlyType type, const char* type_name);

  /// Throws `FormatError` unless the coefficients are as many as a degree has, and are numbered. All of them
  /// count as taken, those of degrees that are not kept too.
  PlySh find_sh();

  /// Names of all properties, in the order of the file.
  std::vector<std::string> names() const { return {names_.begin(), names_.end()}; }

  /// Properties that were not taken, in the order of the file. Normals are left out: INRIA's files have them
  /// for programs that show points, and they are always 0.
  std::vector<std::string> untaken() const;

 private:
  struct Known {
    PlyField field;
    PlyType declared;
    bool taken;
  };

  Known& known(const std::string& name);

  const Source& source_;
  const PlyElement& element_;
  std::vector<std::string_view> names_;                 ///< of all properties, in the order of the file
  std::unordered_map<std::string_view, Known> fields_;  ///< by `names_`
  std::size_t row_bytes_ = 0;
};

/// Where the parameters of a Gaussian lie in a row, found by name.
struct PlyLayout {
  std::array<PlyField, 3> mean, scale, colour;
  std::array<PlyField, 4> rotation;
  PlyField opacity;
  std::optional<PlyField> filter;  ///< `filter_3D` of Mip-Splatting: a standard deviation
  PlySh sh;
  bool has_third_scale = true;
  bool flat = false;                  ///< 2D Gaussians: the third scale is 0, whatever the file holds
  bool byte_colour = false;           ///< `colour` holds red, green, blue from 0 to 255, not SH coefficients
  bool all_floats = false;            ///< every field is a 32-bit float
  std::size_t row_bytes = 0;          ///< distance between rows
  std::vector<std::string> unread{};  ///< other properties

  /// Whether a float may not hold the means as they are stored.
  bool wide_means() const;
};

/// The layout of `vertex`. In an ascii file rows are taken to be parsed into an array of doubles first.
/// Throws `FormatError` with the name of the missing property, or the properties of a point cloud.
PlyLayout find_layout(const Source& source, const PlyElement& vertex, PlyEncoding encoding);

/// The rendering model that the trainer's comments name; the last comment counts. `filtered`: the vertices
/// have the 3D filter of Mip-Splatting, which trains with its 2D filter too. Adds a note for each value that
/// is not known.
RenderingModel model_of(const PlyHeader& header, bool filtered, std::vector<std::string>& notes);

/// The comments that `model_of` reads.
std::string model_comments(const RenderingModel& model);

/// What the scene does not carry of a file with these coefficients. `unused_scale`: it stores a third scale
/// of Gaussians that are flat.
std::vector<std::string> notes_of(bool unused_scale, const PlySh& sh);

/// Notes the properties `unread` of elements that were read, and the elements that were not: all with rows
/// whose names are not in `read`.
void note_unread(const PlyHeader& header, const std::vector<std::string_view>& read,
                 const std::vector<std::string>& unread, std::vector<std::string>& notes);

}  // namespace swiftgs::io
