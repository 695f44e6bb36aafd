// SPDX-License-Identifier: Apache-2.0
#include <concepts>
#include <exception>
#include <new>
#include <stdexcept>
#include <string_view>
#include <system_error>

#include <doctest/doctest.h>

#include <swiftgs/camera.hpp>
#include <swiftgs/error.hpp>
#include <swiftgs/io/scene_file.hpp>
#include <swiftgs/swiftgs.hpp>

namespace swiftgs::test::error_test {

/// What is caught of f() as an `Error`, which has to be a `Standard` and a `std::exception` too.
template <class Standard, class F>
void check(ErrorCode code, std::string_view what, const F& f) {
  CAPTURE(what);
  try {
    f();
    FAIL_CHECK("expected an error");
  } catch (const Error& error) {
    CHECK(error.code() == code);
    CHECK(error.what() == what);
  }
  CHECK_THROWS_AS(f(), Standard);
  try {
    f();
  } catch (const std::exception& error) {
    CHECK(code_of(error) == code);
    CHECK(error.what() == what);
  }
}

template <class Standard, class E>
void check(ErrorCode code, std::string_view what, const E& error) requires std::derived_from<E, Error> {
  check<Standard>(code, what, [&] { throw error; });
}

TEST_CASE("error: every class has a code and is an exception of the standard library") {
  const std::error_code reason = std::make_error_code(std::errc::io_error);
  check<std::invalid_argument>(ErrorCode::invalid_argument, "a", InvalidArgument("a"));
  check<std::runtime_error>(ErrorCode::format, "a: byte 3: expected b", FormatError("a", 3, "b"));
  check<std::runtime_error>(ErrorCode::cancelled, "a: cancelled", Cancelled("a"));
  check<std::system_error>(ErrorCode::file, "a: " + reason.message(), FileError(reason, "a"));
  check<std::runtime_error>(ErrorCode::device, "a: b", DeviceError("a", "b"));
  check<std::runtime_error>(ErrorCode::capacity, "a: 3 needed, the limit is 2", CapacityError("a", 3, 2));
  check<std::logic_error>(ErrorCode::order, "a", OrderError("a"));
  check<std::runtime_error>(ErrorCode::unavailable, "a", Unavailable("a"));
}

TEST_CASE("error: what the standard library throws has a code too") {
  CHECK(code_of(std::bad_alloc()) == ErrorCode::out_of_memory);
  CHECK(code_of(std::length_error("")) == ErrorCode::out_of_memory);
  CHECK(code_of(std::system_error(std::make_error_code(std::errc::io_error))) == ErrorCode::file);
  CHECK(code_of(std::invalid_argument("")) == ErrorCode::internal);
}

TEST_CASE("error: what the core throws is caught by its base") {
  check<std::invalid_argument>(ErrorCode::invalid_argument, "camera: expected a finite scale above 0",
                               [] { scaled(Camera(), -1.0); });
  check<std::logic_error>(ErrorCode::order, "pick: expected a frame before",
                          [] { Renderer<Serial, EarlySort, PerPixel, Ellipse>().pick(0, 0, 0); });
}

}  // namespace swiftgs::test::error_test
