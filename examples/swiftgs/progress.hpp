// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <string>

namespace swiftgs::cli {

/// A bar on standard error that shows how much of `total` is done, and about how long the rest takes. Nothing
/// is written where standard error is not a terminal. Of several processes that share a command the first
/// shows the bar of all.
class Progress {
 public:
  explicit Progress(std::size_t total);
  ~Progress() { clear(); }
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// Shows that `what` has begun.
  void start(const std::string& what);
  /// One more of the total is done.
  void step();
  /// So much of the total is done.
  void advance_to(std::size_t done) { done_ = done; }
  /// From here to `end` is work of one kind: from now on the time left is told for it alone.
  void begin_part(std::size_t end) { begin_ = done_, end_ = end, begun_ = std::chrono::steady_clock::now(); }
  /// Returns when all processes have come here, and shows what is done meanwhile.
  void await_others();
  /// Removes the bar, so that a line can be printed.
  void clear();

 private:
  std::string time_left() const;

  std::size_t total_, done_ = 0;
  std::size_t begin_ = 0, end_ = total_;  ///< of the part whose time is told
  std::chrono::steady_clock::time_point begun_ = std::chrono::steady_clock::now();
  bool terminal_, shown_ = false;
};

}  // namespace swiftgs::cli
