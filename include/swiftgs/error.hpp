// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <stdexcept>
#include <string>
#include <utility>

#include <swiftgs/api.hpp>
#include <swiftgs/message.hpp>

namespace swiftgs {

/// A file is invalid. `what()` is one line: file, byte offset, and the expected content.
class SWIFTGS_API FormatError : public std::runtime_error {
 public:
  FormatError(std::string file, std::uint64_t byte_offset, const std::string& expected)
      : std::runtime_error(detail::message(file, ": byte ", byte_offset, ": expected ", expected)),
        file_(std::move(file)),
        byte_offset_(byte_offset) {}

  const std::string& file() const { return file_; }
  std::uint64_t byte_offset() const { return byte_offset_; }

 private:
  std::string file_;
  std::uint64_t byte_offset_;
};

/// A frame exceeds a limit or the available memory. The renderer that threw it stays usable.
class SWIFTGS_API CapacityError : public std::runtime_error {
 public:
  CapacityError(const std::string& what, std::uint64_t needed, std::uint64_t limit)
      : std::runtime_error(detail::message(what, ": ", needed, " needed, the limit is ", limit)),
        needed_(needed),
        limit_(limit) {}

  std::uint64_t needed() const { return needed_; }
  std::uint64_t limit() const { return limit_; }

 private:
  std::uint64_t needed_;
  std::uint64_t limit_;
};

/// A call to a device failed. `what()` holds the call and the device's own text.
class SWIFTGS_API DeviceError : public std::runtime_error {
 public:
  DeviceError(const std::string& call, const std::string& text) : std::runtime_error(call + ": " + text) {}
};

}  // namespace swiftgs
