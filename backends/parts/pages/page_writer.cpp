// SPDX-License-Identifier: Apache-2.0
#include "page_writer.hpp"

#include <algorithm>
#include <cstring>
#include <string>

#include <swiftgs/error.hpp>
#include <swiftgs/io/scene_file.hpp>
#include <swiftgs/memory/harmonic_packing.hpp>
#include <swiftgs/project/chunks.hpp>
#include <swiftgs/serial.hpp>

#include "page_file.hpp"

namespace swiftgs::pages {
namespace {

/// The bytes of a page. Sets all members of `page` but its checksum and offset.
std::vector<std::byte> content_of(Page& page, const Scene& scene, std::span<const std::uint32_t> ids) {
  const HarmonicPacking packing(Serial(), scene, used_sh_degree(scene), HarmonicsKept::smallest);
  const HarmonicRows like = packing.rows_at(nullptr, packing.labels().data);
  page.count = std::uint32_t(scene.size()), page.rows = std::uint32_t(packing.rows());
  page.sh_degree = std::uint8_t(used_sh_degree(scene));
  page.harmonic_format = std::uint8_t(like.format), page.harmonic_scale = like.scale;
  page.has_labels = like.labels != nullptr, page.has_ids = !ids.empty();
  page.bytes = content_size(page);
  std::vector<std::byte> content(page.bytes);
  const auto labels = packing.labels();
  const void* const parts[] = {scene.means.data(),
                               scene.scales.data(),
                               scene.rotations.data(),
                               scene.opacities.data(),
                               scene.sh0.data(),
                               nullptr,
                               labels.data,
                               ids.data()};
  std::size_t k = 0;
  for_each_part(page, [&](std::uint64_t offset, std::uint64_t bytes) {
    const void* const from = parts[k++];
    auto* const to = reinterpret_cast<unsigned char*>(content.data() + offset);
    if (from && bytes != 0)
      std::memcpy(to, from, bytes);
    else if (bytes != 0)
      for (std::size_t row = 0; row < packing.rows(); ++row) packing.write(row, to + row * packing.stride());
  });
  return content;
}

}  // namespace

PageWriter::PageWriter(const std::filesystem::path& path) : file_(path) {
  const FileHeader room;
  write(std::as_bytes(std::span(&room, 1)));
}

std::uint32_t PageWriter::add(Page page, const Scene& scene, std::span<const std::uint32_t> ids) {
  const SceneView all = view(scene);
  for (std::size_t i = 0; i < scene.size(); ++i) detail::add_gaussian(page.bounds, all, i);
  const std::vector<std::byte> content = content_of(page, scene, ids);
  const std::vector<std::byte> gap((alignment - file_.size() % alignment) % alignment);
  write(gap);
  page.offset = file_.size(), page.checksum = checksum_of(content);
  write(content);
  table_.push_back(page);
  return std::uint32_t(table_.size() - 1);
}

std::uint64_t PageWriter::finish(std::uint64_t gaussians, std::uint32_t page_size, const Scene& like) {
  FileHeader header{.page_size = page_size, .gaussians = gaussians, .pages = std::uint32_t(table_.size())};
  for (const Page& page : table_)
    header.sh_degree = std::max<std::uint32_t>(header.sh_degree, page.sh_degree);
  header.origin = {like.origin.x, like.origin.y, like.origin.z};
  const std::string model = text_of(like.model);
  if (model.size() > header.model.size())
    throw InvalidArgument("pages: the rendering model is '" + model + "', expected fewer letters");
  std::copy(model.begin(), model.end(), header.model.begin());
  header.table = file_.size();
  const auto table = std::as_bytes(std::span(table_));
  header.table_checksum = checksum_of(table);
  write(table);
  header.file_size = file_.size();
  const auto bytes = std::as_bytes(std::span(&header, 1));
  header.checksum = checksum_of(bytes.first(checksum_offset));
  file_.write_front(bytes.data(), bytes.size());
  file_.close();
  return header.file_size;
}

}  // namespace swiftgs::pages
