// SPDX-License-Identifier: Apache-2.0

// A sum over an array in two steps: sums of parts, and the values.

const uint EACH = 8u, PART = EACH * THREADS;

layout(push_constant, scalar) uniform Push {
  Uints values, sums;
  Count count;
};
