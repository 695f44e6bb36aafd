// SPDX-License-Identifier: Apache-2.0

#include "measure/photos.hpp"

#include <algorithm>
#include <filesystem>
#include <numeric>
#include <set>
#include <stdexcept>

#include <swiftgs/metrics.hpp>

#include "draw/image_name.hpp"
#include "draw/team.hpp"
#include "notes.hpp"

namespace swiftgs::cli {
namespace {

namespace fs = std::filesystem;

/// Where an image is, with slashes and without extension.
std::string path_of(const Camera& camera) {
  std::string path(without_extension(camera.name));
  std::replace(path.begin(), path.end(), '\\', '/');
  return fs::path(path).lexically_normal().generic_string();
}

/// The files in `folder` and in all folders below it, linked ones too. A link to a folder that it lies in is
/// not followed: it has no end.
std::vector<fs::path> files_below(const fs::path& folder) {
  std::vector<fs::path> files, around{fs::canonical(folder)};  // the folders that an entry lies in
  fs::recursive_directory_iterator entry(folder, fs::directory_options::follow_directory_symlink);
  for (; entry != fs::end(entry); ++entry) {
    if (entry->is_regular_file()) files.push_back(entry->path());
    if (!entry->is_directory()) continue;
    around.resize(std::size_t(entry.depth()) + 1);
    around.push_back(fs::canonical(entry->path()));
    if (std::find(around.begin(), around.end() - 1, around.back()) != around.end() - 1)
      entry.disable_recursion_pending();
  }
  return files;
}

/// Cuts the first folder off a path. False if there is none.
bool cut_folder(std::string_view& path) {
  const std::size_t slash = path.find('/');
  if (slash == path.npos) return false;
  path.remove_prefix(slash + 1);
  return true;
}

}  // namespace

PhotoFolder::PhotoFolder(const std::string& folder, const std::vector<Camera>& cameras)
    : folder_(folder), full_path_((fs::absolute(folder) / "").lexically_normal().generic_string()) {
  for (const fs::path& file : files_below(folder)) {
    const std::string path = file.lexically_relative(folder).generic_string();
    const std::string_view name = without_extension(path);
    by_path_[std::string(name)].push_back(file);
    by_name_[std::string(name.substr(name.rfind('/') + 1))].push_back(file);
  }
  std::set<std::string> paths;
  for (const Camera& camera : cameras) paths.insert(path_of(camera));
  for (std::string_view end : paths) {
    do ++ends_[std::string(end)];
    while (cut_folder(end));
  }
}

fs::path PhotoFolder::photograph_of(const Camera& camera) const {
  const std::string path = path_of(camera);
  const auto is_of_camera_alone = [&](std::string_view end) {
    const auto found = ends_.find(end);
    return found != ends_.end() && found->second == 1;
  };
  std::string_view end = path;
  do {
    const std::string_view folders = std::string_view(path).substr(0, path.size() - end.size());
    const bool matches =
        folders.empty() || full_path_.ends_with(std::string("/").append(folders)) || is_of_camera_alone(end);
    if (fs::path file = matches ? only(by_path_, end, camera) : fs::path(); !file.empty()) return file;
  } while (cut_folder(end));
  end = std::string_view(path).substr(path.rfind('/') + 1);
  return is_of_camera_alone(end) ? only(by_name_, end, camera) : fs::path();
}

fs::path PhotoFolder::only(const Files& files, std::string_view name, const Camera& camera) const {
  const auto found = files.find(name);
  if (found == files.end() || name.empty()) return {};
  std::vector<fs::path> named = found->second;
  if (named.size() == 1) return named.front();
  std::sort(named.begin(), named.end());
  std::vector<fs::path> same_extension;
  for (const fs::path& file : named)
    if (camera.name.ends_with(file.filename().string())) same_extension.push_back(file);
  if (same_extension.size() == 1) return same_extension.front();
  throw std::invalid_argument(folder_.string() + ": expected one photograph of " + camera.name + ", found " +
                              named[0].lexically_relative(folder_).string() + " and " +
                              named[1].lexically_relative(folder_).string());
}

namespace {

/// `photo` in three channels, over `background` where it has alpha.
Image rgb_over(const Image& photo, const vec3& background) {
  if (photo.channels == 3) return photo;
  const std::size_t channels = std::size_t(photo.channels);
  const bool has_alpha = channels % 2 == 0, is_grey = channels < 3;
  Image rgb{.width = photo.width, .height = photo.height, .channels = 3};
  rgb.pixels.reserve(photo.pixels.size() / channels * 3);
  for (std::size_t pixel = 0; pixel < photo.pixels.size(); pixel += channels) {
    const float alpha = has_alpha ? photo.pixels[pixel + channels - 1] : 1;
    for (int c = 0; c < 3; ++c)
      rgb.pixels.push_back(alpha * photo.pixels[pixel + (is_grey ? 0 : std::size_t(c))] +
                           (1 - alpha) * background[c]);
  }
  return rgb;
}

/// The pixels that one of a smaller or larger image covers along a side, and how much of each.
struct Cover {
  int first = 0;
  std::vector<double> parts{};  ///< of sum 1
};

std::vector<Cover> covers(int pixels, int scaled_pixels, double scale) {
  std::vector<Cover> all;
  for (int i = 0; i < scaled_pixels; ++i) {
    const double begin = i / scale, end = std::min((i + 1) / scale, double(pixels));
    Cover cover{.first = std::min(int(begin), pixels - 1)};
    for (int at = cover.first; at < end || cover.parts.empty(); ++at)
      cover.parts.push_back(std::min(end, at + 1.0) - std::max(begin, double(at)));
    const double sum = std::accumulate(cover.parts.begin(), cover.parts.end(), 0.0);
    for (double& part : cover.parts) part /= sum;
    all.push_back(std::move(cover));
  }
  return all;
}

/// `photo` as `scaled` scales its camera: each pixel has the mean over its area.
Image scaled(const Image& photo, int width, int height, double scale) {
  const std::vector<Cover> columns = covers(photo.width, width, scale),
                           rows = covers(photo.height, height, scale);
  Image out{.width = width, .height = height, .channels = 3};
  out.pixels.reserve(3 * std::size_t(width) * std::size_t(height));
  for (const Cover& row : rows)
    for (const Cover& column : columns) {
      dvec3 mean(0.0);
      for (std::size_t y = 0; y < row.parts.size(); ++y)
        for (std::size_t x = 0; x < column.parts.size(); ++x) {
          const std::size_t pixel =
              (std::size_t(row.first) + y) * std::size_t(photo.width) + std::size_t(column.first) + x;
          for (int c = 0; c < 3; ++c)
            mean[c] += row.parts[y] * column.parts[x] * double(photo.pixels[3 * pixel + std::size_t(c)]);
        }
      for (int c = 0; c < 3; ++c) out.pixels.push_back(float(mean[c]));
    }
  return out;
}

/// `photo` in the size of `view`, which shows one of `cameras` times `scale`.
Image fitted(Image photo, const std::string& file, const Camera& view, const Cameras& cameras, double scale) {
  const auto has_size = [&](const Camera& camera) {
    return photo.width == camera.width && photo.height == camera.height;
  };
  if (has_size(view)) return photo;
  const auto size = [](const auto& of) { return std::to_string(of.width) + "x" + std::to_string(of.height); };
  std::string sizes = size(view);
  for (const Camera& camera : cameras.all) {
    if (camera.name != view.name || scale == 1) continue;
    if (has_size(camera)) return scaled(photo, view.width, view.height, scale);
    sizes = size(view) + " or, before --scale, " + size(camera);
  }
  throw std::invalid_argument(file + ": expected " + sizes + " as the camera has it, found " + size(photo));
}

}  // namespace

std::vector<std::optional<Image>> photographs_of(const std::vector<View>& views, const Cameras& cameras,
                                                 const std::string& folder, double scale,
                                                 const vec3& background, std::vector<std::string>& said) {
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
    photos.back() =
        fitted(rgb_over(read_image(found), background), found.string(), view.camera, cameras, scale);
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
