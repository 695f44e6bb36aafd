// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

namespace swiftgs::cli {

/// Keeps oneTBB, and so renderers that are made meanwhile, to a number of threads.
class ThreadLimit {
 public:
  /// Without `threads` as many as there are processors. Throws `InvalidArgument` for less than 1 and
  /// for more than those, and in a build without oneTBB for any number.
  explicit ThreadLimit(std::optional<std::int64_t> threads);
  ~ThreadLimit();

  int threads() const { return threads_; }

 private:
  struct Control;
  std::unique_ptr<Control> control_;
  int threads_;
};

}  // namespace swiftgs::cli
