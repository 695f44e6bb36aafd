// SPDX-License-Identifier: Apache-2.0
#include "ply_fields.hpp"

#include <algorithm>

#include <swiftgs/scene.hpp>

namespace swiftgs::io {

PlyFields::PlyFields(const Source& source, const PlyElement& element, PlyEncoding encoding)
    : source_(source), element_(element) {
  for (const PlyProperty& property : element.properties) {
    if (property.list_count)
      fail("element '" + element.name + "' without list properties, found list '" + property.name + "'");
    const PlyType type = encoding == PlyEncoding::ascii ? PlyType::f64 : property.type;
    fields_[property.name] = {type, row_bytes_};
    declared_types_[property.name] = property.type;
    row_bytes_ += size_of(type);
  }
}

PlyField PlyFields::take(const std::string& name) const {
  const auto found = fields_.find(name);
  if (found == fields_.end()) fail("a property '" + name + "' of element '" + element_.name + "'");
  return found->second;
}

PlyField PlyFields::take(const std::string& name, PlyType type, const char* type_name) const {
  const PlyField field = take(name);
  if (declared_types_.at(name) != type) fail("'" + name + "' of type " + type_name);
  return field;
}

// The file holds all coefficients of red, then of green, then of blue.
PlySh PlyFields::find_sh() const {
  const auto is_rest = [](const auto& field) { return field.first.starts_with("f_rest_"); };
  const auto count = std::size_t(std::count_if(fields_.begin(), fields_.end(), is_rest));
  PlySh sh;
  while (sh.stored_degree < 4 && 3 * std::size_t(sh_rest_count(sh.stored_degree)) < count) ++sh.stored_degree;
  const int stored = sh_rest_count(sh.stored_degree);
  if (3 * std::size_t(stored) != count)
    fail("0, 9, 24, 45 or 72 properties f_rest_0, f_rest_1, ..., found " + std::to_string(count));
  sh.degree = std::min(sh.stored_degree, max_sh_degree);
  for (int j = 0; j < sh_rest_count(sh.degree); ++j)
    for (int c = 0; c < 3; ++c) sh.fields.push_back(take("f_rest_" + std::to_string(c * stored + j)));
  return sh;
}

}  // namespace swiftgs::io
