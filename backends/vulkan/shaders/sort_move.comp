// SPDX-License-Identifier: Apache-2.0
#version 460
#extension GL_GOOGLE_include_directive : require
#include "common.glsl"
#include "sort.glsl"

// Moves each pair behind those of lower digits, and those before it of the same digit. The pairs of a part are ordered in
// shared memory first, so that neighbouring threads write neighbouring words.
layout(constant_id = 3) const uint KEY_WORDS = 1u;

layout(push_constant, scalar) uniform Push {
  Uints keys;
  Uints numbers, sums;  // as sort_count.comp leaves them
  uvec2 values;
  Uints keys_to, values_to;
  Count count;
  uint run, shift, mask;
};

const uint SUBGROUPS = THREADS / SUBGROUP;

// Numbers of the digits in each subgroup's pairs, then the places of the first within the part.
shared uint places_of[SUBGROUPS * DIGITS];
shared uint to_global[DIGITS];  // what leads from a digit's places within the part to those in all
shared uint exchanged[PART];

// Adds up what rows from `first` to `end` have of digit `d`.
uint sum_of_rows(Uints rows, uint first, uint end, uint d) {
  uint sum = 0u;
  for (; first < end; first += 8u)
    [[unroll]] for (uint k = 0u; k < 8u; ++k) sum += first + k < end ? rows.at[(first + k) * DIGITS + d] : 0u;
  return sum;
}

uint ones(uvec4 lanes) { return bitCount(lanes.x) + bitCount(lanes.y); }

void main() {
  const uint n = number_of(count), part = workgroup(), parts = (n + PART - 1u) / PART;
  if (part >= parts) return;
  const uint size = min(n - part * PART, PART);
  for (uint d = thread(); d < SUBGROUPS * DIGITS; d += THREADS) places_of[d] = 0u;

  const uint first = gl_SubgroupID * SUBGROUP * EACH + gl_SubgroupInvocationID;  // in the part
  uint words[EACH], others[EACH], to[EACH];
  [[unroll]] for (uint k = 0u; k < EACH; ++k) {
    const uint i = part * PART + first + k * SUBGROUP;
    words[k] = others[k] = 0u;
    if (i < n) {
      words[k] = word_at(keys, KEY_WORDS, i, shift >> 5);
      if (KEY_WORDS == 2u) others[k] = word_at(keys, KEY_WORDS, i, 1u - (shift >> 5));
    }
  }
  // While the pairs are loaded.
  const uint DIGITS_EACH = DIGITS / THREADS;
  uint of_all_parts[DIGITS_EACH], of_earlier_parts[DIGITS_EACH];
  [[unroll]] for (uint k = 0u; k < DIGITS_EACH; ++k) {
    const uint d = k * THREADS + thread(), own_run = part / run, before_run = sum_of_rows(sums, 0u, own_run, d);
    of_all_parts[k] = before_run + sum_of_rows(sums, own_run, (parts + run - 1u) / run, d);
    of_earlier_parts[k] = before_run + sum_of_rows(numbers, own_run * run, part, d);
  }
  barrier();

  // Count by digit, and rank each pair among the earlier ones of its digit in this subgroup.
  [[unroll]] for (uint k = 0u; k < EACH; ++k) {
    const bool some = first + k * SUBGROUP < size;
    const uint digit = (words[k] >> (shift & 31u)) & mask;
    uvec4 same = subgroupBallot(some);
    [[unroll]] for (uint b = 0u; b < 8u; ++b) {
      const bool on = ((digit >> b) & 1u) != 0u;
      const uvec4 lanes = subgroupBallot(on);
      same &= on ? lanes : ~lanes;
    }
    same.zw = uvec2(0u);
    const uint before = ones(same & gl_SubgroupLtMask), at = gl_SubgroupID * DIGITS + digit, old = places_of[at];
    to[k] = old + before;
    share_in_subgroup();
    if (some && before == 0u) places_of[at] = old + ones(same);
    share_in_subgroup();
  }
  barrier();

  // Not before pairs are ranked, which needs the registers.
  uint payload[EACH];
  [[unroll]] for (uint k = 0u; k < EACH; ++k) {
    const uint i = part * PART + first + k * SUBGROUP;
    payload[k] = is_null(values) || i >= n ? i : Uints(values).at[i];
  }
  uint before_digits = 0u, before_in_part = 0u;
  [[unroll]] for (uint k = 0u; k < DIGITS_EACH; ++k) {
    const uint d = k * THREADS + thread();
    uint in_part = 0u, of_all, of_part;
    for (uint s = 0u; s < SUBGROUPS; ++s) in_part += places_of[s * DIGITS + d];
    const uint of_digits = before_digits + sum_before(of_all_parts[k], of_all);
    uint place = before_in_part + sum_before(in_part, of_part);
    to_global[d] = of_digits + of_earlier_parts[k] - place;
    for (uint s = 0u; s < SUBGROUPS; ++s) {
      const uint number = places_of[s * DIGITS + d];
      places_of[s * DIGITS + d] = place;
      place += number;
    }
    before_digits += of_all;
    before_in_part += of_part;
  }
  barrier();

  [[unroll]] for (uint k = 0u; k < EACH; ++k)
    if (first + k * SUBGROUP < size) {
      to[k] += places_of[gl_SubgroupID * DIGITS + ((words[k] >> (shift & 31u)) & mask)];
      exchanged[to[k]] = words[k];
    }
  barrier();
  uint global[EACH];
  [[unroll]] for (uint k = 0u; k < EACH; ++k) {
    const uint i = k * THREADS + thread();
    if (i >= size) continue;
    const uint word = exchanged[i];
    global[k] = i + to_global[(word >> (shift & 31u)) & mask];
    set_word(keys_to, KEY_WORDS, global[k], shift >> 5, word);
  }
  if (KEY_WORDS == 2u) {
    barrier();
    [[unroll]] for (uint k = 0u; k < EACH; ++k)
      if (first + k * SUBGROUP < size) exchanged[to[k]] = others[k];
    barrier();
    [[unroll]] for (uint k = 0u; k < EACH; ++k) {
      const uint i = k * THREADS + thread();
      if (i < size) set_word(keys_to, KEY_WORDS, global[k], 1u - (shift >> 5), exchanged[i]);
    }
  }
  barrier();
  [[unroll]] for (uint k = 0u; k < EACH; ++k)
    if (first + k * SUBGROUP < size) exchanged[to[k]] = payload[k];
  barrier();
  [[unroll]] for (uint k = 0u; k < EACH; ++k) {
    const uint i = k * THREADS + thread();
    if (i < size) values_to.at[global[k]] = exchanged[i];
  }
}
