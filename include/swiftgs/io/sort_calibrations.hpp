// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include <swiftgs/api.hpp>
#include <swiftgs/scene.hpp>
#include <swiftgs/sort/adaptive.hpp>
#include <swiftgs/version.hpp>

namespace swiftgs {

/// What a measurement holds for, beside its number of Gaussians and its image size.
struct SortCalibrationKey {
  std::string scene;     ///< `geometry_checksum`
  std::string device;    ///< `device_name()` of the renderer
  std::string renderer;  ///< its `name()`
  std::string library{version};

  bool operator==(const SortCalibrationKey&) const = default;
};

/// A measurement for `AdaptiveSort` in a JSON file, which may hold any number of them.
struct SavedSortCalibration {
  SortCalibrationKey key;
  SortCalibration measured;
};

/// A checksum of what a sort depends on: `crc32:` and the CRC-32, in eight hexadecimal digits, of the means,
/// scales, rotations and opacities as they lie in memory.
SWIFTGS_API std::string geometry_checksum(const Scene& scene);

/// Reads a file of measurements. Throws `FormatError`, or `std::system_error` if it cannot be read.
SWIFTGS_API std::vector<SavedSortCalibration> read_sort_calibrations(const std::filesystem::path& path);

/// The same from memory; `name` stands for the file in error messages.
SWIFTGS_API std::vector<SavedSortCalibration> read_sort_calibrations(std::span<const std::byte> bytes,
                                                                     const std::string& name);

/// The measurements of a file for `key`, as `AdaptiveSort::use` takes them. Throws as
/// `read_sort_calibrations`, and `std::runtime_error` if there are none.
SWIFTGS_API std::vector<SortCalibration> find_sort_calibrations(const std::filesystem::path& path,
                                                                const SortCalibrationKey& key);

/// Adds a measurement to a file, which need not exist. Replaces one with the same key, Gaussians and image
/// size. Throws as `read_sort_calibrations`, or `std::system_error` if the file cannot be written; the file
/// is then as before.
SWIFTGS_API void add_sort_calibration(const std::filesystem::path& path, const SavedSortCalibration& added);

}  // namespace swiftgs
