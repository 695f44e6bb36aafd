// SPDX-License-Identifier: Apache-2.0
#include "measure/photos.hpp"

#include <algorithm>
#include <filesystem>
#include <stdexcept>

#include <swiftgs/metrics.hpp>

#include "notes.hpp"
#include "read/photo_folder.hpp"
#include "draw/team.hpp"

namespace swiftgs::cli {

std::vector<std::optional<Image>> photographs_of(const std::vector<View>& views, const Cameras& cameras,
                                                 const std::string& folder, std::vector<std::string>& said) {
  const Team& team = Team::here();
  team.require_same("the folder of photographs", folder);
  if (folder.empty()) return {};
  const PhotoFolder files(folder, cameras.all);
  std::vector<std::optional<Image>> photos;
  std::vector<std::string> without;
  for (const View& view : views) {
    const std::filesystem::path found = files.photograph_of(view.camera);
    photos.emplace_back();
    team.require_same(folder + ": the photograph of " + view.name, found.empty() ? "none" : found.string());
    if (found.empty()) {
      without.push_back(view.camera.name);
      continue;
    }
    team.require_same_file(found.string());
    Image photo = read_image(found);
    if (photo.width != view.camera.width || photo.height != view.camera.height || photo.channels != 3)
      throw std::invalid_argument(found.string() + ": expected RGB of " + std::to_string(view.camera.width) +
                                  "x" + std::to_string(view.camera.height) + " as the camera has it, found " +
                                  std::to_string(photo.width) + "x" + std::to_string(photo.height) +
                                  " with " + std::to_string(photo.channels) + " channels");
    photos.back() = std::move(photo);
  }
  if (without.size() == views.size()) return {};
  if (!without.empty())
    say_notes(folder,
              {std::to_string(without.size()) + " of " + std::to_string(views.size()) +
               " views have no photograph, such as " + without.front() + "."},
              said);
  return photos;
}

double psnr_against(const Image& photo, const Frame& frame) {
  std::vector<float> shown = frame.colour;
  for (float& value : shown) value = std::clamp(value, 0.0f, 1.0f);
  return psnr(shown, photo.pixels);
}

}  // namespace swiftgs::cli
