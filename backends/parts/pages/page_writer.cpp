// SPDX-License-Identifier: Apache-2.0
#include "page_writer.hpp"

#include <algorithm>
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

/// Of a parent; all Gaussians of a leaf are where they are. @units{bytes}
std::size_t spread_bytes(const Page& page) { return page.is_leaf() ? 0 : page.count * sizeof(float); }

std::uint64_t aligned(std::uint64_t offset) { return (offset + alignment - 1) / alignment * alignment; }

template <class T>
std::span<const std::byte> bytes_of(const T& value) {
  return std::as_bytes(std::span(&value, 1));
}

std::filesystem::path with_suffix(std::filesystem::path path, const char* suffix) { return path += suffix; }

}  // namespace

PageWriter::PageWriter(const std::filesystem::path& out, std::uint64_t key, std::uint64_t gaussians,
                       const Scene& like)
    : place_(io::target_of(out)),
      steps_(with_suffix(place_, ".unfinished.steps")),
      file_(with_suffix(place_, ".unfinished")),
      sh_degree_(like.sh_degree),
      end_(sizeof(FileHeader)) {
  steps_.lock();
  state_.name = file_.path().string(), state_.gaussians = gaussians;
  state_.model = like.model, state_.origin = like.origin;
  find(key);
  file_.resize(end_), steps_.resize(steps_end_);
  file_.write(0, bytes_of(FileHeader{.magic = {}}));
}

PageWriter::~PageWriter() {
  if (is_finished_ || !state_.pages.empty()) return;
  std::error_code ignored;  // a destructor must not throw
  std::filesystem::remove(file_.path(), ignored), std::filesystem::remove(steps_.path(), ignored);
}

void PageWriter::find(std::uint64_t key) {
  const std::uint64_t steps_size = steps_.size(), file_size = file_.size();
  std::uint64_t found_key = key;
  steps_end_ = sizeof key;
  if (steps_size >= sizeof key) steps_.read(0, std::as_writable_bytes(std::span(&found_key, 1)));
  began_anew_ = found_key != key;
  if (began_anew_ || steps_size < sizeof key) return steps_.write(0, bytes_of(key));
  std::vector<std::byte> spread, content;
  for (Page page; steps_size - steps_end_ >= sizeof page;) {
    steps_.read(steps_end_, std::as_writable_bytes(std::span(&page, 1)));
    const std::uint64_t spread_begin = steps_end_ + sizeof page,
                        spread_end = spread_begin + spread_bytes(page);
    std::uint64_t checksum = 0;
    if (spread_end + sizeof checksum > steps_size) break;
    spread.resize(spread_bytes(page));
    steps_.read(spread_begin, spread);
    steps_.read(spread_end, std::as_writable_bytes(std::span(&checksum, 1)));
    if (checksum != checksum_of(spread, checksum_of(bytes_of(page)))) break;
    if (page.offset != aligned(end_) || page.offset + page.bytes > file_size) break;
    content.resize(page.bytes);
    file_.read(page.offset, content);
    if (checksum_of(content) != page.checksum) break;
    state_.pages.push_back(page), spread_.push_back(spread_begin);
    end_ = page.offset + page.bytes, steps_end_ = spread_end + sizeof checksum;
  }
  found_ = state_.pages.size();
}

bool PageWriter::skip(std::size_t pages) {
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
  const std::uint64_t checksum = checksum_of(spread, checksum_of(bytes_of(page)));
  std::memcpy(step.data(), &page, sizeof page);
  if (!spread.empty()) std::memcpy(step.data() + sizeof page, spread.data(), spread.size());
  std::memcpy(step.data() + sizeof page + spread.size(), &checksum, sizeof checksum);
  steps_.write(steps_end_, step);
  end_ = page.offset + page.bytes, steps_end_ += step.size();
  state_.pages.push_back(page);
  return std::uint32_t(added_++);
}

std::uint64_t PageWriter::finish(std::uint32_t page_size) {
  FileHeader header{.page_size = page_size, .gaussians = state_.gaussians, .pages = pages()};
  for (const Page& page : state_.pages)
    header.sh_degree = std::max<std::uint32_t>(header.sh_degree, page.sh_degree);
  header.origin = {state_.origin.x, state_.origin.y, state_.origin.z};
  const std::string model = text_of(state_.model);
  if (model.size() > header.model.size())
    throw InvalidArgument("pages: the rendering model is '" + model + "', expected fewer letters");
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
    io::put_in_place(file_.path(), place_);
    is_finished_ = true;
    std::filesystem::remove(steps_.path());
  } catch (const std::system_error& error) {
    throw FileError(error.code(), place_.string());
  }
  return header.file_size;
}

}  // namespace swiftgs::pages
