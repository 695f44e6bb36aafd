// SPDX-License-Identifier: Apache-2.0

// What a device can do at most: copies, multiply-adds, exponentials and CUB's sorts, each measured by a
// kernel that does nothing else. benchmarks/tables/ceilings.py compares stages with these numbers.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <iostream>
#include <random>
#include <stdexcept>
#include <vector>

#include <cub/device/device_radix_sort.cuh>

#include <swiftgs/cuda.hpp>
#include <swiftgs/cuda/check.hpp>

namespace {

using swiftgs::check_cuda;
using swiftgs::DeviceBuffer;

constexpr int runs = 40, block = 256;
constexpr int copies = 4;                   // of a thread, so that enough of them are under way
constexpr std::size_t copied = 1u << 26;    // float4: a gibibyte
constexpr int chains = 8, steps = 1 << 14;  // of a thread; the next operation of a chain waits for the last
constexpr std::array<int, 6> pairs = {100'000, 300'000, 1'000'000, 2'000'000, 5'000'000, 10'000'000};

__global__ void copy(const float4* from, float4* to) {
  const std::size_t first = std::size_t(blockIdx.x) * (copies * block) + threadIdx.x;
  float4 values[copies];
#pragma unroll
  for (int i = 0; i < copies; ++i) values[i] = from[first + i * block];
#pragma unroll
  for (int i = 0; i < copies; ++i) to[first + i * block] = values[i];
}

struct MultiplyAdd {
  float factor, term;
  __device__ float operator()(float x) const { return __fmaf_rn(x, factor, term); }
};

struct Exponential {
  __device__ float operator()(float x) const {
    float power;
    asm("ex2.approx.ftz.f32 %0, %1;" : "=f"(power) : "f"(-x));  // stays within 0.5 and 1
    return power;
  }
};

template <class Operation>
__global__ void repeat(Operation operation, float* results) {
  float x[chains];
#pragma unroll
  for (int c = 0; c < chains; ++c) x[c] = float(threadIdx.x + c) / block;
#pragma unroll 16
  for (int i = 0; i < steps; ++i)
#pragma unroll
    for (int c = 0; c < chains; ++c) x[c] = operation(x[c]);
  float sum = 0;
#pragma unroll
  for (int c = 0; c < chains; ++c) sum += x[c];
  results[blockIdx.x * block + threadIdx.x] = sum;
}

template <class T>
DeviceBuffer<T> on_device(std::size_t count) {
  DeviceBuffer<T> buffer;
  buffer.reset_exactly(count);
  return buffer;
}

/// Of a run, the median of `runs` after as many to warm up. The device never waits for the host between them.
template <class Run>
double median_seconds(const Run& run) {
  std::array<cudaEvent_t, runs + 1> events;
  for (cudaEvent_t& event : events) check_cuda(cudaEventCreate(&event), "cudaEventCreate");
  for (int i = 0; i < runs; ++i) run();
  for (cudaEvent_t event : events) {
    check_cuda(cudaEventRecord(event), "cudaEventRecord");
    if (event != events.back()) run();
  }
  check_cuda(cudaDeviceSynchronize(), "cudaDeviceSynchronize");
  std::array<float, runs> ms;
  for (int i = 0; i < runs; ++i)
    check_cuda(cudaEventElapsedTime(&ms[i], events[i], events[i + 1]), "cudaEventElapsedTime");
  for (cudaEvent_t event : events) check_cuda(cudaEventDestroy(event), "cudaEventDestroy");
  std::sort(ms.begin(), ms.end());
  return 1e-3 * 0.5 * (double(ms[(runs - 1) / 2]) + double(ms[runs / 2]));
}

double copied_bytes_per_second() {
  DeviceBuffer<float4> from = on_device<float4>(copied), to = on_device<float4>(copied);
  check_cuda(cudaMemset(from.data(), 0, copied * sizeof(float4)), "cudaMemset");
  return 2.0 * copied * sizeof(float4) / median_seconds([&] {
           copy<<<copied / (copies * block), block>>>(from.data(), to.data());
           check_cuda(cudaGetLastError(), "copy");
         });
}

template <class Operation>
double operations_per_second(Operation operation) {
  int device = 0, processors = 0;
  check_cuda(cudaGetDevice(&device), "cudaGetDevice");
  check_cuda(cudaDeviceGetAttribute(&processors, cudaDevAttrMultiProcessorCount, device),
             "cudaDeviceGetAttribute");
  const int blocks = 8 * processors;  // all 2048 threads of each
  DeviceBuffer<float> results = on_device<float>(std::size_t(blocks) * block);
  return double(blocks) * block * chains * steps / median_seconds([&] {
           repeat<<<blocks, block>>>(operation, results.data());
           check_cuda(cudaGetLastError(), "repeat");
         });
}

/// Of random keys with values of 32 bits, by the lowest `bits` of the keys.
template <class Key>
void print_sorts(int bits) {
  std::vector<Key> random(pairs.back());
  std::mt19937_64 next(1);
  for (Key& key : random) key = Key(next());
  DeviceBuffer<Key> keys = on_device<Key>(random.size()), sorted_keys = on_device<Key>(random.size());
  DeviceBuffer<std::uint32_t> values = on_device<std::uint32_t>(random.size());
  DeviceBuffer<std::uint32_t> sorted_values = on_device<std::uint32_t>(random.size());
  check_cuda(cudaMemcpy(keys.data(), random.data(), random.size() * sizeof(Key), cudaMemcpyHostToDevice),
             "cudaMemcpy");
  check_cuda(cudaMemset(values.data(), 0, random.size() * sizeof(std::uint32_t)), "cudaMemset");
  for (const int number : pairs) {
    std::size_t bytes = 0;
    const auto sort = [&](void* room) {
      check_cuda(cub::DeviceRadixSort::SortPairs(room, bytes, keys.data(), sorted_keys.data(), values.data(),
                                                 sorted_values.data(), number, 0, bits),
                 "cub::DeviceRadixSort::SortPairs");
    };
    sort(nullptr);  // asks for `bytes`
    DeviceBuffer<std::byte> room = on_device<std::byte>(bytes);
    std::printf("{\"ceiling\":\"sort\",\"key_bits\":%d,\"sorted_bits\":%d,\"pairs\":%d,",
                int(8 * sizeof(Key)), bits, number);
    std::printf("\"ms\":{\"total\":{\"median\":%.4g}}}\n", 1e3 * median_seconds([&] { sort(room.data()); }));
  }
}

void print_rate(const char* ceiling, double per_second) {
  std::printf("{\"ceiling\":\"%s\",\"per_s\":%.4g}\n", ceiling, per_second);
}

}  // namespace

/// Rows as JSON to the four digits that a measurement has, for benchmarks/result_file.sh.
int main() try {
  if (!swiftgs::Cuda::usable())
    throw std::runtime_error("expected a device that the kernels of this build run on");
  print_rate("copy", copied_bytes_per_second());
  print_rate("fma", operations_per_second(MultiplyAdd{0.75f, 0.25f}));
  print_rate("ex2", operations_per_second(Exponential()));
  print_sorts<std::uint32_t>(32);  // depths
  print_sorts<std::uint16_t>(13);  // tiles, up to 8192 of them
} catch (const std::exception& error) {
  std::cerr << "ceilings: " << error.what() << '\n';
  return 1;
}
