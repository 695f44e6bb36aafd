// SPDX-License-Identifier: Apache-2.0
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

#include <swiftgs/error.hpp>
#include <swiftgs/pages/paged_scene.hpp>

#include "page_file.hpp"

namespace {

using namespace swiftgs;

/// Gives bytes what lets changes of them pass: the mark, their size and checksums.
void seal(std::span<std::byte> file) {
  pages::FileHeader header;
  if (file.size() < sizeof header) return;
  std::memcpy(&header, file.data(), sizeof header);
  header.magic = pages::magic, header.version = pages::version, header.file_size = file.size();
  if (header.table <= file.size()) {
    const std::span table = file.subspan(header.table);
    for (std::size_t at = 0; at + sizeof(Page) <= table.size(); at += sizeof(Page)) {
      Page page;
      std::memcpy(&page, table.data() + at, sizeof page);
      if (page.offset > file.size() || page.bytes > file.size() - page.offset) continue;
      page.checksum = pages::checksum_of(file.subspan(page.offset, page.bytes));
      std::memcpy(table.data() + at, &page, sizeof page);
    }
    header.table_checksum = pages::checksum_of(table);
  }
  std::memcpy(file.data(), &header, sizeof header);
  header.checksum = pages::checksum_of(file.first(pages::checksum_offset));
  std::memcpy(file.data(), &header, sizeof header);
}

}  // namespace

/// Any bytes are a page file whose pages are scenes, or a `FormatError`.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::vector<std::byte> file(size);
  if (size != 0) std::memcpy(file.data(), data, size);
  seal(file);
  const auto read = [&](std::uint64_t offset, std::span<std::byte> to) {
    if (offset > file.size() || to.size() > file.size() - offset) __builtin_trap();
    if (!to.empty()) std::memcpy(to.data(), file.data() + offset, to.size());
  };
  try {
    const PagedScene scene(read, size, "fuzz");
    for (std::uint32_t i = 0; i < scene.pages().size; ++i) scene.read(i);
  } catch (const FormatError&) {
  }
  return 0;
}
