// SPDX-License-Identifier: Apache-2.0
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include <swiftgs/camera.hpp>

#include "bytes.hpp"
#include "json_entry.hpp"
#include "mapped_file.hpp"
#include "sort_calibrations_format.hpp"

namespace swiftgs {
namespace io {
namespace {

using nlohmann::json;

/// One object of the array, with errors that say which.
class Entry {
 public:
  Entry(const Source& source, const json& value, std::size_t number)
      : source_(source), value_(value), number_(number) {
    if (!value.is_object()) fail("to be an object");
  }

  std::string text(const char* member) const {
    const auto found = value_.find(member);
    if (found == value_.end() || !found->is_string()) fail(std::string("with a string '") + member + "'");
    return found->get<std::string>();
  }

  std::uint64_t whole(const char* member, std::uint64_t most) const {
    const auto found = value_.find(member);
    if (found == value_.end() || !found->is_number_unsigned() || found->get<std::uint64_t>() < 1 ||
        found->get<std::uint64_t>() > most)
      fail(std::string("with '") + member + "' from 1 to " + std::to_string(most));
    return found->get<std::uint64_t>();
  }

  double duration(const char* member) const {
    const auto found = value_.find(member);
    if (found == value_.end() || !found->is_number() || found->get<double>() < 0)
      fail(std::string("with '") + member + "' of at least 0");
    return found->get<double>();
  }

 private:
  [[noreturn]] void fail(const std::string& expected) const {
    const std::size_t at = source_.text().find("\"entries\"");
    source_.fail(at == std::string_view::npos ? 0 : at, "entry " + std::to_string(number_) + " " + expected);
  }

  const Source& source_;
  const json& value_;
  std::size_t number_;
};

SavedSortCalibration calibration_of(const Entry& entry) {
  return {.key = {.scene = entry.text("scene"),
                  .device = entry.text("device"),
                  .backend = entry.text("backend"),
                  .bounds = entry.text("bounds"),
                  .library = entry.text("library")},
          .measured = {.gaussians = entry.whole("gaussians", std::numeric_limits<std::uint32_t>::max()),
                       .width = int(entry.whole("width", max_image_side)),
                       .height = int(entry.whole("height", max_image_side)),
                       .standard_ms = entry.duration("standard_ms"),
                       .early_ms = entry.duration("early_ms")},
          .views = int(entry.whole("views", std::numeric_limits<int>::max()))};
}

}  // namespace
}  // namespace io

std::vector<SavedSortCalibration> read_sort_calibrations(std::span<const std::byte> bytes,
                                                         const std::string& name) {
  const io::Source source{bytes, name};
  const nlohmann::json root = io::parse_json(source);
  const auto is = [&](const char* member, const nlohmann::json& value) {
    return root.is_object() && root.contains(member) && root[member] == value;
  };
  if (!is("format", io::sort_calibrations_format))
    source.fail(0, "an object with the format " + std::string(io::sort_calibrations_format));
  if (!is("version", io::sort_calibrations_version))
    source.fail(0, "version " + std::to_string(io::sort_calibrations_version) + " of the format");
  if (!root.contains("entries") || !root["entries"].is_array()) source.fail(0, "an array 'entries'");
  std::vector<SavedSortCalibration> calibrations;
  for (const nlohmann::json& value : root["entries"])
    calibrations.push_back(io::calibration_of(io::Entry(source, value, calibrations.size())));
  return calibrations;
}

std::vector<SavedSortCalibration> read_sort_calibrations(const std::filesystem::path& path) {
  const io::MappedFile file(path);
  return read_sort_calibrations(file.bytes(), path.string());
}

}  // namespace swiftgs
