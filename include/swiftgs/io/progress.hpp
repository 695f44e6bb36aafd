// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <stdexcept>
#include <string>

#include <swiftgs/api.hpp>

namespace swiftgs {

/// Is told the part of a file that is read or written, from 0 to 1 and never less than before, several times
/// a second. Returns whether to go on. Always called from the thread that called the reader or writer.
using Progress = std::function<bool(double part)>;

/// A `Progress` asked to stop. What was read is given up; a file that was to be written is as it was before.
class SWIFTGS_API Cancelled : public std::runtime_error {
 public:
  explicit Cancelled(const std::string& file) : std::runtime_error(file + ": cancelled") {}
};

}  // namespace swiftgs
