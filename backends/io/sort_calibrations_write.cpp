// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cerrno>
#include <chrono>
#include <string>
#include <string_view>
#include <system_error>
#include <thread>
#include <vector>

#include <fcntl.h>
#include <nlohmann/json.hpp>
#include <sys/file.h>
#include <unistd.h>

#include <swiftgs/io/replace_file.hpp>

#include "bytes.hpp"
#include "mapped_file.hpp"
#include "sort_calibrations_format.hpp"

namespace swiftgs {
namespace io {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

/// Keeps other writers of files in a folder out, by a lock that ends with the process and leaves no file.
/// Where there are no such locks, or one is held for ten seconds, it goes on without: the file stays whole,
/// and at worst loses what another added at the same moment.
class FolderLock {
 public:
  explicit FolderLock(const fs::path& folder)
      : folder_(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
    for (int tries = 0; folder_ >= 0 && tries < 1000 && ::flock(folder_, LOCK_EX | LOCK_NB) != 0; ++tries) {
      if (errno != EWOULDBLOCK && errno != EINTR) break;
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
  }
  ~FolderLock() {
    if (folder_ >= 0) ::close(folder_);
  }
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  int folder_;
};

std::string text_of(const std::vector<SavedSortCalibration>& calibrations) {
  std::string text = "{\"format\": \"" + std::string(sort_calibrations_format) +
                     "\", \"version\": " + std::to_string(sort_calibrations_version) + ", \"entries\": [";
  const char* separator = "\n ";
  for (const SavedSortCalibration& entry : calibrations) {
    const Json object{{"scene", entry.key.scene},
                      {"gaussians", entry.measured.gaussians},
                      {"width", entry.measured.width},
                      {"height", entry.measured.height},
                      {"device", entry.key.device},
                      {"backend", entry.key.backend},
                      {"bounds", entry.key.bounds},
                      {"library", entry.key.library},
                      {"views", entry.views},
                      {"standard_ms", entry.measured.standard_ms},
                      {"early_ms", entry.measured.early_ms}};
    text += separator + object.dump(-1, ' ', false, Json::error_handler_t::replace);
    separator = ",\n ";
  }
  return text + "\n]}\n";
}

/// What the file holds; nothing where it is damaged. Throws `FormatError` for a file of another kind.
std::vector<SavedSortCalibration> calibrations_in(const fs::path& path) {
  if (fs::status(path).type() == fs::file_type::not_found) return {};
  const MappedFile file(path);
  const Source source{file.bytes(), path.string()};
  try {
    return read_sort_calibrations(source.bytes, source.name);
  } catch (const FormatError&) {
    constexpr std::size_t names_itself_within = 256;
    const std::string_view head = source.text().substr(0, names_itself_within);
    if (head.empty() || head.find(sort_calibrations_format) != std::string_view::npos) return {};
    source.fail(0, "a file of sort calibrations, or none");
  }
}

bool same_case(const SavedSortCalibration& a, const SavedSortCalibration& b) {
  return a.key == b.key && a.measured.gaussians == b.measured.gaussians &&
         a.measured.width == b.measured.width && a.measured.height == b.measured.height;
}

}  // namespace
}  // namespace io

std::size_t add_sort_calibrations(const std::filesystem::path& path,
                                  const std::vector<SavedSortCalibration>& calibrations) {
  const io::FolderLock lock(path.has_parent_path() ? path.parent_path() : ".");
  std::vector<SavedSortCalibration> all = io::calibrations_in(path);
  std::erase_if(all, [&](const SavedSortCalibration& old) {
    return std::any_of(calibrations.begin(), calibrations.end(),
                       [&](const SavedSortCalibration& added) { return io::same_case(old, added); });
  });
  const std::size_t kept = all.size();
  all.insert(all.end(), calibrations.begin(), calibrations.end());
  replace_file(path, io::text_of(all));
  return kept;
}

}  // namespace swiftgs
