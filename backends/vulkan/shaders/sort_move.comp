// SPDX-License-Identifier: Apache-2.0
#version 460
#extension GL_GOOGLE_include_directive : require
#include "common.glsl"
#define MOVES
#include "sort.glsl"

const uint SUBGROUPS = THREADS / SUBGROUP;

// Numbers of the digits in each subgroup's pairs, then the places of the first.
shared uint places_of[SUBGROUPS * DIGITS];

uint ones(uvec4 lanes) { return bitCount(lanes.x) + bitCount(lanes.y); }

void main() {
  const uint n = number_of(count), part = workgroup(), parts = (n + PART - 1u) / PART;
  for (uint d = thread(); d < SUBGROUPS * DIGITS; d += THREADS) places_of[d] = 0u;
  barrier();

  // Count by digit, and rank each pair among the earlier ones of its digit in this subgroup.
  const uint first = part * PART + gl_SubgroupID * SUBGROUP * EACH + gl_SubgroupInvocationID;
  uint rank[EACH];
  for (uint k = 0u; k < EACH; ++k) {
    const uint i = first + k * SUBGROUP;
    const bool some = i < n;
    const uint digit = some ? digit_of(i) : 0u;
    uvec4 same = subgroupBallot(some);
    for (uint b = 0u; b < 8u; ++b) {
      const bool on = ((digit >> b) & 1u) != 0u;
      const uvec4 lanes = subgroupBallot(on);
      same &= on ? lanes : ~lanes;
    }
    same.zw = uvec2(0u);
    const uint before = ones(same & gl_SubgroupLtMask), at = gl_SubgroupID * DIGITS + digit, old = places_of[at];
    rank[k] = old + before;
    subgroupBarrier();
    if (some && before == 0u) places_of[at] = old + ones(same);
    subgroupMemoryBarrierShared();
    subgroupBarrier();
  }
  barrier();
  for (uint d = thread(); d < DIGITS; d += THREADS) {
    uint place = part < parts ? places.at[d * parts + part] : 0u;
    for (uint s = 0u; s < SUBGROUPS; ++s) {
      const uint number = places_of[s * DIGITS + d];
      places_of[s * DIGITS + d] = place;
      place += number;
    }
  }
  barrier();
  for (uint k = 0u; k < EACH; ++k) {
    const uint i = first + k * SUBGROUP;
    if (i >= n) continue;
    const uint to = places_of[gl_SubgroupID * DIGITS + digit_of(i)] + rank[k];
    Uints key = key_of(keys, i), key_to = key_of(keys_to, to);
    for (uint word = 0u; word < KEY_WORDS; ++word) key_to.at[word] = key.at[word];
    values_to.at[to] = is_null(values) ? i : Uints(values).at[i];
  }
}
