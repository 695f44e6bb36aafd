// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <string>
#include <vector>

namespace swiftgs::cli {

/// `notes` as results list them, behind the name of their file.
std::vector<std::string> notes_of(const std::string& file, const std::vector<std::string>& notes);

/// Prints the notes of a reader or a writer about `file` on standard error, a line for each note, and adds
/// the lines to `said`, for `ResultHead::notes`. A line that `said` already has is not printed again. Of
/// several processes the first prints.
void say_notes(const std::string& file, const std::vector<std::string>& notes,
               std::vector<std::string>& said);

/// Shows on standard error how much of `total` is done, and about how long the rest takes: a bar on a
/// terminal, elsewhere a line now and then. Of several processes that share a command the first shows what
/// all have done.
class Progress {
 public:
  /// Where there is no terminal, lines are at least `between_lines` apart, and a command that takes no longer
  /// says nothing.
  explicit Progress(std::size_t total, std::chrono::milliseconds between_lines = std::chrono::seconds(5));
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
  void begin_part(std::size_t end) { begin_ = done_, end_ = end, begun_ = Clock::now(); }
  /// Returns when all processes have come here, and shows what is done meanwhile.
  void await_others();
  /// Removes the bar, so that a line can be printed.
  void clear();

 private:
  using Clock = std::chrono::steady_clock;

  std::string time_left() const;
  void draw_bar(const std::string& what);
  void print_line(const std::string& what);

  std::size_t total_, done_ = 0;
  std::size_t begin_ = 0, end_ = total_;  ///< of the part whose time is told
  Clock::time_point begun_ = Clock::now();
  bool leads_, terminal_, shown_ = false;
  std::chrono::milliseconds between_lines_;
  Clock::time_point last_line_ = Clock::now();
};

}  // namespace swiftgs::cli
