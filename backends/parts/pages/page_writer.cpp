// SPDX-License-Identifier: Apache-2.0
#include "page_writer.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <string>
#include <system_error>
#include <utility>

#include <swiftgs/edit/select.hpp>
#include <swiftgs/error.hpp>
#include <swiftgs/io/scene_file.hpp>
#include <swiftgs/memory/harmonic_packing.hpp>
#include <swiftgs/project/chunks.hpp>
#include <swiftgs/serial.hpp>

#include "output_file.hpp"
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

/// Bytes of `spread` that a step stores. A leaf stores none: its spread is 0.
std::size_t spread_bytes(const Page& page) { return page.is_leaf() ? 0 : page.count * sizeof(float); }

std::uint64_t aligned(std::uint64_t offset) { return (offset + alignment - 1) / alignment * alignment; }

template <class T>
std::span<const std::byte> bytes_of(const T& value) {
  return std::as_bytes(std::span(&value, 1));
}

template <class T>
std::span<std::byte> writable_bytes_of(T& value) {
  return std::as_writable_bytes(std::span(&value, 1));
}

std::filesystem::path with_suffix(std::filesystem::path path, const char* suffix) { return path += suffix; }

/// The first bytes of OUT.unfinished.steps.
struct StepsHeader {
  std::array<char, 8> magic{'S', 'G', 'S', 'T', 'E', 'P', 'S', '\n'};
  std::uint64_t key = 0;
};

bool begins_as_steps(const DiskFile& file) {
  StepsHeader header;
  if (file.size() < sizeof header) return false;
  file.read(0, writable_bytes_of(header));
  return header.magic == StepsHeader().magic;
}

}  // namespace

PageWriter::PageWriter(const std::filesystem::path& out)
    : place_(io::target_of(out)),
      steps_(with_suffix(place_, ".unfinished.steps")),
      file_(with_suffix(place_, ".unfinished")) {
  const auto refuse = [](const DiskFile& file) {
    detail::refuse(file.path().string(), ": expected none, or what a build of pages left");
  };
  if (steps_.size() == 0 && file_.size() != 0) refuse(file_);
  if (steps_.size() != 0 && !begins_as_steps(steps_)) refuse(steps_);
}

void PageWriter::begin(std::uint64_t key, std::uint64_t gaussians, const Scene& like,
                       const Progress& progress) {
  const std::string model = text_of(like.model);
  if (model.size() > FileHeader().model.size())
    throw InvalidArgument("pages: the rendering model is '" + model + "', expected fewer letters");
  key_ = key, sh_degree_ = like.sh_degree;
  state_.name = file_.path().string(), state_.gaussians = gaussians;
  state_.model = like.model, state_.origin = like.origin;
  end_ = sizeof(FileHeader), steps_end_ = sizeof(StepsHeader);
  find(progress);
  set_temporary(found_ == 0);
  if (found_ == 0) {
    file_.resize(0), steps_.resize(0);  // no old step stands behind the new key
    steps_.write(0, bytes_of(StepsHeader{.key = key_}));
  }
  file_.resize(end_), steps_.resize(steps_end_);
  file_.write(0, bytes_of(FileHeader{.magic = {}}));
}

void PageWriter::find(const Progress& progress) {
  const std::uint64_t steps_size = steps_.size(), file_size = file_.size();
  if (steps_size == 0) return;
  StepsHeader header;
  steps_.read(0, writable_bytes_of(header));
  began_anew_ = header.key != key_;
  if (began_anew_) return;
  std::vector<std::byte> spread, content;
  for (Page page; steps_size - steps_end_ >= sizeof page;) {
    progress(double(steps_end_) / double(steps_size));
    steps_.read(steps_end_, writable_bytes_of(page));
    const std::uint64_t spread_begin = steps_end_ + sizeof page,
                        spread_end = spread_begin + spread_bytes(page);
    std::uint64_t checksum = 0;
    if (spread_end + sizeof checksum > steps_size) break;
    spread.resize(spread_bytes(page));
    steps_.read(spread_begin, spread);
    steps_.read(spread_end, writable_bytes_of(checksum));
    const std::size_t number = state_.pages.size();
    if (checksum != checksum_of_step(page, spread) || page.bytes != content_size(page)) break;
    if (!page.is_leaf() && (page.left >= number || page.right >= number)) break;
    if (page.offset != aligned(end_) || page.offset + page.bytes > file_size) break;
    content.resize(page.bytes);
    file_.read(page.offset, content);
    if (checksum_of(content) != page.checksum) break;
    state_.pages.push_back(page), spread_.push_back(spread_begin);
    end_ = page.offset + page.bytes, steps_end_ = spread_end + sizeof checksum;
  }
  found_ = state_.pages.size();
}

