// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>

namespace swiftgs::cli {

/// Keeps oneTBB, and so renderers that are made meanwhile, to a number of threads.
class ThreadLimit {
 public:
  /// 0 for as many as there are processors. Throws `std::invalid_argument` for more than those, or in a build
  /// without oneTBB for any but 0.
  explicit ThreadLimit(std::size_t threads);
  ~ThreadLimit();

  int threads() const { return threads_; }

 private:
  struct Control;
  std::unique_ptr<Control> control_;
  int threads_;
};

}  // namespace swiftgs::cli
