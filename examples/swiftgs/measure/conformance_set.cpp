// SPDX-License-Identifier: Apache-2.0
#include "measure/conformance_set.hpp"

#include <algorithm>
#include <cerrno>
#include <fstream>
#include <iterator>
#include <limits>
#include <map>
#include <stdexcept>
#include <system_error>
#include <utility>

#include <swiftgs/error.hpp>
#include <swiftgs/io/cameras.hpp>
#include <swiftgs/io/scene_file.hpp>

#include "json.hpp"

namespace swiftgs::cli {
namespace {

/// What sets the member `name` to `value`; null is infinity.
Change change_of(const std::string& name, const Json& value) {
  using C = Conventions;
  static const std::map<std::string, float C::*> numbers{{"near_plane", &C::near_plane},
                                                         {"far_plane", &C::far_plane},
                                                         {"min_compensation", &C::min_compensation},
                                                         {"alpha_min", &C::alpha_min},
                                                         {"alpha_max", &C::alpha_max},
                                                         {"stop", &C::stop}};
  static const std::map<std::string, bool C::*> flags{{"cull_at_near", &C::cull_at_near},
                                                      {"stop_at_equal", &C::stop_at_equal}};
  const auto word_of = [&](const std::vector<std::string>& words) {
    const auto found = std::find(words.begin(), words.end(), value.get<std::string>());
    if (found == words.end()) throw std::invalid_argument(name + " is " + value.dump());
    return int(found - words.begin());
  };
  if (const auto number = numbers.find(name); number != numbers.end()) {
    const float to = value.is_null() ? std::numeric_limits<float>::infinity() : value.get<float>();
    return [member = number->second, to](C& c) { c.*member = to; };
  }
  if (const auto flag = flags.find(name); flag != flags.end())
    return [member = flag->second, to = value.get<bool>()](C& c) { c.*member = to; };
  if (name == "blur") return [to = value.get<float>()](C& c) { c.blur = to; };
  if (name == "antialiased") return [to = value.get<bool>()](C& c) { c.antialiased = to; };
  if (name == "order") return [to = SplatOrder(word_of({"depth", "distance"}))](C& c) { c.order = to; };
  if (name == "colours") return [to = ColourSpace(word_of({"srgb", "linear"}))](C& c) { c.colours = to; };
  if (name == "clamp")
    return [to = C::JacobianClamp(word_of({"around_image", "around_centre"}))](C& c) { c.clamp = to; };
  if (name == "footprint")
    return [to = C::Footprint(word_of({"alpha", "three_sigma_square", "three_sigma_ellipse"}))](C& c) {
      c.footprint = to;
    };
  throw std::invalid_argument("the convention '" + name + "' is not known");
}

/// What sets the members of the object `conventions` of `of`, if it has one.
Change changes_of(const Json& of) {
  std::vector<Change> changes;
  if (of.contains("conventions"))
    for (const auto& [name, value] : of.at("conventions").items()) changes.push_back(change_of(name, value));
  return [changes](Conventions& c) {
    for (const Change& change : changes) change(c);
  };
}

Clause clause_of(const Json& row, const std::filesystem::path& folder) {
  Clause clause{.name = row.at("name"),
                .scene = folder / row.at("scene").get<std::string>(),
                .cameras = folder / row.at("cameras").get<std::string>(),
                .layers = row.value("layers", 0),
                .presets = {},
                .change = changes_of(row)};
  const auto background = row.value("background", std::vector<float>{0, 0, 0});
  for (int c = 0; c < 3; ++c) clause.background[c] = background.at(std::size_t(c));
  for (const auto& [preset, file] : row.at("presets").items()) clause.presets.push_back(preset);
  return clause;
}

}  // namespace

Scene Clause::read_scene() const { return swiftgs::read_scene(scene).scene; }

Camera Clause::read_camera() const { return read_cameras(cameras).cameras.at(0); }

Conventions Clause::conventions(const std::string& preset) const {
  Conventions found = conventions_named(preset);
  change(found);
  return found;
}

ConformanceSet read_conformance_set(const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / "manifest.json";
  std::ifstream in(file, std::ios::binary);
  if (!in) throw FileError({errno, std::generic_category()}, file.string());
  try {
    const Json manifest = Json::parse(in);
    ConformanceSet set{.side = manifest.at("side"), .clauses = {}, .variants = {}};
    for (const Json& row : manifest.at("clauses")) set.clauses.push_back(clause_of(row, folder));
    for (const Json& row : manifest.at("variants")) set.variants.push_back({row.at("name"), changes_of(row)});
    return set;
  } catch (const std::logic_error& error) {
    throw InvalidArgument(file.string() + ": expected the manifest of a conformance set, but " +
                          error.what());
  } catch (const Json::exception& error) {
    throw InvalidArgument(file.string() + ": expected the manifest of a conformance set, but " +
                          error.what());
  }
}

}  // namespace swiftgs::cli
