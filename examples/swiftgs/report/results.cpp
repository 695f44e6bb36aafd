// SPDX-License-Identifier: Apache-2.0
#include <cerrno>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string_view>
#include <system_error>

#include <swiftgs/error.hpp>

#include "json.hpp"
#include "report/report.hpp"
#include "words.hpp"

namespace swiftgs::cli {
namespace {

/// Deeper than any result file; what follows each level by a call of its own never runs out of stack.
constexpr int deepest = 16;

enum class Kind { text, amount, positive, number_or_nothing };

/// Members of one kind, with blanks between their names.
struct Needed {
  Kind kind;
  std::string_view names;
};

constexpr Needed members_of_scene[] = {
    {Kind::text, "scene"}, {Kind::amount, "gaussians original"}, {Kind::positive, "enlarge"}};

constexpr Needed members_of_row[] = {
    {Kind::text, "scene view conventions renderer backend sort raster bounds"},
    {Kind::amount, "gaussians threads frames"},
    {Kind::positive, "enlarge width height scale"},
    {Kind::number_or_nothing,
     "psnr_db ssim max_abs visible intersections contributing_pairs device_bytes host_bytes"}};

constexpr Needed members_of_stress_row[] = {
    {Kind::text, "family severity_label renderer backend sort raster bounds"},
    {Kind::amount, "failed"},
    {Kind::positive, "width height seeds"},
    {Kind::number_or_nothing,
     "severity strict_normalised_error normalised_error psnr_db max_abs ambiguity worst_seed"}};

constexpr const char* durations[] = {"project", "sort", "raster", "total", "wall"};

constexpr Needed members_of_duration[] = {{Kind::amount, "median"}, {Kind::number_or_nothing, "low high"}};

const char* expected_of(Kind kind) {
  switch (kind) {
    case Kind::text:
      return "a text that is not empty";
    case Kind::amount:
      return "a number, 0 or more";
    case Kind::positive:
      return "a number above 0";
    case Kind::number_or_nothing:
      return "a number or null";
  }
  return "";
}

bool is_of(const Json& value, Kind kind) {
  switch (kind) {
    case Kind::text:
      return value.is_string() && !value.get_ref<const std::string&>().empty();
    case Kind::amount:
      return value.is_number() && value.get<double>() >= 0;
    case Kind::positive:
      return value.is_number() && value.get<double>() > 0;
    case Kind::number_or_nothing:
      return value.is_null() || value.is_number();
  }
  return false;
}

[[noreturn]] void refuse(const std::string& where, const std::string& expected) {
  throw std::invalid_argument(where + ": expected " + expected);
}

void check_object(const Json& value, const std::string& where) {
  if (!value.is_object()) refuse(where, "an object");
}

template <std::size_t n>
void check_members(const Json& value, const Needed (&members)[n], const std::string& where) {
  check_object(value, where);
  for (const Needed& needed : members)
    for (const std::string_view text : cli::split(needed.names, ' ')) {
      const std::string name(text);
      if (!is_of(value.value(name, Json()), needed.kind))
        refuse(where + "." + name, expected_of(needed.kind));
    }
}

void check_row(const Json& row, const std::string& where) {
  check_members(row, members_of_row, where);
  const Json ms = row.value("ms", Json());
  check_object(ms, where + ".ms");
  for (const char* duration : durations)
    check_members(ms.value(duration, Json()), members_of_duration, where + ".ms." + duration);
}

/// Calls `check` with each element of the array `name` and what to call it.
template <class Check>
void check_each(const Json& results, const std::string& file, const char* name, Check check) {
  const auto found = results.find(name);
  if (found == results.end() || !found->is_array()) refuse(file + ": " + name, "an array");
  std::size_t index = 0;
  for (const Json& element : *found) check(element, file + ": " + name + "[" + std::to_string(index++) + "]");
}

std::string content_of_file(const std::string& name) {
  errno = 0;
  if (std::filesystem::is_directory(name)) throw std::system_error(EISDIR, std::generic_category(), name);
  std::ifstream file(name, std::ios::binary);
  std::string content{std::istreambuf_iterator<char>(file), {}};
  if (!file.is_open() || file.bad())
    throw std::system_error(errno ? errno : EIO, std::generic_category(), name);
  return content;
}

Json parsed(const std::string& file, const std::string& text) {
  const auto not_too_deep = [&](int depth, Json::parse_event_t, Json&) {
    if (depth > deepest) refuse(file, "objects and arrays at most " + std::to_string(deepest) + " deep");
    return true;
  };
  try {
    return Json::parse(text, not_too_deep);
  } catch (const Json::parse_error& error) {
    // As PowerShell writes what a program prints.
    if (text.starts_with("\xff\xfe") || text.starts_with("\xfe\xff"))
      throw FormatError(file, 0, "JSON of swiftgs bench or stress in UTF-8, found a text in UTF-16");
    const bool at_end = error.byte > text.size();
    throw FormatError(
        file, at_end ? text.size() : error.byte - 1,
        at_end ? "JSON that goes on: the file is cut short" : "JSON of swiftgs bench or stress");
  } catch (const Json::out_of_range&) {
    refuse(file, "numbers that a double can hold");
  }
}

}  // namespace

Json read_results(const std::string& name) {
  Json results = parsed(name, content_of_file(name));
  const Json format = results.is_object() ? results.value("format", Json()) : Json();
  if (format != "swiftgs-bench" && format != stress_format)
    refuse(name + ": format", "\"swiftgs-bench\" or \"swiftgs-stress\", as these commands write it");
  const Json version = results.value("version", Json());
  if (version != 1) refuse(name + ": version", "1, found " + version.dump().substr(0, 40));
  check_object(results.value("machine", Json()), name + ": machine");
  if (!is_of(results.value("command", Json()), Kind::text))
    refuse(name + ": command", "a text that is not empty");
  if (format == stress_format) {
    check_each(results, name, "rows", [](const Json& row, const std::string& where) {
      check_members(row, members_of_stress_row, where);
    });
  } else {
    check_each(results, name, "scenes", [](const Json& scene, const std::string& where) {
      check_members(scene, members_of_scene, where);
    });
    check_each(results, name, "rows", check_row);
  }
  if (results["rows"].empty()) refuse(name + ": rows", "at least one row");
  return results;
}

}  // namespace swiftgs::cli
