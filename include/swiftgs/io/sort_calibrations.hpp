// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include <swiftgs/api.hpp>
#include <swiftgs/scene.hpp>
#include <swiftgs/sort/calibration.hpp>
#include <swiftgs/version.hpp>

/// @file
/// Measurements for `AdaptiveSort` in a small JSON file, by custom beside the scene. One file holds those of
/// any number of image sizes, devices, backends and bounds.

namespace swiftgs {

/// What a measurement holds for, beside its number of Gaussians and its image size.
struct SortCalibrationKey {
  std::string scene;    ///< `scene_checksum` of what was rendered
  std::string device;   ///< `device_name()` of the backend
  std::string backend;  ///< its `name`
  std::string bounds;   ///< their `name`
  std::string library{version};

  bool operator==(const SortCalibrationKey&) const = default;
};

/// A measurement in a file.
struct SavedSortCalibration {
  SortCalibrationKey key;
  SortCalibration measured;
  int views = 0;  ///< that either strategy was measured with
};

/// What a file holds for a key.
struct FoundSortCalibrations {
  std::vector<SortCalibration> calibrations;  ///< one for each image size, as `AdaptiveSort::use` takes them
  std::string why_none;  ///< one line with the file's name; empty where some were found, or there is no file
};

/// A checksum of what `scene` holds, whatever file it came from: `crc32:` and eight hexadecimal digits, the
/// CRC-32 of zlib over SH degree and anti-aliasing, two bytes, and all arrays in the order of `Scene`.
SWIFTGS_API std::string scene_checksum(const Scene& scene);

/// Where the measurements of a scene's file are kept unless told otherwise: `garden.spz.sort.json` for
/// `garden.spz`.
SWIFTGS_API std::filesystem::path sort_calibrations_beside(const std::filesystem::path& scene);

/// Where they are looked for, in this order: beside the scene's file; then in the user's cache, for scenes in
/// folders that cannot be written: `$XDG_CACHE_HOME/swiftgs`, or else `~/.cache/swiftgs`, under the file's
/// name and a checksum of its path. The second is missing where there is no home.
SWIFTGS_API std::vector<std::filesystem::path> sort_calibrations_places(const std::filesystem::path& scene);

/// Reads a file of measurements. Throws `FormatError`, or `std::system_error` if it cannot be read.
SWIFTGS_API std::vector<SavedSortCalibration> read_sort_calibrations(const std::filesystem::path& path);

/// The same from memory; `name` stands for the file in error messages.
SWIFTGS_API std::vector<SavedSortCalibration> read_sort_calibrations(std::span<const std::byte> bytes,
                                                                     const std::string& name);

/// Adds `calibrations` to a file, which need not be there yet. Those with the key, the number of Gaussians
/// and the image size of a new one are replaced, the rest is kept; a file of measurements that is damaged is
/// written anew. Readers see the old file or the new one, never a part; writers wait for each other where the
/// file system can lock a folder. Returns how many measurements were kept. Throws `FormatError` for a file
/// that is no file of measurements, which is left alone, and `std::system_error` if it cannot be written.
SWIFTGS_API std::size_t add_sort_calibrations(const std::filesystem::path& path,
                                              const std::vector<SavedSortCalibration>& calibrations);

/// What the file holds for `key`. A file that is missing, damaged, or of other content, another version,
/// device, backend or other bounds is no error: nothing is found in it.
SWIFTGS_API FoundSortCalibrations find_sort_calibrations(const std::filesystem::path& path,
                                                         const SortCalibrationKey& key);

/// What the files hold together; of two measurements at the same size, the one in the first file counts.
/// `why_none` is of the first file that is there.
SWIFTGS_API FoundSortCalibrations find_sort_calibrations(const std::vector<std::filesystem::path>& paths,
                                                         const SortCalibrationKey& key);

}  // namespace swiftgs
