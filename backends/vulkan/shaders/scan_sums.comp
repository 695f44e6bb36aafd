// SPDX-License-Identifier: Apache-2.0
#version 460
#extension GL_GOOGLE_include_directive : require
#include "common.glsl"
#include "scan.glsl"

// The sum of each part.
void main() {
  const uint n = number_of(count);
  if (workgroup() * PART >= n) return;
  const uint begin = workgroup() * PART + thread() * EACH;
  uint sum = 0u, total;
  for (uint k = 0u; k < EACH; ++k)
    if (begin + k < n) sum += values.at[begin + k];
  sum_before(sum, total);
  if (thread() == 0u) sums.at[workgroup()] = total;
}
