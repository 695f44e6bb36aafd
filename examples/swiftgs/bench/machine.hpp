// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace swiftgs::cli {

/// Where and with what something is measured.
struct Machine {
  struct Gpu {
    std::string name, driver;
    std::string cuda;  ///< toolkit that compiled the kernels
    double memory_gib = 0;
  };

  std::string date;  ///< YYYY-MM-DD, UTC
  std::string cpu, system;
  int cores = 0;
  double memory_gib = 0;
  std::optional<Gpu> gpu;
  std::string compiler, flags, commit, version;
  double load = 0;  ///< processes that want to run, mean of the last minute
};

/// This machine now. What it does not tell is "unknown".
Machine describe_machine();

/// The words that this program was called with, after its own name. As a shell takes them, and without
/// `left_out`.
std::string command_line(std::string_view left_out = {});

/// Gives memory that is free within this process back to the system, so that taking it again is seen.
void release_free_memory();

/// Memory that this process takes, and memory that processes could still be given. @units{bytes}
std::size_t resident_memory();
std::size_t available_memory();

}  // namespace swiftgs::cli
