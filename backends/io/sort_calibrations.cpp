// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <stdexcept>

#include <nlohmann/json.hpp>
#include <zlib.h>

#include <swiftgs/camera.hpp>
#include <swiftgs/io/replace_file.hpp>
#include <swiftgs/io/sort_calibrations.hpp>

#include "bytes.hpp"
#include "json_entry.hpp"
#include "mapped_file.hpp"

namespace swiftgs {
namespace io {
namespace {

constexpr const char* format = "swiftgs-sort-calibrations";
constexpr int format_version = 2;

std::uint64_t whole(const JsonEntry& entry, const char* key, std::uint64_t most) {
  const double value = entry.number(key);
  if (!(value >= 1 && value <= double(most) && value == std::floor(value)))
    entry.fail(std::string("'") + key + "' to be a whole number from 1 to " + std::to_string(most));
  return std::uint64_t(value);
}

double duration(const JsonEntry& entry, const char* key) {
  const double value = entry.number(key);
  if (value < 0) entry.fail(std::string("'") + key + "' to be at least 0");
  return value;
}

SavedSortCalibration calibration_of(const JsonEntry& entry) {
  return {.key = {.scene = entry.string("scene"),
                  .device = entry.string("device"),
                  .renderer = entry.string("renderer"),
                  .library = entry.string("library")},
          .measured = {.gaussians = whole(entry, "gaussians", UINT32_MAX),
                       .width = int(whole(entry, "width", max_image_side)),
                       .height = int(whole(entry, "height", max_image_side)),
                       .standard_ms = duration(entry, "standard_ms"),
                       .early_ms = duration(entry, "early_ms")}};
}

nlohmann::ordered_json json_of(const SavedSortCalibration& saved) {
  const auto& [key, measured] = saved;
  return {{"scene", key.scene},
          {"device", key.device},
          {"renderer", key.renderer},
          {"library", key.library},
          {"gaussians", measured.gaussians},
          {"width", measured.width},
          {"height", measured.height},
          {"standard_ms", measured.standard_ms},
          {"early_ms", measured.early_ms}};
}

/// Whether one takes the place of the other.
bool same_case(const SavedSortCalibration& a, const SavedSortCalibration& b) {
  return a.key == b.key && a.measured.gaussians == b.measured.gaussians &&
         a.measured.width == b.measured.width && a.measured.height == b.measured.height;
}

}  // namespace
}  // namespace io

std::string geometry_checksum(const Scene& scene) {
  uLong crc = crc32_z(0, nullptr, 0);
  const auto add = [&](const auto& array) {
    crc = crc32_z(crc, reinterpret_cast<const Bytef*>(array.data()), array.size() * sizeof(array[0]));
  };
  if (scene.size() != 0) add(scene.means), add(scene.scales), add(scene.rotations), add(scene.opacities);
  char text[32];
  std::snprintf(text, sizeof text, "crc32:%08lx", static_cast<unsigned long>(crc));
  return text;
}

std::vector<SavedSortCalibration> read_sort_calibrations(std::span<const std::byte> bytes,
                                                         const std::string& name) {
  const io::Source source{bytes, name};
  const nlohmann::json root = io::parse_json(source);
  const io::JsonEntry head(source, root, 0, "a file of sort calibrations");
  if (head.string("format") != io::format) head.fail(std::string("the format ") + io::format);
  if (head.number("version") != io::format_version)
    head.fail("version " + std::to_string(io::format_version) + " of the format");
  if (!head.member("entries").is_array()) head.fail("'entries' to be an array");
  const std::string_view text = source.text();
  const auto offsets = io::offsets_in(text, io::offset_of_member(text, text.find('{'), "entries"));
  std::vector<SavedSortCalibration> saved;
  for (const nlohmann::json& entry : root["entries"])
    saved.push_back(
        io::calibration_of(io::JsonEntry(source, entry, offsets[saved.size()], "a sort calibration")));
  return saved;
}

std::vector<SavedSortCalibration> read_sort_calibrations(const std::filesystem::path& path) {
  const io::MappedFile file(path);
  return read_sort_calibrations(file.bytes(), path.string());
}

std::vector<SortCalibration> find_sort_calibrations(const std::filesystem::path& path,
                                                    const SortCalibrationKey& key) {
  const std::vector<SavedSortCalibration> all = read_sort_calibrations(path);
  std::vector<SortCalibration> found;
  for (const SavedSortCalibration& saved : all)
    if (saved.key == key) found.push_back(saved.measured);
  if (found.empty())
    throw std::runtime_error(path.string() + ": expected a calibration of scene " + key.scene + " by " +
                             key.renderer + " on '" + key.device + "', version " + key.library + ", found " +
                             std::to_string(all.size()) + " of others");
  return found;
}

void add_sort_calibration(const std::filesystem::path& path, const SavedSortCalibration& added) {
  std::vector<SavedSortCalibration> all;
  if (std::filesystem::exists(path)) all = read_sort_calibrations(path);
  std::erase_if(all, [&](const SavedSortCalibration& old) { return io::same_case(old, added); });
  all.push_back(added);
  nlohmann::ordered_json root{{"format", io::format}, {"version", io::format_version}};
  for (const SavedSortCalibration& saved : all) root["entries"].push_back(io::json_of(saved));
  replace_file(path, root.dump(1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n");
}

}  // namespace swiftgs
