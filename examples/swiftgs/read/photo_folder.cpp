// SPDX-License-Identifier: Apache-2.0
#include "read/photo_folder.hpp"

#include <algorithm>
#include <set>
#include <stdexcept>

#include "draw/image_name.hpp"

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

}  // namespace swiftgs::cli
