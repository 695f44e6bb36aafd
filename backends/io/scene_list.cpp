// SPDX-License-Identifier: Apache-2.0
#include "scene_list.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include <swiftgs/clip.hpp>
#include <swiftgs/io/scene_list.hpp>
#include <swiftgs/placing.hpp>
#include <swiftgs/rotation.hpp>

#include "json_entry.hpp"
#include "listed.hpp"
#include "mapped_file.hpp"

namespace swiftgs {
namespace io {
namespace {

using nlohmann::json;

constexpr const char* a_list = "an array of one scene or more, each an object with 'file'";

/// Throws `FormatError` unless `entry` has the members `known` alone: one that is mistyped would change
/// nothing.
void expect_members(const JsonEntry& entry, const std::vector<std::string>& known) {
  for (const auto& [key, value] : entry.members().items())
    if (std::find(known.begin(), known.end(), key) == known.end())
      entry.fail("the members " + listed(known) + ", found '" + listed({key}) + "'");
}

/// Runs `check`. What it throws is thrown again with the place in the file.
template <class Check>
void checked(const JsonEntry& entry, const Check& check) {
  try {
    check();
  } catch (const std::invalid_argument& error) {
    const std::string_view what = error.what(), expected = "expected ";
    entry.fail(std::string(what.substr(what.find(expected) + expected.size())));
  }
}

/// The numbers of an array of `count`.
std::vector<double> numbers_in(const JsonEntry& entry, const json& array, std::size_t count,
                               const char* key) {
  const auto is_number = [](const json& value) { return value.is_number(); };
  if (!array.is_array() || array.size() != count || !std::all_of(array.begin(), array.end(), is_number))
    entry.fail(std::to_string(count) + " numbers in '" + key + "'");
  return array.get<std::vector<double>>();
}

dvec3 three(const std::vector<double>& numbers, std::size_t first = 0) {
  return {numbers[first], numbers[first + 1], numbers[first + 2]};
}

dmat3 rotation_of(const JsonEntry& entry) {
  const json& given = entry.member("rotation");
  if (!given.is_array() || (given.size() != 3 && given.size() != 4))
    entry.fail("'rotation' to be a quaternion w, x, y, z or three rows of three numbers");
  if (given.size() == 3) return entry.matrix("rotation");
  const std::vector<double> q = numbers_in(entry, given, 4, "rotation");
  double most = 0;  // squares of larger numbers may leave the range of double
  for (const double each : q) most = std::max(most, std::abs(each));
  if (most == 0) entry.fail("a quaternion other than 0 in 'rotation'");
  return matrix_of(unit(DQuaternion{q[0] / most, q[1] / most, q[2] / most, q[3] / most}));
}

void read_clip(const JsonEntry& clip, ListedScene& scene) {
  expect_members(clip, {"box", "sphere", "half_spaces"});
  if (clip.has("box")) {
    const std::vector<double> corners = numbers_in(clip, clip.member("box"), 6, "box");
    checked(clip, [&] { validate(Box{three(corners), three(corners, 3)}); });
    for (int axis = 0; axis < 3; ++axis) {
      dvec3 along(0.0);
      along[axis] = 1;
      scene.half_spaces.push_back({along, three(corners)[axis]});
      scene.half_spaces.push_back({-along, -three(corners, 3)[axis]});
    }
  }
  if (clip.has("half_spaces")) {
    const json& all = clip.member("half_spaces");
    if (!all.is_array()) clip.fail("'half_spaces' to be an array");
    for (const json& each : all) {
      const std::vector<double> numbers = numbers_in(clip, each, 4, "half_spaces");
      scene.half_spaces.push_back({three(numbers), numbers[3]});
      checked(clip, [&] { validate(scene.half_spaces.back()); });
    }
  }
  if (scene.half_spaces.size() > std::size_t(Clip::max_half_spaces))
    clip.fail("at most " + std::to_string(Clip::max_half_spaces) + " half-spaces, of which a box is six");
  if (clip.has("sphere")) {
    const std::vector<double> numbers = numbers_in(clip, clip.member("sphere"), 4, "sphere");
    scene.sphere = {three(numbers), numbers[3]};
    checked(clip, [&] { validate(*scene.sphere); });
  }
}

ListedScene scene_of(const JsonEntry& entry) {
  expect_members(entry,
                 {"file", "rotation", "scale", "translation", "opacity", "tint", "first", "count", "clip"});
  ListedScene scene;
  scene.file = entry.string("file");
  if (scene.file.empty()) entry.fail("a name in 'file'");
  Similarity& pose = scene.world_from_scene;
  if (entry.has("rotation")) pose.rotation = rotation_of(entry);
  if (entry.has("scale")) pose.scale = entry.number("scale");
  if (entry.has("translation")) pose.translation = entry.vector("translation");
  if (entry.has("opacity")) scene.opacity = float(entry.number("opacity"));
  if (entry.has("tint")) {
    const std::vector<double> numbers = numbers_in(entry, entry.member("tint"), 4, "tint");
    scene.tint = {vec3(three(numbers)), float(numbers[3])};
  }
  if (const char* const expected = swiftgs::detail::unmet_of_placing(pose, scene.opacity, {}, scene.tint))
    entry.fail(expected);
  scene.first = whole_number(entry, "first", 0);
  if (entry.has("count")) scene.count = whole_number(entry, "count");
  if (scene.count == 0) entry.fail("'count' to be 1 or more");
  if (entry.has("clip")) {
    const std::uint64_t offset = offset_of_member(entry.source().text(), entry.offset(), "clip");
    read_clip({entry.source(), entry.member("clip"), offset, "a clip"}, scene);
  }
  return scene;
}

}  // namespace

std::vector<ListedScene> parse_scene_list(const Source& source) {
  const json root = parse_json(source);
  if (!root.is_array() || root.empty()) source.fail(0, a_list);
  const std::vector<std::uint64_t> offsets = offsets_in(source.text(), source.text().find('['));
  std::vector<ListedScene> scenes;
  for (std::size_t i = 0; i < root.size(); ++i)
    scenes.push_back(scene_of({source, root[i], offsets[i], "a scene"}));
  return scenes;
}

}  // namespace io

std::vector<ListedScene> read_scene_list(const std::filesystem::path& path) {
  const io::MappedFile file(path);
  return io::parse_scene_list({file.bytes(), path.string()});
}

}  // namespace swiftgs
