// SPDX-License-Identifier: Apache-2.0

// Attributes of a pass: `AttributeList` of the host.

// The order of `Attribute::Of`.
const uint of_ray_depth = 1u, of_normal = 2u, of_squared_depth = 3u, of_squared_ray_depth = 4u, of_feature = 5u;

struct Attribute {
  uint of, channel;
};
struct AttributeList {
  Attribute each[16];
  float most;  // largest magnitude that is summed
  uint has_normal, has_ray_depth;
  uint count;
};
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer AttributeLists { AttributeList at[]; };
