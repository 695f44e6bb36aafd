// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <utility>

#include <swiftgs/io/progress.hpp>

namespace swiftgs::io {

/// What a reader or writer, or a step of it, tells a `Progress`, which may be empty. The `Progress` must
/// outlive the meter.
class ProgressMeter {
 public:
  ProgressMeter(const Progress& progress, std::string file) : progress_(&progress), file_(std::move(file)) {}

  /// Tells how much of this step is done, from 0 to 1. Throws `Cancelled`.
  void report(double part) const {
    if (*progress_ && !(*progress_)(begin_ + part * (end_ - begin_))) throw Cancelled(file_);
  }

  /// The meter of a step that makes up [begin, end] of this one.
  ProgressMeter step(double begin, double end) const {
    ProgressMeter of_step = *this;
    of_step.begin_ = begin_ + begin * (end_ - begin_);
    of_step.end_ = begin_ + end * (end_ - begin_);
    return of_step;
  }

 private:
  const Progress* progress_;
  std::string file_;
  double begin_ = 0, end_ = 1;
};

}  // namespace swiftgs::io
