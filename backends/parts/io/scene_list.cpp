// SPDX-License-Identifier: Apache-2.0
#include "scene_list.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <glm/matrix.hpp>
#include <nlohmann/json.hpp>

#include <swiftgs/edit/rotation.hpp>
#include <swiftgs/error.hpp>
#include <swiftgs/frame/placing.hpp>
#include <swiftgs/io/replace_file.hpp>
#include <swiftgs/io/scene_list.hpp>

#include "file_kind.hpp"
#include "json_entry.hpp"
#include "mapped_file.hpp"
#include "text.hpp"

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
  } catch (const InvalidArgument& error) {
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
    scene.half_spaces = half_spaces_of({three(corners), three(corners, 3)});
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
  expect_members(entry, {"file", "rotation", "scale", "translation", "opacity", "tint", "visible", "first",
                         "count", "clip"});
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
  if (entry.has("visible")) {
    if (!entry.member("visible").is_boolean()) entry.fail("true or false in 'visible'");
    scene.visible = entry.member("visible").get<bool>();
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

using Written = nlohmann::ordered_json;

Written written(const dvec3& v) { return {v.x, v.y, v.z}; }

Written written_clip(const ListedScene& scene) {
  Written clip;
  if (const std::optional<Box> box = box_of(scene.half_spaces)) {
    clip["box"] = {box->low.x, box->low.y, box->low.z, box->high.x, box->high.y, box->high.z};
  } else {
    for (const HalfSpace& half : scene.half_spaces)
      clip["half_spaces"].push_back({half.normal.x, half.normal.y, half.normal.z, half.offset});
  }
  if (const auto& sphere = scene.sphere)
    clip["sphere"] = {sphere->centre.x, sphere->centre.y, sphere->centre.z, sphere->radius};
  return clip;
}

/// The object of a scene, without members that have their defaults.
Written written(const ListedScene& scene) {
  Written entry{{"file", scene.file}};
  const Similarity& pose = scene.world_from_scene;
  if (pose.rotation != dmat3(1.0)) {
    const dmat3 rows = glm::transpose(pose.rotation);  // rows keep all bits, a quaternion would not
    entry["rotation"] = {written(rows[0]), written(rows[1]), written(rows[2])};
  }
  if (pose.scale != 1) entry["scale"] = pose.scale;
  if (pose.translation != dvec3(0.0)) entry["translation"] = written(pose.translation);
  if (scene.opacity != 1) entry["opacity"] = scene.opacity;
  if (!scene.tint.is_none()) {
    const vec3& colour = scene.tint.colour;
    entry["tint"] = {colour.x, colour.y, colour.z, scene.tint.amount};
  }
  if (!scene.visible) entry["visible"] = false;
  if (scene.first != 0) entry["first"] = scene.first;
  if (scene.count) entry["count"] = *scene.count;
  if (Written clip = written_clip(scene); !clip.is_null()) entry["clip"] = std::move(clip);
  return entry;
}

/// Throws `InvalidArgument` for what `scene_of` refuses.
void require_readable(const ListedScene& scene) {
  swiftgs::detail::validate_placing(scene.world_from_scene, scene.opacity, {}, scene.tint);
  for (const HalfSpace& half : scene.half_spaces) {
    validate(half);
    if (!std::isfinite(half.offset)) throw InvalidArgument("expected a half-space with a finite offset");
  }
  if (scene.half_spaces.size() > std::size_t(Clip::max_half_spaces))
    throw InvalidArgument("expected at most " + std::to_string(Clip::max_half_spaces) + " half-spaces");
  if (scene.sphere) validate(*scene.sphere);
  if (scene.file.empty() || scene.count == 0)
    throw InvalidArgument("expected a name, and 1 Gaussian or more");
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

bool is_scene_list(const std::filesystem::path& path) {
  if (!io::with_file_errors([&] { return std::filesystem::is_regular_file(path); })) return false;
  const io::MappedFile file(path);
  const io::Source source{file.bytes(), path.string()};
  return io::kind_of(source.text(), source.name) == io::FileKind::scene_list;
}

std::vector<ListedScene> read_scene_list(const std::filesystem::path& path) {
  const io::MappedFile file(path);
  return io::parse_scene_list({file.bytes(), path.string()});
}

void write_scene_list(const std::filesystem::path& path, const std::vector<ListedScene>& scenes) {
  if (scenes.empty()) throw InvalidArgument(path.string() + ": expected a scene or more to write");
  std::string text;
  for (const ListedScene& scene : scenes) {
    try {
      io::require_readable(scene);
      text += (text.empty() ? "[" : ",\n ") + io::written(scene).dump();
    } catch (const InvalidArgument& error) {
      throw InvalidArgument(path.string() + ": '" + scene.file + "': " + error.what());
    } catch (const nlohmann::json::exception&) {
      throw InvalidArgument(path.string() + ": '" + scene.file + "': expected a name in UTF-8");
    }
  }
  replace_file(path, text + "]\n");
}

std::vector<HalfSpace> half_spaces_of(const Box& box) {
  std::vector<HalfSpace> sides;
  for (int axis = 0; axis < 3; ++axis) {
    dvec3 along(0.0);
    along[axis] = 1;
    sides.push_back({along, box.low[axis]});
    sides.push_back({-along, -box.high[axis]});
  }
  return sides;
}

std::optional<Box> box_of(const std::vector<HalfSpace>& half_spaces) {
  if (half_spaces.size() != 6) return std::nullopt;
  Box box;
  for (int axis = 0; axis < 3; ++axis) {
    const std::size_t lower = 2 * std::size_t(axis);
    box.low[axis] = half_spaces[lower].offset, box.high[axis] = -half_spaces[lower + 1].offset;
    if (!(box.low[axis] <= box.high[axis])) return std::nullopt;
  }
  const std::vector<HalfSpace> sides = half_spaces_of(box);
  const auto same = [](const HalfSpace& a, const HalfSpace& b) { return a.normal == b.normal; };
  const bool is_box = std::equal(sides.begin(), sides.end(), half_spaces.begin(), same);
  return is_box ? std::optional(box) : std::nullopt;
}

}  // namespace swiftgs
