// SPDX-License-Identifier: Apache-2.0

#include "ply_fields.hpp"

#include <algorithm>
#include <unordered_set>

#include <swiftgs/scene.hpp>

#include "text.hpp"

namespace swiftgs::io {

namespace {

std::string_view without_prefix(std::string_view name) {
  for (const std::string_view prefix : {"scalar_", "scal_"})
    if (name.starts_with(prefix)) name.remove_prefix(prefix.size());
  return name;
}

}  // namespace

double scalar_at(const std::byte* row, PlyField field, std::endian order) {
  const std::byte* at = row + field.offset;
  switch (field.type) {
    case PlyType::i8:
      return load<std::int8_t>(at, order);
    case PlyType::u8:
      return load<std::uint8_t>(at, order);
    case PlyType::i16:
      return load<std::int16_t>(at, order);
    case PlyType::u16:
      return load<std::uint16_t>(at, order);
    case PlyType::i32:
      return load<std::int32_t>(at, order);
    case PlyType::u32:
      return load<std::uint32_t>(at, order);
    case PlyType::f32:
      return load<float>(at, order);
    default:
      return load<double>(at, order);
  }
}

PlyFields::PlyFields(const Source& source, const PlyElement& element, PlyEncoding encoding)
    : source_(source), element_(element) {
  std::unordered_set<std::string_view> stored;
  for (const PlyProperty& property : element.properties) stored.insert(property.name);
  for (const PlyProperty& property : element.properties) {
    if (property.list_count)
      fail("element '" + element.name + "' without list properties, found list '" + property.name + "'");
    const PlyType type = encoding == PlyEncoding::ascii ? PlyType::f64 : property.type;
    const std::string_view plain = without_prefix(property.name);
    names_.push_back(stored.insert(plain).second ? plain : std::string_view(property.name));
    fields_[names_.back()] = {.field = {type, row_bytes_}, .declared = property.type, .taken = false};
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
  for (const std::string_view name : names_) {
    const bool normal = name == "nx" || name == "ny" || name == "nz";
    if (!normal && !fields_.at(name).taken) names.emplace_back(name);
  }
  return names;
}

namespace {

bool all_floats_in(const PlyLayout& layout) {
  const auto floats = [](const auto& fields) {
    return std::all_of(fields.begin(), fields.end(), [](PlyField f) { return f.type == PlyType::f32; });
  };
  return floats(layout.mean) && floats(layout.scale) && floats(layout.colour) && floats(layout.rotation) &&
         layout.opacity.type == PlyType::f32 && (!layout.filter || layout.filter->type == PlyType::f32) &&
         floats(layout.sh.fields);
}

/// A cloud of points, or the corners of a mesh, lacks all that makes a Gaussian.
bool holds_points_alone(const PlyFields& fields) {
  const auto lacks = [&](const char* name) { return !fields.has(name); };
  return fields.has("x") && lacks("scale_0") && lacks("rot_0") && lacks("opacity") && lacks("f_dc_0");
}

}  // namespace

bool PlyLayout::wide_means() const {
  return std::any_of(mean.begin(), mean.end(), [](PlyField f) {
    return f.type == PlyType::f64 || f.type == PlyType::i32 || f.type == PlyType::u32;
  });
}

PlyLayout find_layout(const Source& source, const PlyElement& vertex, PlyEncoding encoding) {
  PlyFields fields(source, vertex, encoding);
  if (fields.has("packed_position")) fields.fail("an element 'chunk' beside the packed vertices");
  if (holds_points_alone(fields))
    fields.fail("Gaussians, found a point cloud with no Gaussians: properties " +
                listed(fields.names(), " "));
  PlyLayout layout;
  const auto three = [&](const char* a, const char* b, const char* c) {
    return std::array{fields.take(a), fields.take(b), fields.take(c)};
  };
  layout.mean = three("x", "y", "z");
  layout.has_third_scale = fields.has("scale_2");
  layout.scale = three("scale_0", "scale_1", layout.has_third_scale ? "scale_2" : "scale_1");
  layout.rotation = {fields.take("rot_0"), fields.take("rot_1"), fields.take("rot_2"), fields.take("rot_3")};
  layout.opacity = fields.take("opacity");
  if (fields.has("filter_3D")) layout.filter = fields.take("filter_3D");
  layout.byte_colour = !fields.has("f_dc_0") && fields.has("red");
  const auto byte = [&](const char* name) { return fields.take(name, PlyType::u8, "uchar"); };
  layout.colour = layout.byte_colour ? std::array{byte("red"), byte("green"), byte("blue")}
                                     : three("f_dc_0", "f_dc_1", "f_dc_2");
  layout.sh = fields.find_sh();
  layout.all_floats = all_floats_in(layout);
  layout.row_bytes = fields.row_bytes();
  layout.unread = fields.untaken();
  return layout;
}

}  // namespace swiftgs::io
