// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <stdexcept>
#include <string>

#include <swiftgs/api.hpp>

namespace swiftgs {

/// A reader or writer calls it several times a second with the part that is done: from 0 to 1, never less
/// than before. Return false to cancel. It is called in the thread that called the reader or writer.
using Progress = std::function<bool(double part)>;

/// A `Progress` returned false. Nothing was read; the file to write is as it was before.
class SWIFTGS_API Cancelled : public std::runtime_error {
 public:
  explicit Cancelled(const std::string& file) : std::runtime_error(file + ": cancelled") {}
};

}  // namespace swiftgs
