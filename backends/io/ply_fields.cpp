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
    fields_[property.name] = {.field = {type, row_bytes_}, .declared = property.type, .taken = false};
    row_bytes_ += size_of(type);
  }
}

PlyFields::Known& PlyFields::known(const std::string& name) {
  const auto found = fields_.find(name);
  if (found == fields_.end()) fail("a property '" + name + "' of element '" + element_.name + "'");
  found->second.taken = true;
  return found->second;
}

PlyField PlyFields::take(const std::string& name) { return known(name).field; }

PlyField PlyFields::take(const std::string& name, PlyType type, const char* type_name) {
  const Known& found = known(name);
  if (found.declared != type) fail("'" + name + "' of type " + type_name);
  return found.field;
}

// The file holds all coefficients of red, then of green, then of blue.
PlySh PlyFields::find_sh() {
  std::size_t count = 0;
  for (auto& [name, known] : fields_)
    if (name.starts_with("f_rest_")) known.taken = true, ++count;
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

std::vector<std::string> PlyFields::untaken() const {
  std::vector<std::string> names;
  for (const PlyProperty& property : element_.properties) {
    const bool normal = property.name == "nx" || property.name == "ny" || property.name == "nz";
    if (!normal && !fields_.at(property.name).taken) names.push_back(property.name);
  }
  return names;
}

}  // namespace swiftgs::io
