// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include <swiftgs/camera.hpp>

namespace swiftgs::cli {

/// The files of a folder of photographs, and which of them shows what a camera saw.
class PhotoFolder {
 public:
  /// `cameras` are all that there are, not only those whose photographs are asked for.
  PhotoFolder(const std::string& folder, const std::vector<Camera>& cameras);

  /// The photograph of `camera`: the file that has the path of its image below the folder, whatever the
  /// extension. Folders at the beginning of the image's path count as matched if the folder of photographs
  /// is called so, too, or if no other image has the rest of the path. Otherwise the only file anywhere
  /// below the folder that has the image's name, if no other image has it. Empty if there is none. Throws
  /// `InvalidArgument` for several that differ in their extension or folder.
  std::filesystem::path photograph_of(const Camera& camera) const;

 private:
  using Files = std::map<std::string, std::vector<std::filesystem::path>, std::less<>>;

  std::filesystem::path only(const Files& files, std::string_view name, const Camera& camera) const;

  std::filesystem::path folder_;
  std::string full_path_;                         ///< of the folder, with a slash at its end
  Files by_path_, by_name_;                       ///< below the folder, without extensions
  std::map<std::string, int, std::less<>> ends_;  ///< how many images have a path that ends so
};

}  // namespace swiftgs::cli
