// SPDX-License-Identifier: Apache-2.0

// Prefix sums of one number a workgroup: `numbers` holds each, `runs` the sum of each RUN of them, which a launch clears
// before. Integers: the order of workgroups changes no bit.
const uint RUN = 4u * THREADS;

// Notes the number of workgroup `w`, by one thread.
void add_number(Uints numbers, Uints runs, uint w, uint number) {
  numbers.at[w] = number;
  if (number != 0u) atomicAdd(runs.at[w / RUN], number);
}

// The sum of the numbers of the workgroups before `w`. All threads call it.
uint numbers_before(Uints numbers, Uints runs, uint w) {
  uint sum = 0u, total;
  for (uint r = thread(); r < w / RUN; r += THREADS) sum += runs.at[r];
  const uint first = w / RUN * RUN + 4u * thread();
  if (first < w) {
    const uvec4 four = Fours(uvec2(numbers)).at[first / 4u];
    [[unroll]] for (uint k = 0u; k < 4u; ++k) sum += first + k < w ? four[k] : 0u;
  }
  sum_before(sum, total);
  return total;
}
