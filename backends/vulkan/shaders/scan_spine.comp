// SPDX-License-Identifier: Apache-2.0
#version 460
#extension GL_GOOGLE_include_directive : require
#include "common.glsl"
#include "scan.glsl"

// One workgroup: the sums before each part.
void main() {
  const uint parts = (number_of(count) + PART - 1u) / PART;
  uint carry = 0u;
  for (uint first = 0u; first < parts; first += THREADS) {
    const uint i = first + thread();
    uint total;
    const uint before = sum_before(i < parts ? sums.at[i] : 0u, total);
    if (i < parts) sums.at[i] = carry + before;
    carry += total;
  }
}
