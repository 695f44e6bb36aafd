// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <span>

#include <sanitizer/allocator_interface.h>

#include <swiftgs/error.hpp>
#include <swiftgs/io/scene_file.hpp>

#include "io/memory_factors.hpp"

namespace swiftgs::fuzz {

/// Bytes that all code of the program has taken and not given back, C libraries included.
class HeldMemory {
 public:
  /// The most since `start`, beyond what was held then.
  static double most() { return double(most_ - at_start_); }
  static void start() {
    static const bool hooked = __sanitizer_install_malloc_and_free_hooks(on_malloc, on_free) != 0;
    if (!hooked) std::abort();
    at_start_ = held_.load(), most_ = held_.load();
  }

 private:
  static void on_malloc(const volatile void*, std::size_t size) {
    const std::ptrdiff_t now = held_ += std::ptrdiff_t(size);
    for (std::ptrdiff_t most = most_; now > most && !most_.compare_exchange_weak(most, now);) {
    }
  }
  static void on_free(const volatile void* memory) {
    held_ -= std::ptrdiff_t(__sanitizer_get_allocated_size(memory));
  }

  static inline std::atomic<std::ptrdiff_t> held_ = 0, most_ = 0, at_start_ = 0;
};

inline void require(bool holds, const char* what, double found) {
  if (holds) return;
  std::fprintf(stderr, "expected %s, found %g\n", what, found);
  std::abort();
}

/// Reads a file of `bytes` by `read`, which takes options and returns a `SceneFile`. That must be a valid
/// scene or throw `FormatError`, take no more memory than `factor` allows, and tell a progress that grows.
/// The last byte says at which report a second reading is cancelled, which must throw `Cancelled`.
template <class Read>
void read_watched(std::span<const std::byte> bytes, const test::MemoryFactor& factor, const Read& read) {
  int reports = 0;
  double last = 0;
  SceneReadOptions options;
  options.progress = [&](double part) {
    require(part >= last && part <= 1, "progress that grows to 1", part);
    last = part, ++reports;
    return true;
  };
  HeldMemory::start();
  try {
    validate(read(options).scene);
  } catch (const FormatError&) {
  }
  require(HeldMemory::most() <= factor.bytes_of(bytes.size()), "less memory than the stated factor",
          HeldMemory::most() / double(bytes.size()));

  if (reports == 0 || bytes.empty()) return;
  int left = std::to_integer<int>(bytes.back()) % reports + 1;
  bool asked = false, cancelled = false;
  options.progress = [&](double) { return asked = asked || --left == 0, !asked; };
  try {
    read(options);
  } catch (const FormatError&) {
  } catch (const Cancelled&) {
    cancelled = true;
  }
  require(cancelled == asked, "a reader that stops when it is asked to", cancelled);
}

}  // namespace swiftgs::fuzz
