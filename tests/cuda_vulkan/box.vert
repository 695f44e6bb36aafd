// SPDX-License-Identifier: Apache-2.0
#version 450
layout(push_constant) uniform Matrix { mat4 matrix; };
layout(location = 0) flat out vec3 colour;

void main() {
  const int corners[6] = int[](0, 1, 2, 2, 1, 3);
  int face = gl_VertexIndex / 6, axis = face / 2, corner = corners[gl_VertexIndex % 6];
  vec3 at;
  at[axis] = face % 2 * 2 - 1;
  at[(axis + 1) % 3] = corner % 2 * 2 - 1;
  at[(axis + 2) % 3] = corner / 2 * 2 - 1;
  colour = vec3(0.9, 0.55, 0.15) * (0.4 + 0.1 * face);
  gl_Position = matrix * vec4(vec3(0.02, -1.16, 0.02) + vec3(0.55, 0.2, 0.2) * at, 1);
}