std::uint64_t PageWriter::checksum_of_step(const Page& page, std::span<const std::byte> spread) const {
  return checksum_of(spread, checksum_of(bytes_of(page), key_));
}

void PageWriter::set_temporary(bool temporary) {
  steps_.set_temporary(temporary), file_.set_temporary(temporary);
}

bool PageWriter::take_found(std::size_t pages) {
  if (added_ + pages > found_) return false;
  added_ += pages;
  return true;
}

Nodes PageWriter::nodes(std::uint32_t number) const {
  const auto read = [this](std::uint64_t offset, std::span<std::byte> to) { file_.read(offset, to); };
  Nodes nodes{with_degree(read_page(state_, read, number).scene, sh_degree_),
              std::vector<float>(page(number).count)};
  const auto spread = std::as_writable_bytes(std::span(nodes.spread));
  steps_.read(spread_[number], spread.first(spread_bytes(page(number))));
  return nodes;
}

std::uint32_t PageWriter::add(Page page, const Nodes& nodes, std::span<const std::uint32_t> ids) {
  const SceneView all = view(nodes.scene);
  for (std::size_t i = 0; i < all.size(); ++i) detail::add_gaussian(page.bounds, all, i);
  const std::vector<std::byte> content = content_of(page, nodes.scene, ids);
  page.offset = aligned(end_), page.checksum = checksum_of(content);
  file_.write(page.offset, content);
  const auto spread = std::as_bytes(std::span(nodes.spread)).first(spread_bytes(page));
  // The step comes last: whoever finds it finds the content.
  spread_.push_back(steps_end_ + sizeof page);
  std::vector<std::byte> step(sizeof page + spread.size() + sizeof(std::uint64_t));
  const std::uint64_t checksum = checksum_of_step(page, spread);
  std::memcpy(step.data(), &page, sizeof page);
  if (!spread.empty()) std::memcpy(step.data() + sizeof page, spread.data(), spread.size());
  std::memcpy(step.data() + sizeof page + spread.size(), &checksum, sizeof checksum);
  steps_.write(steps_end_, step);
  end_ = page.offset + page.bytes, steps_end_ += step.size();
  state_.pages.push_back(page);
  set_temporary(false);
  return std::uint32_t(added_++);
}

std::uint64_t PageWriter::finish(std::uint32_t page_size) {
  FileHeader header{.page_size = page_size, .gaussians = state_.gaussians, .pages = pages()};
  for (const Page& page : state_.pages)
    header.sh_degree = std::max<std::uint32_t>(header.sh_degree, page.sh_degree);
  header.origin = {state_.origin.x, state_.origin.y, state_.origin.z};
  const std::string model = text_of(state_.model);
  std::copy(model.begin(), model.end(), header.model.begin());
  header.table = end_;
  const auto table = std::as_bytes(std::span(state_.pages));
  header.table_checksum = checksum_of(table);
  file_.write(header.table, table);
  header.file_size = header.table + table.size();
  header.checksum = checksum_of(bytes_of(header).first(checksum_offset));
  file_.write(0, bytes_of(header));
  file_.close();
  try {
    if (!std::filesystem::exists(place_))  // the file was made for this user alone
      std::filesystem::permissions(file_.path(), io::new_permissions(place_));
    io::put_in_place(file_.path(), place_);
  } catch (const std::system_error& error) {
    throw FileError(error.code(), place_.string());
  }
  sync_folder(folder());
  steps_.set_temporary(true);
  return header.file_size;
}

}  // namespace swiftgs::pages
