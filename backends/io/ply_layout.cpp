// SPDX-License-Identifier: Apache-2.0
#include "ply_layout.hpp"

#include <algorithm>

namespace swiftgs::io {
namespace {

bool all_floats_in(const PlyLayout& layout) {
  const auto floats = [](const auto& fields) {
    return std::all_of(fields.begin(), fields.end(), [](PlyField f) { return f.type == PlyType::f32; });
  };
  return floats(layout.mean) && floats(layout.scale) && floats(layout.colour) && floats(layout.rotation) &&
         layout.opacity.type == PlyType::f32 && floats(layout.sh.fields);
}

}  // namespace

PlyLayout find_layout(const Source& source, const PlyElement& vertex, PlyEncoding encoding) {
  PlyFields fields(source, vertex, encoding);
  if (fields.has("packed_position")) fields.fail("an element 'chunk' beside the packed vertices");
  PlyLayout layout;
  const auto three = [&](const char* a, const char* b, const char* c) {
    return std::array{fields.take(a), fields.take(b), fields.take(c)};
  };
  layout.mean = three("x", "y", "z");
  layout.has_third_scale = fields.has("scale_2");
  layout.scale = three("scale_0", "scale_1", layout.has_third_scale ? "scale_2" : "scale_1");
  layout.rotation = {fields.take("rot_0"), fields.take("rot_1"), fields.take("rot_2"), fields.take("rot_3")};
  layout.opacity = fields.take("opacity");
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
