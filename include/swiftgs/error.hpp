// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <new>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include <swiftgs/frame/api.hpp>

namespace swiftgs {

/// What kind of error it is. `swiftgs_status` in C and `Error.code` in Python have the same numbers.
enum class ErrorCode : std::int32_t {
  invalid_argument = 1,
  format = 2,
  cancelled = 3,
  file = 4,
  device = 5,
  capacity = 6,
  order = 7,
  out_of_memory = 8,  ///< also the code of `std::bad_alloc`, which the library throws as it is
  unavailable = 9,
  internal = 10  ///< a defect of the library, or an exception of a callback
};

/// Base of all that the library throws but `std::bad_alloc`. `what()` is one line: what, where and what was
/// expected.
///
/// Each class is also the exception of the standard library that says the same, so that programs that catch
/// `std::invalid_argument` go on working. `Error` itself is none: with two of them as bases,
/// `catch (const std::exception&)` would find neither.
class SWIFTGS_API Error {
 public:
  ErrorCode code() const noexcept { return code_; }
  virtual const char* what() const noexcept = 0;

 protected:
  explicit Error(ErrorCode code) noexcept : code_(code) {}
  Error(const Error&) = default;
  Error& operator=(const Error&) = default;
  ~Error() = default;

 private:
  ErrorCode code_;
};

namespace detail {

/// An exception of the standard library with a code.
template <class Standard>
class SWIFTGS_API ErrorAs : public Standard, public Error {
 public:
  template <class... Parts>
  explicit ErrorAs(ErrorCode code, const Parts&... parts) : Standard(parts...), Error(code) {}

  using Error::code;  // a `std::system_error` has one, too
  const char* what() const noexcept override { return Standard::what(); }
};

}  // namespace detail

/// The code of `error`, and of what the standard library throws the one that says the same.
inline ErrorCode code_of(const std::exception& error) noexcept {
  const auto is = [&]<class E>() { return dynamic_cast<const E*>(&error) != nullptr; };
  if (const auto* of_the_library = dynamic_cast<const Error*>(&error)) return of_the_library->code();
  if (is.template operator()<std::bad_alloc>() || is.template operator()<std::length_error>())
    return ErrorCode::out_of_memory;
  return is.template operator()<std::system_error>() ? ErrorCode::file : ErrorCode::internal;
}

/// An argument that the function does not take.
class SWIFTGS_API InvalidArgument : public detail::ErrorAs<std::invalid_argument> {
 public:
  explicit InvalidArgument(const std::string& what) : ErrorAs(ErrorCode::invalid_argument, what) {}
};

/// A file is invalid. `what()` has the file, the byte offset, and the expected content.
class SWIFTGS_API FormatError : public detail::ErrorAs<std::runtime_error> {
 public:
  FormatError(std::string file, std::uint64_t byte_offset, const std::string& expected)
      : ErrorAs(ErrorCode::format, file + ": byte " + std::to_string(byte_offset) + ": expected " + expected),
        file_(std::move(file)),
        byte_offset_(byte_offset) {}

  const std::string& file() const { return file_; }
  std::uint64_t byte_offset() const { return byte_offset_; }

 private:
  std::string file_;
  std::uint64_t byte_offset_;
};

/// The system refused, such as a file that is not there. `std::system_error::code()` is the system's reason.
class SWIFTGS_API FileError : public detail::ErrorAs<std::system_error> {
 public:
  FileError(std::error_code reason, const std::string& file) : ErrorAs(ErrorCode::file, reason, file) {}
};

/// A call to a device failed. `what()` holds the call and the device's own text.
class SWIFTGS_API DeviceError : public detail::ErrorAs<std::runtime_error> {
 public:
  DeviceError(const std::string& call, const std::string& text)
      : ErrorAs(ErrorCode::device, call + ": " + text) {}
};

/// A frame exceeds a limit or the available memory. The renderer that threw it stays usable.
class SWIFTGS_API CapacityError : public detail::ErrorAs<std::runtime_error> {
 public:
  CapacityError(const std::string& what, std::uint64_t needed, std::uint64_t limit)
      : ErrorAs(ErrorCode::capacity,
                what + ": " + std::to_string(needed) + " needed, the limit is " + std::to_string(limit)),
        needed_(needed),
        limit_(limit) {}

  std::uint64_t needed() const { return needed_; }
  std::uint64_t limit() const { return limit_; }

 private:
  std::uint64_t needed_;
  std::uint64_t limit_;
};

/// A call out of turn, such as a frame before a scene.
class SWIFTGS_API OrderError : public detail::ErrorAs<std::logic_error> {
 public:
  explicit OrderError(const std::string& what) : ErrorAs(ErrorCode::order, what) {}
};

/// This machine or this build cannot do it.
class SWIFTGS_API Unavailable : public detail::ErrorAs<std::runtime_error> {
 public:
  explicit Unavailable(const std::string& what) : ErrorAs(ErrorCode::unavailable, what) {}
};

}  // namespace swiftgs

namespace swiftgs::detail {

/// Text or a number within a message. It does not copy the text.
class MessagePart {
 public:
  MessagePart(const char* text) : text_(text) {}
  MessagePart(std::string_view text) : text_(text) {}
  template <std::same_as<std::string> S>  // nothing that converts to one
  MessagePart(const S& text) : text_(text) {}
  MessagePart(char) = delete;  // a letter or a number
  template <std::signed_integral N>
  MessagePart(N number) : kind_(Kind::integer), integer_(number) {}
  template <std::unsigned_integral N>
  MessagePart(N number) : kind_(Kind::natural), natural_(number) {}
  template <std::floating_point N>
  MessagePart(N number) : kind_(Kind::real), real_(double(number)) {}

  void append_to(std::string& message) const {
    if (kind_ == Kind::text) message.append(text_);
    if (kind_ == Kind::integer) message.append(std::to_string(integer_));
    if (kind_ == Kind::natural) message.append(std::to_string(natural_));
    if (kind_ == Kind::real) message.append(std::to_string(real_));
  }

 private:
  enum class Kind { text, integer, natural, real } kind_ = Kind::text;
  std::string_view text_{};
  union {
    long long integer_ = 0;
    unsigned long long natural_;
    double real_;
  };
};

inline std::string joined(const MessagePart* parts, std::size_t count) {
  std::string text;
  for (std::size_t i = 0; i < count; ++i) parts[i].append_to(text);
  return text;
}

/// Concatenates `parts`. Takes copies so that few instances are compiled. A sum of strings is
/// several times as much code wherever a function throws.
template <class... Parts>
std::string message(Parts... parts) {
  const MessagePart all[] = {MessagePart(parts)...};
  return joined(all, sizeof...(parts));
}

/// Throws `InvalidArgument` with the message of `parts`.
template <class... Parts>
[[noreturn]] void refuse(Parts... parts) {
  throw InvalidArgument(message(parts...));
}

}  // namespace swiftgs::detail
