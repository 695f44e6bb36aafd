// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <stdexcept>
#include <string>
#include <system_error>
#include <vector>

#include <zlib.h>

#include <swiftgs/io/sort_calibrations.hpp>

namespace swiftgs {
namespace io {
namespace {

using Entries = std::vector<SavedSortCalibration>;

/// Leaves those whose member is `wanted`. Returns what the first had, as a part of one line.
std::string keep(Entries& entries, std::string SortCalibrationKey::*member, const std::string& wanted) {
  std::string first = entries.empty() ? "" : entries.front().key.*member;
  std::replace_if(
      first.begin(), first.end(), [](char c) { return static_cast<unsigned char>(c) < ' '; }, ' ');
  std::erase_if(entries, [&](const SavedSortCalibration& entry) { return entry.key.*member != wanted; });
  return first;
}

/// Narrows `entries` down to those of `key`, member by member; returns why there are none.
std::string narrow(Entries& entries, const SortCalibrationKey& key) {
  using Key = SortCalibrationKey;
  if (entries.empty()) return "holds no calibration";
  keep(entries, &Key::scene, key.scene);
  if (entries.empty()) return "was calibrated for other content of the scene";
  const std::string library = keep(entries, &Key::library, key.library);
  if (entries.empty()) return "was calibrated by version " + library + ", and this is " + key.library;
  const std::string device = keep(entries, &Key::device, key.device);
  if (entries.empty()) return "was calibrated on '" + device + "', and this is '" + key.device + "'";
  keep(entries, &Key::backend, key.backend);
  keep(entries, &Key::bounds, key.bounds);
  if (entries.empty()) return "holds no calibration of " + key.backend + " with " + key.bounds;
  return "";
}

/// The folder for what can be measured again; empty where there is none.
std::filesystem::path cache_folder() {
  // The specification has paths that are not absolute ignored.
  const auto absolute = [](const char* variable) {
    const char* const value = std::getenv(variable);
    std::filesystem::path path = value ? value : "";
    return path.is_absolute() ? path : std::filesystem::path();
  };
  if (const auto cache = absolute("XDG_CACHE_HOME"); !cache.empty()) return cache / "swiftgs";
  const auto home = absolute("HOME");
  return home.empty() ? home : home / ".cache" / "swiftgs";
}

}  // namespace
}  // namespace io

std::filesystem::path sort_calibrations_beside(const std::filesystem::path& scene) {
  return std::filesystem::path(scene) += ".sort.json";
}

std::vector<std::filesystem::path> sort_calibrations_places(const std::filesystem::path& scene) {
  std::vector<std::filesystem::path> places{sort_calibrations_beside(scene)};
  const std::filesystem::path cache = io::cache_folder();
  if (cache.empty()) return places;
  const std::string path = std::filesystem::weakly_canonical(scene).string();
  const auto checksum = crc32_z(0, reinterpret_cast<const Bytef*>(path.data()), path.size());
  char suffix[32];
  std::snprintf(suffix, sizeof suffix, "-%08lx.sort.json", static_cast<unsigned long>(checksum));
  places.push_back(cache / (scene.filename().string() + suffix));
  return places;
}

FoundSortCalibrations find_sort_calibrations(const std::filesystem::path& path,
                                             const SortCalibrationKey& key) {
  std::error_code unknown;
  if (std::filesystem::status(path, unknown).type() == std::filesystem::file_type::not_found) return {};
  FoundSortCalibrations found;
  io::Entries entries;
  try {
    entries = read_sort_calibrations(path);
    found.why_none = io::narrow(entries, key);
    if (!found.why_none.empty()) found.why_none = path.string() + " " + found.why_none;
  } catch (const std::runtime_error& error) {
    found.why_none = error.what();
  }
  for (const SavedSortCalibration& entry : entries) found.calibrations.push_back(entry.measured);
  return found;
}

FoundSortCalibrations find_sort_calibrations(const std::vector<std::filesystem::path>& paths,
                                             const SortCalibrationKey& key) {
  FoundSortCalibrations all;
  for (const std::filesystem::path& path : paths) {
    const FoundSortCalibrations found = find_sort_calibrations(path, key);
    if (all.why_none.empty()) all.why_none = found.why_none;
    for (const SortCalibration& calibration : found.calibrations)
      if (std::none_of(all.calibrations.begin(), all.calibrations.end(), [&](const SortCalibration& known) {
            return known.gaussians == calibration.gaussians && known.width == calibration.width &&
                   known.height == calibration.height;
          }))
        all.calibrations.push_back(calibration);
  }
  if (!all.calibrations.empty()) all.why_none.clear();
  return all;
}

}  // namespace swiftgs
