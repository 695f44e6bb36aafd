// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <memory>
#include <string>
#include <utility>

#include <swiftgs/io/progress.hpp>

namespace swiftgs::io {

/// Tells a `Progress`, which may be empty, how far a reader or writer is. Work in several steps gives each a
/// meter of its own. The `Progress` must outlive them.
class ProgressMeter {
 public:
  ProgressMeter(const Progress& progress, std::string file) : progress_(&progress), file_(std::move(file)) {}

  /// Reports that this step is done up to `part`, from 0 to 1. A report that lies behind an earlier one
  /// repeats it: steps round, and some only estimate their end. Throws `Cancelled`.
  void report(double part) const {
    if (!*progress_) return;
    *most_ = std::max(*most_, std::min(begin_ + part * (end_ - begin_), 1.0));
    if (!(*progress_)(*most_)) throw Cancelled(file_);
  }

  /// The meter of a step that is [begin, end] of this one.
  ProgressMeter step(double begin, double end) const {
    ProgressMeter of_step = *this;
    of_step.begin_ = begin_ + begin * (end_ - begin_);
    of_step.end_ = begin_ + end * (end_ - begin_);
    return of_step;
  }

 private:
  const Progress* progress_;
  std::string file_;
  std::shared_ptr<double> most_ = std::make_shared<double>(0);  ///< reported by any of the meters
  double begin_ = 0, end_ = 1;
};

}  // namespace swiftgs::io
