// SPDX-License-Identifier: Apache-2.0
#include "archive.hpp"

#include <algorithm>
#include <cstdint>
#include <iterator>

#include "listed.hpp"
#include "name_ending.hpp"
#include "scene_format.hpp"

namespace swiftgs::io {
namespace {

/// A name that begins with `._` is that of what macOS stores beside a file.
bool is_scene_name(const std::string& name) {
  if (name.substr(name.rfind('/') + 1).starts_with("._")) return false;
  return std::any_of(std::begin(scene_formats), std::end(scene_formats),
                     [&](const SceneFormat* format) { return is_named_as(*format, name); });
}

}  // namespace

std::vector<std::string> names_in_tar(std::string_view text) {
  // A header fills 512 bytes. The content of its file follows, padded to a multiple of 512 bytes. Folders and
  // extended headers have other types than files.
  std::vector<std::string> names;
  while (is_tar(text)) {
    const std::string_view name = text.substr(0, 100), size = text.substr(124, 11);
    const char type = text[156];
    if (type == '0' || type == '\0') names.emplace_back(name.substr(0, name.find('\0')));
    std::uint64_t bytes = 0;
    for (const char digit : size)
      if (digit >= '0' && digit <= '7') bytes = 8 * bytes + std::uint64_t(digit - '0');
    if (bytes > text.size()) break;
    text.remove_prefix(std::min<std::size_t>(text.size(), 512 + (bytes + 511) / 512 * 512));
  }
  return names;
}

std::string archive_of(const std::string& archive, const std::vector<std::string>& names) {
  const auto is_pickle = [](const std::string& name) { return has_ending(name, "/data.pkl"); };
  if (std::any_of(names.begin(), names.end(), is_pickle))
    return "a checkpoint of PyTorch; export a PLY with the program that trained it";
  const auto is_array = [](const std::string& name) { return has_ending(name, ".npy"); };
  if (!names.empty() && std::all_of(names.begin(), names.end(), is_array))
    return "arrays of NumPy (.npz); write a PLY of them";
  const auto is_streamed = [](const std::string& name) { return has_ending(name, "lod-meta.json"); };
  if (const auto found = std::find_if(names.begin(), names.end(), is_streamed); found != names.end())
    return archive + " of a streamed SOG; unpack it and give " + listed({*found});
  std::vector<std::string> scenes;
  std::copy_if(names.begin(), names.end(), std::back_inserter(scenes), is_scene_name);
  if (names.empty()) return archive;
  if (scenes.empty()) return archive + " of other files: " + listed(names);
  return archive + " with " + listed(scenes) + " in it; unpack it and give " +
         (scenes.size() == 1 ? "that file" : "one of these files");
}

}  // namespace swiftgs::io
