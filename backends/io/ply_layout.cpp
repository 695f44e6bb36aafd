// SPDX-License-Identifier: Apache-2.0
#include "ply_layout.hpp"

#include <algorithm>
#include <string>
#include <unordered_map>

#include <swiftgs/scene.hpp>

namespace swiftgs::io {
namespace {

class LayoutFinder {
 public:
  LayoutFinder(const Source& source, const PlyElement& vertex, PlyEncoding encoding)
      : source_(source), declared_at_(vertex.declared_at) {
    for (const PlyProperty& property : vertex.properties) {
      if (property.list_count) fail("vertices without list properties, found list '" + property.name + "'");
      const PlyType type = encoding == PlyEncoding::ascii ? PlyType::f64 : property.type;
      fields_[property.name] = {type, layout_.row_bytes};
      layout_.row_bytes += size_of(type);
      declared_types_[property.name] = property.type;
    }
  }

  PlyLayout find() {
    if (has("packed_position")) fail("an INRIA PLY; a compressed PLY (packed_position) is not supported");
    layout_.mean = {take("x"), take("y"), take("z")};
    layout_.scale[0] = take("scale_0"), layout_.scale[1] = take("scale_1");
    layout_.has_third_scale = has("scale_2");
    layout_.scale[2] = layout_.has_third_scale ? take("scale_2") : layout_.scale[1];
    layout_.rotation = {take("rot_0"), take("rot_1"), take("rot_2"), take("rot_3")};
    layout_.opacity = take("opacity");
    find_colour();
    find_sh_rest();
    layout_.all_floats = all_floats_;
    return layout_;
  }

 private:
  [[noreturn]] void fail(const std::string& expected) const { source_.fail(declared_at_, expected); }

  bool has(const std::string& name) const { return fields_.count(name) != 0; }

  PlyField take(const std::string& name) {
    const auto found = fields_.find(name);
    if (found == fields_.end()) fail("a vertex property '" + name + "', as Gaussians have");
    all_floats_ &= found->second.type == PlyType::f32;
    return found->second;
  }

  void find_colour() {
    layout_.byte_colour = !has("f_dc_0") && has("red");
    const auto names = layout_.byte_colour ? std::array{"red", "green", "blue"}  //
                                           : std::array{"f_dc_0", "f_dc_1", "f_dc_2"};
    for (int c = 0; c < 3; ++c) {
      layout_.colour[c] = take(names[c]);
      if (layout_.byte_colour && declared_types_[names[c]] != PlyType::u8)
        fail("f_dc_0 to f_dc_2, or red, green and blue of type uchar");
    }
  }

  /// The file holds all coefficients of red, then of green, then of blue.
  void find_sh_rest() {
    const auto is_rest = [](const auto& field) { return field.first.starts_with("f_rest_"); };
    const auto count = std::size_t(std::count_if(fields_.begin(), fields_.end(), is_rest));
    int degree = 0;
    while (degree < 4 && 3 * std::size_t(sh_rest_count(degree)) < count) ++degree;
    if (3 * std::size_t(sh_rest_count(degree)) != count)
      fail("0, 9, 24, 45 or 72 properties f_rest_0, f_rest_1, ..., found " + std::to_string(count));
    layout_.stored_sh_degree = degree;
    layout_.sh_degree = std::min(degree, max_sh_degree);
    for (int j = 0; j < sh_rest_count(layout_.sh_degree); ++j)
      for (int c = 0; c < 3; ++c)
        layout_.sh_rest.push_back(take("f_rest_" + std::to_string(c * sh_rest_count(degree) + j)));
  }

  const Source& source_;
  std::uint64_t declared_at_;
  std::unordered_map<std::string, PlyField> fields_;
  std::unordered_map<std::string, PlyType> declared_types_;
  PlyLayout layout_;
  bool all_floats_ = true;
};

}  // namespace

PlyLayout find_layout(const Source& source, const PlyElement& vertex, PlyEncoding encoding) {
  return LayoutFinder(source, vertex, encoding).find();
}

}  // namespace swiftgs::io
