// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <swiftgs/edit/select.hpp>
#include <swiftgs/frame/api.hpp>
#include <swiftgs/frame/placing.hpp>

namespace swiftgs {

/// A scene of a list, its placing in the world, and which of its Gaussians show. Movement and clip apply to
/// positions in the scene's file, before a reader subtracts `Scene::origin`.
struct ListedScene {
  std::string file;  ///< as the list has it: relative to the list's folder
  Similarity world_from_scene{};
  float opacity = 1;
  Tint tint{};
  bool visible = true;                   ///< false: none of its Gaussians shows
  std::vector<HalfSpace> half_spaces{};  ///< at most `Clip::max_half_spaces`
  std::optional<Sphere> sphere{};
  std::uint64_t first = 0;               ///< number of the first Gaussian that shows
  std::optional<std::uint64_t> count{};  ///< Gaussians that show, 1 or more; all from `first` on
};

/// Whether `path` is a file that holds a list of scenes, by its content. Other JSON, such as a list of
/// cameras, is none. Throws `FileError` if the file cannot be read.
SWIFTGS_API bool is_scene_list(const std::filesystem::path& path);

/// Reads a list of scenes, a JSON array of objects. Each has a `file`, and may have
/// - `rotation`, a quaternion w, x, y, z of any length or three rows of three numbers, `scale` above 0, and
///   `translation`, which make p_world = scale rotation p + translation,
/// - `opacity`, 0 to 1, which the Gaussians' opacities are multiplied by,
/// - `tint` [red, green, blue, amount], a `Tint`,
/// - `visible`: false hides the scene, which is read all the same,
/// - `first` and `count`: the range of Gaussians that shows, as they are numbered in memory,
/// - `clip`, an object of `box` [x, y, z, x, y, z], two corners; `sphere` [x, y, z, radius]; and
///   `half_spaces`, [x, y, z, offset] each, of positions p with (x, y, z) . p >= offset. A box is six
///   half-spaces. A Gaussian shows if its mean lies in all of them.
/// Throws `FormatError` for anything else, also for other members, and `FileError` if the file cannot be
/// read.
SWIFTGS_API std::vector<ListedScene> read_scene_list(const std::filesystem::path& path);

/// Writes a list that `read_scene_list` reads back to the last bit of each number. If anything fails, the
/// file at `path` stays as it was. Throws `InvalidArgument` for a list that the reader would refuse and for a
/// name that is not UTF-8, and `FileError` if the file cannot be written.
SWIFTGS_API void write_scene_list(const std::filesystem::path& path, const std::vector<ListedScene>& scenes);

/// The six half-spaces of a box: of each axis the lower side, then the upper one.
SWIFTGS_API std::vector<HalfSpace> half_spaces_of(const Box& box);

/// The box that `half_spaces_of` makes these of, or nothing if they are others.
SWIFTGS_API std::optional<Box> box_of(const std::vector<HalfSpace>& half_spaces);

}  // namespace swiftgs
