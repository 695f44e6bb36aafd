// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <swiftgs/camera.hpp>
#include <swiftgs/frame.hpp>
#include <swiftgs/io/image.hpp>

#include "read/views.hpp"

namespace swiftgs::cli {

/// A folder of photographs. Finds the photograph of each camera.
class PhotoFolder {
 public:
  /// `cameras` are all cameras of the capture, also those whose photographs nobody asks for.
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

/// The photograph of each view, which is one of `cameras` times `scale`, as `PhotoFolder` finds it in
/// `folder`; nothing where there is none. Empty where no view has one, or `folder` is empty. All have three
/// channels and the size of their view: colours are laid over `background` by the photograph's alpha, grey
/// becomes RGB, and of a photograph with the size of the camera each pixel gets the mean over its area. Notes
/// how many views have none, as `say_notes` does. All processes of the team call it with the same views.
/// Throws `InvalidArgument` as `PhotoFolder` does, and if one has another size, or is not the same file
/// in all processes.
std::vector<std::optional<Image>> photographs_of(const std::vector<View>& views, const Cameras& cameras,
                                                 const std::string& folder, double scale,
                                                 const vec3& background, std::vector<std::string>& said);

/// PSNR of `frame`, clamped to what a photograph can hold, against `photo`. @units{dB}
double psnr_against(const Image& photo, const Frame& frame);

}  // namespace swiftgs::cli
