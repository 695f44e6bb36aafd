// SPDX-License-Identifier: Apache-2.0

// Compiled as C++17 beside swiftgs::cuda.
static_assert(__cplusplus == 201703L, "linking swiftgs::cuda leaves the standard of kernels alone");

__global__ void kernel_of_another(int* value) { *value = 17; }
