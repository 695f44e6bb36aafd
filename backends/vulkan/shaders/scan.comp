// SPDX-License-Identifier: Apache-2.0
#version 460
#extension GL_GOOGLE_include_directive : require
#include "common.glsl"

// The sum before each number, and behind them the sum of all. A workgroup has a part of the numbers and adds up all that
// lie before, which spares launches: there are few numbers, one of each workgroup of other kernels.
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer Fours { uvec4 at[]; };

layout(push_constant, scalar) uniform Push {
  Fours numbers;
  Uints to;
  Count count;  // of what the numbers are of
  uint each;    // of it, a number
};

const uint PART = 4u * THREADS;

void main() {
  const uint n = (number_of(count) + each - 1u) / each;
  if (workgroup() * PART > n) return;
  uint before = 0u, total;
  for (uint i = thread(); i < workgroup() * THREADS; i += THREADS) {
    const uvec4 four = numbers.at[i];
    before += four.x + four.y + four.z + four.w;
  }
  uint of_earlier_parts;
  sum_before(before, of_earlier_parts);
  const uint i = workgroup() * THREADS + thread();
  uvec4 four = uvec4(0u);
  for (uint k = 0u; k < 4u; ++k)
    if (4u * i + k < n) four[k] = Uints(uvec2(numbers)).at[4u * i + k];
  before = of_earlier_parts + sum_before(four.x + four.y + four.z + four.w, total);
  for (uint k = 0u; k < 4u; ++k) {
    if (4u * i + k <= n) to.at[4u * i + k] = before;
    before += four[k];
  }
}
