// SPDX-License-Identifier: Apache-2.0
#include <cerrno>
#include <system_error>

#include <swiftgs/error.hpp>
#include <swiftgs/io/replace_file.hpp>

#include "output_file.hpp"
#include "unfinished_file.hpp"

namespace swiftgs {

void replace_file(const std::filesystem::path& path,
                  const std::function<void(const std::filesystem::path&)>& write) {
  // Failures are those of `path`, whatever name was written to.
  try {
    io::UnfinishedFile file(path);
    write(file.path());
    file.finish();
  } catch (const std::system_error& error) {
    throw FileError(error.code(), path.string());
  }
}

void replace_file(const std::filesystem::path& path, std::string_view content) {
  io::OutputFile file(path);
  file.write(content.data(), content.size());
  file.close();
}

void require_replaceable(const std::filesystem::path& path) {
  std::error_code none;
  if (std::filesystem::is_directory(path, none))
    throw FileError({EISDIR, std::generic_category()}, path.string());
  if (!io::is_stream(path)) io::OutputFile{path};  // gone again, as it is never closed
}

}  // namespace swiftgs
