// SPDX-License-Identifier: Apache-2.0
#include "sog_files.hpp"

#include <algorithm>
#include <filesystem>
#include <new>
#include <span>

#include <zip.h>

#include "text.hpp"

namespace swiftgs::io {
namespace {

std::string reason(zip_error_t& error) {
  const std::string text = zip_error_strerror(&error);
  zip_error_fini(&error);
  return text;
}

std::shared_ptr<zip_t> open_archive(const Source& bundle) {
  zip_error_t error;
  zip_error_init(&error);
  constexpr int freed_by_libzip = 0;
  zip_source_t* bytes =
      zip_source_buffer_create(bundle.bytes.data(), bundle.bytes.size(), freed_by_libzip, &error);
  if (!bytes) throw std::bad_alloc();
  zip_t* archive = zip_open_from_source(bytes, ZIP_RDONLY, &error);
  if (!archive) {
    zip_source_free(bytes);
    bundle.fail(0, "a whole ZIP archive (" + reason(error) + ")");
  }
  return {archive, zip_discard};
}

/// Unpacks an entry into `to`; libzip compares the checksum when it finds the end.
void unpack(const Source& entry, zip_t* archive, zip_uint64_t index, std::byte* to, std::uint64_t size) {
  const std::unique_ptr<zip_file_t, int (*)(zip_file_t*)> file(zip_fopen_index(archive, index, 0),
                                                               zip_fclose);
  if (!file) entry.fail(0, std::string("an entry that can be unpacked (") + zip_strerror(archive) + ")");
  std::uint64_t done = 0;
  while (done < size) {
    const zip_int64_t read = zip_fread(file.get(), to + done, size - done);
    if (read <= 0)
      entry.fail(done,
                 std::to_string(size) + " bytes in the ZIP archive (" + zip_file_strerror(file.get()) + ")");
    done += std::uint64_t(read);
  }
  std::byte extra;
  if (zip_fread(file.get(), &extra, 1) != 0)
    entry.fail(size,
               std::string("the end of an entry with its checksum (") + zip_file_strerror(file.get()) + ")");
}

}  // namespace

std::vector<std::string> names_in_bundle(std::string_view archive) {
  std::vector<std::string> names;
  try {
    const auto zip = open_archive({std::as_bytes(std::span(archive)), "archive"});
    const zip_int64_t count = zip_get_num_entries(zip.get(), 0);
    for (zip_int64_t i = 0; i < count; ++i)
      if (const char* name = zip_get_name(zip.get(), zip_uint64_t(i), ZIP_FL_ENC_RAW))
        names.emplace_back(name);
  } catch (const FormatError&) {
  }
  return names;
}

SogFiles files_of_bundle(const Source& bundle) {
  return [&bundle, archive = open_archive(bundle)](const std::string& name) {
    zip_stat_t status;
    zip_stat_init(&status);
    if (zip_stat(archive.get(), name.c_str(), ZIP_FL_ENC_RAW, &status) != 0)
      bundle.fail(0,
                  "a ZIP archive with '" + name + "' in it, found " + listed(names_in_bundle(bundle.text())));
    SogFile file{.source{{}, bundle.name + ": " + name}};
    if (status.comp_size > bundle.bytes.size() || status.size / 16 > status.comp_size + 4096)
      file.source.fail(0, "an entry that unpacks to at most 16 times its size, found " +
                              std::to_string(status.comp_size) + " bytes for " + std::to_string(status.size));
    auto bytes = std::make_shared_for_overwrite<std::byte[]>(status.size);
    unpack(file.source, archive.get(), status.index, bytes.get(), status.size);
    file.source.bytes = {bytes.get(), status.size};
    file.owner = bytes;
    return file;
  };
}

SogFiles files_beside(const Source& meta) {
  if (meta.folder.empty())
    meta.fail(0, "a file in a folder, whose images lie beside it, found JSON of a SOG in memory");
  return [folder = meta.folder](const std::string& name) {
    const std::filesystem::path path = folder / name;
    auto file = std::make_shared<const MappedFile>(path);
    return SogFile{{file->bytes(), path.string()}, file->bytes().size(), file->identity(), file};
  };
}

SogFiles files_beside(const std::string& name, const SogFiles& files) {
  return [folder = std::filesystem::path(name).parent_path(), &files](const std::string& image) {
    return files((folder / image).string());
  };
}

bool stays_inside(const std::string& name) {
  const std::filesystem::path path = name;
  return !path.empty() && path.is_relative() && name.find('\0') == name.npos &&
         std::find(path.begin(), path.end(), "..") == path.end();
}

}  // namespace swiftgs::io
