// SPDX-License-Identifier: Apache-2.0
#include "photos.hpp"

#include <algorithm>
#include <filesystem>
#include <map>
#include <stdexcept>

#include <swiftgs/metrics.hpp>

#include "team.hpp"

namespace swiftgs::cli {

std::vector<std::optional<Image>> photographs_of(const std::vector<View>& views, const std::string& folder) {
  const Team& team = Team::here();
  team.require_same("the folder of photographs", folder);
  if (folder.empty()) return {};
  std::map<std::string, std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    if (entry.is_regular_file()) files[entry.path().stem().string()] = entry.path();

  std::vector<std::optional<Image>> photos;
  for (const View& view : views) {
    const auto found = files.find(std::filesystem::path(view.camera.name).stem().string());
    photos.emplace_back();
    team.require_same(folder + ": the photograph of " + view.name,
                      found == files.end() ? "none" : found->second.filename().string());
    if (found == files.end()) continue;
    team.require_same_file(found->second.string());
    Image photo = read_image(found->second);
    if (photo.width != view.camera.width || photo.height != view.camera.height || photo.channels != 3)
      throw std::invalid_argument(
          found->second.string() + ": expected RGB of " + std::to_string(view.camera.width) + "x" +
          std::to_string(view.camera.height) + " as the camera has it, found " + std::to_string(photo.width) +
          "x" + std::to_string(photo.height) + " with " + std::to_string(photo.channels) + " channels");
    photos.back() = std::move(photo);
  }
  if (std::none_of(photos.begin(), photos.end(), [](const auto& photo) { return photo.has_value(); }))
    return {};
  return photos;
}

double psnr_against(const Image& photo, const Frame& frame) {
  std::vector<float> shown = frame.colour;
  for (float& value : shown) value = std::clamp(value, 0.0f, 1.0f);
  return psnr(shown, photo.pixels);
}

}  // namespace swiftgs::cli
