// SPDX-License-Identifier: Apache-2.0
#version 460
#extension GL_GOOGLE_include_directive : require
#include "common.glsl"
#include "scan.glsl"

// Replaces each value by the sum of those before it. Each workgroup adds up the parts before its own, which spares a
// launch.
void main() {
  const uint n = number_of(count);
  if (workgroup() * PART >= n) return;
  const uint begin = workgroup() * PART + thread() * EACH;
  uint each[EACH], sum = 0u, total;
  for (uint k = 0u; k < EACH; ++k) {
    each[k] = begin + k < n ? values.at[begin + k] : 0u;
    sum += each[k];
  }
  uint of_parts = 0u, before_part;
  for (uint part = thread(); part < workgroup(); part += THREADS) of_parts += sums.at[part];
  sum_before(of_parts, before_part);
  uint before = before_part + sum_before(sum, total);
  for (uint k = 0u; k < EACH; ++k) {
    if (begin + k < n) values.at[begin + k] = before;
    before += each[k];
  }
}
