// SPDX-License-Identifier: Apache-2.0
#include "error.hpp"

#include <cstddef>
#include <exception>
#include <iterator>
#include <string>

#include <swiftgs/error.hpp>
#include <swiftgs/version.hpp>

namespace swiftgs::c {
namespace {

/// The text of an error that there may be no memory to copy.
struct LastError {
  std::string copy;
  const char* text = "";

  void keep(const char* what) noexcept {
    try {
      copy = what;
      text = copy.c_str();
    } catch (...) {
      text = "out of memory, also for the text of an error";
    }
  }
};

LastError& last_error() {
  thread_local LastError error;
  return error;
}

}  // namespace

swiftgs_status keep_exception() noexcept {
  try {
    throw;
  } catch (const std::exception& error) {
    const swiftgs_status status = swiftgs_status(code_of(error));
    last_error().keep(status == SWIFTGS_OUT_OF_MEMORY ? "out of memory" : error.what());
    return status;
  } catch (...) {
    last_error().keep("an exception without a text, expected one of the library");
    return SWIFTGS_INTERNAL_ERROR;
  }
}

}  // namespace swiftgs::c

extern "C" {

const char* swiftgs_status_name(swiftgs_status status) {
  static constexpr const char* names[] = {"SWIFTGS_OK",
                                          "SWIFTGS_INVALID_ARGUMENT",
                                          "SWIFTGS_FORMAT_ERROR",
                                          "SWIFTGS_CANCELLED",
                                          "SWIFTGS_SYSTEM_ERROR",
                                          "SWIFTGS_DEVICE_ERROR",
                                          "SWIFTGS_CAPACITY_ERROR",
                                          "SWIFTGS_LOGIC_ERROR",
                                          "SWIFTGS_OUT_OF_MEMORY",
                                          "SWIFTGS_UNAVAILABLE",
                                          "SWIFTGS_INTERNAL_ERROR"};
  static_assert(std::size(names) == SWIFTGS_INTERNAL_ERROR + 1);
  return std::size_t(status) < std::size(names) ? names[status] : "unknown status";
}

const char* swiftgs_last_error(void) { return swiftgs::c::last_error().text; }

const char* swiftgs_version(void) { return swiftgs::version.data(); }

uint32_t swiftgs_abi_version(void) { return SWIFTGS_ABI_MAJOR << 16 | SWIFTGS_ABI_MINOR; }

}  // extern "C"
