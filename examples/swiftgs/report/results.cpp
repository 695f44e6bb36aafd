// SPDX-License-Identifier: Apache-2.0
#include "report/results.hpp"

#include <cmath>
#include <stdexcept>
#include <string_view>
#include <vector>

#include <swiftgs/error.hpp>

#include "json_text.hpp"
#include "report/files.hpp"

namespace swiftgs::cli {
namespace {

/// Deeper than any result file; what follows each level by a call of its own never runs out of stack.
constexpr int deepest = 16;

enum class Kind { text, optional_text, amount, positive, optional_amount, optional_number };

struct Needed {
  const char* name;
  Kind kind;
};

constexpr Needed members_of_scene[] = {{"scene", Kind::text},
                                       {"gaussians", Kind::amount},
                                       {"original", Kind::amount},
                                       {"enlarge", Kind::positive}};

constexpr Needed members_of_view[] = {{"scene", Kind::text},
                                      {"gaussians", Kind::amount},
                                      {"enlarge", Kind::positive},
                                      {"view", Kind::text},
                                      {"width", Kind::positive},
                                      {"height", Kind::positive},
                                      {"scale", Kind::positive},
                                      {"conventions", Kind::text},
                                      {"photo_psnr_db", Kind::optional_number},
                                      {"photo_ssim", Kind::optional_number},
                                      {"reference_image", Kind::optional_text}};

constexpr Needed members_of_plane_image[] = {{"plane", Kind::text}, {"image", Kind::text}};

constexpr Needed members_of_row[] = {{"scene", Kind::text},
                                     {"gaussians", Kind::amount},
                                     {"enlarge", Kind::positive},
                                     {"view", Kind::text},
                                     {"width", Kind::positive},
                                     {"height", Kind::positive},
                                     {"scale", Kind::positive},
                                     {"conventions", Kind::text},
                                     {"threads", Kind::amount},
                                     {"renderer", Kind::text},
                                     {"backend", Kind::text},
                                     {"sort", Kind::text},
                                     {"raster", Kind::text},
                                     {"bounds", Kind::text},
                                     {"frames", Kind::amount},
                                     {"psnr_db", Kind::optional_number},
                                     {"ssim", Kind::optional_number},
                                     {"max_abs", Kind::optional_amount},
                                     {"cut_psnr_db", Kind::optional_number},
                                     {"photo_psnr_db", Kind::optional_number},
                                     {"photo_ssim", Kind::optional_number},
                                     {"visible", Kind::optional_amount},
                                     {"intersections", Kind::optional_amount},
                                     {"contributing_pairs", Kind::optional_amount},
                                     {"device_bytes", Kind::optional_amount},
                                     {"host_bytes", Kind::optional_amount},
                                     {"image", Kind::optional_text},
                                     {"error_image", Kind::optional_text}};

constexpr Needed members_of_stress_row[] = {{"family", Kind::text},
                                            {"severity", Kind::optional_amount},
                                            {"severity_label", Kind::text},
                                            {"width", Kind::positive},
                                            {"height", Kind::positive},
                                            {"renderer", Kind::text},
                                            {"backend", Kind::text},
                                            {"sort", Kind::text},
                                            {"raster", Kind::text},
                                            {"bounds", Kind::text},
                                            {"seeds", Kind::positive},
                                            {"failed", Kind::amount},
                                            {"error", Kind::optional_text},
                                            {"strict_normalised_error", Kind::optional_amount},
                                            {"normalised_error", Kind::optional_amount},
                                            {"normalised_depth_error", Kind::optional_amount},
                                            {"psnr_db", Kind::optional_number},
                                            {"max_abs", Kind::optional_amount},
                                            {"flips", Kind::optional_amount},
                                            {"ambiguity", Kind::optional_amount},
                                            {"worst_seed", Kind::optional_amount}};

constexpr Needed members_of_bytes[] = {
    {"project", Kind::amount}, {"sort", Kind::amount}, {"raster", Kind::amount}};

constexpr const char* durations[] = {"project", "sort", "raster", "total", "wall"};

constexpr Needed members_of_duration[] = {{"median", Kind::amount},
                                          {"low", Kind::optional_amount},
                                          {"high", Kind::optional_amount},
                                          {"p10", Kind::optional_amount},
                                          {"p90", Kind::optional_amount}};

const char* expected_of(Kind kind) {
  switch (kind) {
    case Kind::text:
      return "a text that is not empty";
    case Kind::optional_text:
      return "a text or null";
    case Kind::amount:
      return "a number, 0 or more";
    case Kind::positive:
      return "a number above 0";
    case Kind::optional_amount:
      return "a number, 0 or more, or null";
    case Kind::optional_number:
      return "a number or null";
  }
  return "";
}

bool is_of(const Json& value, Kind kind) {
  switch (kind) {
    case Kind::text:
      return value.is_string() && !value.get_ref<const std::string&>().empty();
    case Kind::optional_text:
      return value.is_null() || value.is_string();
    case Kind::amount:
      return value.is_number() && value.get<double>() >= 0;
    case Kind::positive:
      return value.is_number() && value.get<double>() > 0;
    case Kind::optional_amount:
      return value.is_null() || is_of(value, Kind::amount);
    case Kind::optional_number:
      return value.is_null() || value.is_number();
  }
  return false;
}

bool may_be_absent(Kind kind) {
  return kind == Kind::optional_text || kind == Kind::optional_amount || kind == Kind::optional_number;
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
  for (const Needed& member : members) {
    const auto found = value.find(member.name);
    if (found == value.end() ? !may_be_absent(member.kind) : !is_of(*found, member.kind))
      refuse(where + "." + member.name, expected_of(member.kind));
  }
}

void check_row(const Json& row, const std::string& where) {
  check_members(row, members_of_row, where);
  if (const auto planes = row.find("plane_images"); planes != row.end()) {  // older files have none
    if (!planes->is_array()) refuse(where + ".plane_images", "an array");
    for (const Json& plane : *planes) check_members(plane, members_of_plane_image, where + ".plane_images");
  }
  if (const auto bytes = row.find("bytes"); bytes != row.end())  // older files have none
    check_members(*bytes, members_of_bytes, where + ".bytes");
  const auto ms = row.find("ms");
  if (ms == row.end()) refuse(where + ".ms", "an object");
  check_object(*ms, where + ".ms");
  for (const char* duration : durations) {
    const auto found = ms->find(duration);
    const std::string name = where + ".ms." + duration;
    if (found == ms->end()) refuse(name, "an object");
    check_members(*found, members_of_duration, name);
  }
}

/// Calls `check` with each element of the array `name` and what to call it.
template <class Check>
void check_each(const Json& results, const std::string& file, const char* name, Check check) {
  const auto found = results.find(name);
  if (found == results.end() || !found->is_array()) refuse(file + ": " + name, "an array");
  std::size_t index = 0;
  for (const Json& element : *found) check(element, file + ": " + name + "[" + std::to_string(index++) + "]");
}

/// What a file of `bench` holds beside its head.
void check_bench(const Json& results, const std::string& name) {
  check_each(results, name, "scenes", [](const Json& scene, const std::string& where) {
    check_members(scene, members_of_scene, where);
  });
  check_each(results, name, "views",
             [](const Json& view, const std::string& where) { check_members(view, members_of_view, where); });
  check_each(results, name, "rows", check_row);
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
    check_bench(results, name);
  }
  if (results["rows"].empty()) refuse(name + ": rows", "at least one row");
  return results;
}

}  // namespace swiftgs::cli
