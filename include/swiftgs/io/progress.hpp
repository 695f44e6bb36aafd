// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>

#include <swiftgs/api.hpp>
#include <swiftgs/error.hpp>

namespace swiftgs {

/// A reader or writer calls it several times a second with the part that is done: from 0 to 1, never less
/// than before. Return false to cancel. It is called in the thread that called the reader or writer.
using Progress = std::function<bool(double part)>;

/// A `Progress` returned false. Nothing was read; the file to write is as it was before.
class SWIFTGS_API Cancelled : public detail::ErrorAs<std::runtime_error> {
 public:
  explicit Cancelled(const std::string& file) : ErrorAs(ErrorCode::cancelled, file + ": cancelled") {}
};

}  // namespace swiftgs
