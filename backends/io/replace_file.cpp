// SPDX-License-Identifier: Apache-2.0
#include <cerrno>
#include <random>
#include <string>
#include <system_error>
#include <utility>

#include <swiftgs/io/replace_file.hpp>

#include "output_file.hpp"

namespace swiftgs {
namespace io {
namespace {

namespace fs = std::filesystem;

/// What `path` leads to; itself where nothing is there.
fs::path target_of(const fs::path& path) {
  std::error_code none;
  const fs::path target = fs::canonical(path, none);
  return none ? path : target;
}

bool written_as_it_is(const fs::path& path) {
  std::error_code unknown;
  const fs::file_status status = fs::status(path, unknown);
  return fs::exists(status) && !fs::is_regular_file(status);
}

/// A name in the same folder that no other has.
fs::path beside(const fs::path& path) {
  std::random_device random;
  fs::path name = path;
  name += std::string(".").append(std::to_string(random())).append(std::to_string(random())).append(".new");
  return name;
}

/// A file that is gone with this object unless it is put in a place.
class Unfinished {
 public:
  explicit Unfinished(fs::path path) : path_(std::move(path)) {}
  ~Unfinished() {
    std::error_code gone;
    if (!path_.empty()) fs::remove(path_, gone);
  }
  Unfinished(const Unfinished&) = delete;
  Unfinished& operator=(const Unfinished&) = delete;

  const fs::path& path() const { return path_; }
  void put_in(const fs::path& place) {
    fs::rename(path_, place);
    path_.clear();
  }

 private:
  fs::path path_;
};

/// Calls `act`, whose failures are those of `path`, whatever name it wrote to.
template <class Act>
void in_the_name_of(const fs::path& path, const Act& act) {
  try {
    act();
  } catch (const std::system_error& error) {
    throw std::system_error(error.code(), path.string());
  }
}

}  // namespace
}  // namespace io

void replace_file(const std::filesystem::path& path,
                  const std::function<void(const std::filesystem::path&)>& write) {
  io::in_the_name_of(path, [&] {
    if (io::written_as_it_is(path)) return write(path);
    const std::filesystem::path target = io::target_of(path);
    io::Unfinished file(io::beside(target));
    write(file.path());
    file.put_in(target);
  });
}

void replace_file(const std::filesystem::path& path, std::string_view content) {
  replace_file(path, [&](const std::filesystem::path& name) {
    io::OutputFile file(name);
    file.write(content.data(), content.size());
    file.close();
  });
}

void require_replaceable(const std::filesystem::path& path) {
  io::in_the_name_of(path, [&] {
    if (std::filesystem::is_directory(path)) throw std::system_error(EISDIR, std::generic_category());
    if (io::written_as_it_is(path)) return;
    const io::Unfinished file(io::beside(io::target_of(path)));
    io::OutputFile(file.path()).close();
  });
}

}  // namespace swiftgs
