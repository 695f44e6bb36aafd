// SPDX-License-Identifier: Apache-2.0
#version 460
#extension GL_GOOGLE_include_directive : require
#include "common.glsl"
#include "sort.glsl"

// A workgroup has a digit: replaces its number in each part by the sum of those before, and stores the sum of all.
layout(push_constant, scalar) uniform Push {
  Uints numbers;  // by digit, then by part
  Uints totals;   // by digit
  Count count;
  uint part_size;
};

const uint NUMBERS = 4u;

void main() {
  const uint parts = (number_of(count) + part_size - 1u) / part_size, row = workgroup() * parts;
  uint before = 0u;
  for (uint first = 0u; first < parts; first += NUMBERS * THREADS) {
    const uint at = first + NUMBERS * thread();
    uint each[NUMBERS], sum = 0u, total;
    [[unroll]] for (uint k = 0u; k < NUMBERS; ++k) {
      each[k] = at + k < parts ? numbers.at[row + at + k] : 0u;
      sum += each[k];
    }
    uint place = before + sum_before(sum, total);
    [[unroll]] for (uint k = 0u; k < NUMBERS; ++k) {
      if (at + k < parts) numbers.at[row + at + k] = place;
      place += each[k];
    }
    before += total;
  }
  if (thread() == 0u) totals.at[workgroup()] = before;
}
