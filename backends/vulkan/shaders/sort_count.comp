// SPDX-License-Identifier: Apache-2.0
#version 460
#extension GL_GOOGLE_include_directive : require
#include "common.glsl"
#include "sort.glsl"

// Counts the pairs of each part and of each run of parts by digit.
layout(constant_id = 3) const uint KEY_WORDS = 1u;

layout(push_constant, scalar) uniform Push {
  Uints keys;
  Uints numbers;    // of parts, by digit
  Uints sums;       // of runs of parts, by digit
  Uints next_sums;  // those of the next pass, to be cleared
  Count count;
  uint run, shift, mask;
};

shared uint number_of_digit[DIGITS];

void main() {
  const uint n = number_of(count), part = workgroup(), parts = (n + PART - 1u) / PART;
  for (uint d = thread(); d < DIGITS; d += THREADS) number_of_digit[d] = 0u;
  barrier();
  uint words[EACH];
  [[unroll]] for (uint k = 0u; k < EACH; ++k) {
    const uint i = part * PART + k * THREADS + thread();
    words[k] = i < n ? word_at(keys, KEY_WORDS, i, shift >> 5) : 0u;
  }
  [[unroll]] for (uint k = 0u; k < EACH; ++k)
    if (part * PART + k * THREADS + thread() < n) atomicAdd(number_of_digit[(words[k] >> (shift & 31u)) & mask], 1u);
  barrier();
  if (part >= parts) return;
  for (uint d = thread(); d < DIGITS; d += THREADS) {
    const uint number = number_of_digit[d], of_run = part / run * DIGITS + d;
    numbers.at[part * DIGITS + d] = number;
    if (number != 0u) atomicAdd(sums.at[of_run], number);
    if (part % run == 0u) next_sums.at[of_run] = 0u;
  }
}
