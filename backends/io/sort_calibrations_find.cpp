// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <stdexcept>
#include <string>
#include <system_error>
#include <vector>

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

}  // namespace
}  // namespace io

std::filesystem::path sort_calibrations_beside(const std::filesystem::path& scene) {
  return std::filesystem::path(scene) += ".sort.json";
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

}  // namespace swiftgs
