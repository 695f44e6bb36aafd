// SPDX-License-Identifier: Apache-2.0
#include "unfinished_file.hpp"

#include <random>
#include <string>
#include <system_error>

#include <sys/stat.h>
#include <unistd.h>

namespace swiftgs::io {
namespace {

namespace fs = std::filesystem;

/// What `path` leads to; itself where nothing is there.
fs::path target_of(const fs::path& path) {
  std::error_code none;
  const fs::path target = fs::canonical(path, none);
  return none ? path : target;
}

/// A name in the same folder that no other has.
fs::path beside(const fs::path& path) {
  std::random_device random;
  fs::path name = path;
  name += std::string(".").append(std::to_string(random())).append(std::to_string(random())).append(".new");
  return name;
}

}  // namespace

bool is_stream(const fs::path& path) {
  struct stat file, output;
  if (::stat(path.c_str(), &file) != 0) return false;
  if (!S_ISREG(file.st_mode)) return true;
  // /dev/stdout, where a shell leads it to a file: the shell's descriptor would stay with the old one.
  return ::fstat(STDOUT_FILENO, &output) == 0 && file.st_dev == output.st_dev && file.st_ino == output.st_ino;
}

UnfinishedFile::UnfinishedFile(const fs::path& path) {
  if (is_stream(path)) {
    path_ = path;
  } else {
    place_ = target_of(path);
    path_ = beside(place_);
  }
}

UnfinishedFile::~UnfinishedFile() {
  std::error_code gone;
  if (!place_.empty()) fs::remove(path_, gone);
}

void UnfinishedFile::finish() {
  if (place_.empty()) return;
  std::error_code none;
  const fs::perms before = fs::status(place_, none).permissions();
  if (!none && before != fs::perms::unknown) fs::permissions(path_, before);
  fs::rename(path_, place_);
  place_.clear();
}

}  // namespace swiftgs::io
