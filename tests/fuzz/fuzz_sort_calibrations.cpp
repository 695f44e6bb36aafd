// SPDX-License-Identifier: Apache-2.0
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>

#include <swiftgs/error.hpp>
#include <swiftgs/io/sort_calibrations.hpp>

/// Any bytes are measurements that make sense, or a `FormatError`.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::span bytes(reinterpret_cast<const std::byte*>(data), size);
  try {
    for (const swiftgs::SavedSortCalibration& saved : swiftgs::read_sort_calibrations(bytes, "fuzz"))
      if (saved.measured.width < 1 || saved.measured.height < 1 ||
          !(saved.measured.standard_ms >= 0 && saved.measured.early_ms >= 0))
        std::abort();
  } catch (const swiftgs::FormatError&) {
  }
  return 0;
}
