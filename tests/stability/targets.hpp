// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What a stage runs on: the plain functions, and the Cpu backend on each vector target of the machine.

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <hwy/targets.h>

#include "policies/backends.hpp"
#include "policies/only_targets.hpp"

namespace swiftgs::test {

/// Target 0 is `serial`; the others are those that Highway chooses among.
class Targets {
 public:
  Targets() {
    for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) vector_.push_back(target);
  }

  std::size_t size() const { return 1 + vector_.size(); }
  std::string name(std::size_t i) const {
    return i == 0 ? "serial" : std::string("cpu ") + hwy::TargetName(vector_[i - 1]);
  }

  /// Calls f(backend) with the backend of target `i`.
  template <class F>
  void on(std::size_t i, const F& f) {
    if (i == 0) return f(serial_);
    const OnlyTargets only(vector_[i - 1]);
    f(cpu_);
  }

 private:
  Serial serial_;
  Cpu cpu_{1};
  std::vector<std::int64_t> vector_;
};

}  // namespace swiftgs::test
