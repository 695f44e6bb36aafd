// SPDX-License-Identifier: Apache-2.0
#include "ply_layout.hpp"

#include <algorithm>

#include "listed.hpp"

namespace swiftgs::io {
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
