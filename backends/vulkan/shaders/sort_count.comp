// SPDX-License-Identifier: Apache-2.0
#version 460
#extension GL_GOOGLE_include_directive : require
#include "common.glsl"
#include "sort.glsl"

shared uint numbers[DIGITS];

void main() {
  const uint n = number_of(count), part = workgroup(), parts = (n + PART - 1u) / PART;
  for (uint d = thread(); d < DIGITS; d += THREADS) numbers[d] = 0u;
  barrier();
  for (uint k = 0u; k < EACH; ++k) {
    const uint i = part * PART + k * THREADS + thread();
    if (i < n) atomicAdd(numbers[digit_of(i)], 1u);
  }
  barrier();
  if (part < parts)
    for (uint d = thread(); d < DIGITS; d += THREADS) places.at[d * parts + part] = numbers[d];
}
