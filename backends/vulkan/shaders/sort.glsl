// SPDX-License-Identifier: Apache-2.0

// A pass of the radix sort by 8 bits. A workgroup has a part of the pairs, and each of its subgroups some consecutive
// ones. Keys have one word or two, and positions take the place of values that are null.

layout(constant_id = 4) const uint EACH = 16u;  // pairs of a thread
const uint PART = EACH * THREADS, DIGITS = 256u;

uint word_at(Uints keys, uint words, uint i, uint w) { return words == 1u ? keys.at[i] : pair_at(keys, i).at[w]; }
void set_word(Uints keys, uint words, uint i, uint w, uint value) {
  if (words == 1u) keys.at[i] = value;
  else pair_at(keys, i).at[w] = value;
}
