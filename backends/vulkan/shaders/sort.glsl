// SPDX-License-Identifier: Apache-2.0

// A pass of the radix sort by 8 bits. A workgroup has a part of the pairs, and each of its subgroups some consecutive
// ones. Keys have one word or two, and positions take the place of values that are null.

layout(constant_id = 3) const uint KEY_WORDS = 1u;

const uint EACH = 16u, PART = EACH * THREADS, DIGITS = 256u;

layout(push_constant, scalar) uniform Push {
  Uints keys;
  Uints places;  // by digit, then by part: numbers, then sums before
#ifdef MOVES
  uvec2 values;
  Uints keys_to, values_to;
#endif
  Count count;
  uint shift, mask;
};

// Numbers of words may exceed 2^31, where indices turn negative.
Uints key_of(Uints all, uint i) { return Uints(element(uvec2(all), i, 4u * KEY_WORDS)); }
uint digit_of(uint i) { return (key_of(keys, i).at[shift >> 5] >> (shift & 31u)) & mask; }
