// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cstring>
#include <fstream>
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include <swiftgs/edit/select.hpp>
#include <swiftgs/error.hpp>
#include <swiftgs/io/scene_file.hpp>
#include <swiftgs/pages/paged_scene.hpp>

#include "file_kind.hpp"
#include "file_pages.hpp"
#include "mapped_file.hpp"
#include "page_file.hpp"

namespace swiftgs {
namespace {

using pages::FileHeader;

/// Throws unless `holds`.
void require(bool holds, const std::string& name, std::uint64_t offset, const std::string& expected) {
  if (!holds) throw FormatError(name, offset, expected);
}

template <class T>
std::span<std::byte> bytes_of_vector(std::vector<T>& values) {
  return std::as_writable_bytes(std::span(values));
}

FileHeader read_header(const PageSource& source, std::uint64_t size, const std::string& name) {
  FileHeader header;
  require(size >= sizeof header, name, 0,
          "a header of " + std::to_string(sizeof header) + " bytes, found " + std::to_string(size));
  const auto bytes = std::as_writable_bytes(std::span(&header, 1));
  source(0, bytes);
  require(header.magic == pages::magic, name, 0, "a page file, as swiftgs pages writes it");
  require(header.version == pages::version, name, offsetof(FileHeader, version),
          "version " + std::to_string(pages::version) + ", found " + std::to_string(header.version));
  require(header.checksum == pages::checksum_of(bytes.first(pages::checksum_offset)), name,
          pages::checksum_offset, "the checksum of the header");
  require(header.file_size == size, name, offsetof(FileHeader, file_size),
          "the size of the file, " + std::to_string(size) + ", found " + std::to_string(header.file_size));
  require(header.page_size != 0 && header.page_size % chunk_size == 0, name, offsetof(FileHeader, page_size),
          "a page size that is a multiple of " + std::to_string(chunk_size));
  require(header.pages != 0, name, offsetof(FileHeader, pages), "one page or more");
  require(header.gaussians <= std::numeric_limits<std::uint32_t>::max(), name,
          offsetof(FileHeader, gaussians), "fewer than 2^32 Gaussians");
  require(header.sh_degree <= std::uint32_t(max_sh_degree), name, offsetof(FileHeader, sh_degree),
          "a degree of 0 to 3");
  for (const double at : header.origin)
    require(detail::is_finite(float(at)), name, offsetof(FileHeader, origin), "a finite origin");
  require(header.table <= size && size - header.table == header.pages * std::uint64_t(sizeof(Page)), name,
          offsetof(FileHeader, table),
          "a table of " + std::to_string(header.pages) + " pages that ends the file");
  return header;
}

/// Whether `outer` holds `inner`.
bool holds(const ChunkBounds& outer, const ChunkBounds& inner) {
  bool inside = outer.size >= inner.size && outer.opacity >= inner.opacity;
  for (int k = 0; k < 3; ++k)
    inside = inside && outer.low[k] <= inner.low[k] && outer.high[k] >= inner.high[k];
  return inside;
}

/// What was expected of a row of the table, by itself; null if the row is valid.
const char* unmet(const Page& page, const FileHeader& header) {
  const ChunkBounds& b = page.bounds;
  if (!detail::is_finite(b.low) || !detail::is_finite(b.high) || !detail::is_finite(b.size) ||
      !(b.size >= 0) || !(b.opacity >= 0 && b.opacity <= 1))
    return "finite bounds and an opacity of 0 to 1";
  for (int k = 0; k < 3; ++k)
    if (!(b.low[k] <= b.high[k])) return "bounds whose first corner is the lower one";
  if (page.count == 0 || page.count > header.page_size)
    return "1 Gaussian or more, and no more than the page size";
  if (page.harmonic_format > std::uint8_t(HarmonicFormat::bytes)) return "harmonics of format 0 to 2";
  if (page.sh_degree > header.sh_degree) return "no higher degree than that of the file";
  if (page.has_labels > 1 || page.has_ids > 1) return "flags of 0 or 1";
  if (page.has_labels != 0 ? page.rows == 0 || page.rows > 65536 : page.rows != page.count)
    return "a row of harmonics for each Gaussian, or 1 to 65536 rows of a palette";
  if (!(page.harmonic_scale > 0) || !detail::is_finite(page.harmonic_scale)) return "a scale above 0";
  if (!(page.finest > 0) || !detail::is_finite(page.finest)) return "a finest pixel above 0";
  for (const float error : page.errors)
    if (!(error >= 0) || !detail::is_finite(error)) return "finite errors of 0 or more";
  if (page.offset % pages::alignment != 0 || page.offset < sizeof(FileHeader) || page.offset > header.table ||
      page.bytes > header.table - page.offset)
    return "content between header and table, at a multiple of 64";
  if (page.bytes != pages::content_size(page)) return "as many bytes as its arrays have";
  return nullptr;
}

/// Throws unless the pages are a tree whose leaves have all Gaussians in order.
void check_tree(const std::vector<Page>& all, const FileHeader& header, const std::string& name) {
  std::vector<std::uint32_t> ends(all.size());                           // of the Gaussians below each page
  std::vector<std::uint8_t> has_parent(all.size()), levels(all.size());  // below each page
  for (std::uint32_t i = 0; i < all.size(); ++i) {
    const Page& page = all[i];
    const auto expect = [&](bool holds, const char* expected) {
      require(holds, name, header.table + i * sizeof(Page),
              "page " + std::to_string(i) + " with " + expected);
    };
    if (const char* const expected = unmet(page, header)) expect(false, expected);
    if (page.is_leaf()) {
      expect(page.right == Page::none, "two children or none");
      expect(page.first <= header.gaussians && page.count <= header.gaussians - page.first,
             "Gaussians of the file");
      ends[i] = std::uint32_t(page.first + page.count);
      continue;
    }
    expect(page.left < i && page.right < i && page.left != page.right, "children before it");
    expect(!has_parent[page.left] && !has_parent[page.right], "children that have no other parent");
    has_parent[page.left] = has_parent[page.right] = 1;
    const int below = 1 + std::max(levels[page.left], levels[page.right]);
    expect(below <= pages::most_levels, "64 levels below it at most");
    levels[i] = std::uint8_t(below);
    expect(all[page.left].first == page.first && all[page.right].first == ends[page.left],
           "children whose Gaussians follow each other");
    expect(holds(page.bounds, all[page.left].bounds) && holds(page.bounds, all[page.right].bounds),
           "bounds that hold those of its children");
    ends[i] = ends[page.right];
  }
  require(std::count(has_parent.begin(), has_parent.end(), 0) == 1 && all.back().first == 0 &&
              ends.back() == header.gaussians,
          name, header.table, "one tree of all Gaussians, whose root is the last page");
}

/// The first bytes of a regular file, else none: opening a pipe would wait for a writer.
std::string beginning_of(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) return {};
  std::string begin(io::beginning_bytes, '\0');
  std::ifstream file(path, std::ios::binary);
  file.read(begin.data(), std::streamsize(begin.size()));
  begin.resize(std::size_t(file.gcount()));
  return begin;
}

/// Accepts any `tileset.json`, so that `open_tiles` reports what an invalid one lacks.
bool is_tileset(const std::filesystem::path& path) {
  return path.filename() == "tileset.json" || io::is_tileset(beginning_of(path));
}

}  // namespace

PageContent pages::read_page(const PagedScene::State& file, const PageSource& source, std::uint32_t number) {
  const Page& page = file.pages[number];
  std::vector<std::byte> bytes(page.bytes);
  source(page.offset, bytes);
  const auto expect = [&](bool holds, const char* expected) {
    require(holds, file.name, page.offset, "page " + std::to_string(number) + " with " + expected);
  };
  expect(pages::checksum_of(bytes) == page.checksum, "its checksum");

  const std::byte* parts[8];
  std::size_t k = 0;
  pages::for_each_part(page,
                       [&](std::uint64_t offset, std::uint64_t) { parts[k++] = bytes.data() + offset; });
  PageContent content;
  Scene& scene = content.scene;
  scene.sh_degree = page.sh_degree, scene.model = file.model, scene.origin = file.origin;
  k = 0;
  const auto take = [&](auto& values, std::size_t count) {
    values.resize(count);
    if (count != 0) std::memcpy(values.data(), parts[k], count * sizeof values[0]);
    ++k;
  };
  const std::size_t count = page.count;
  take(scene.means, count), take(scene.scales, count), take(scene.rotations, count);
  take(scene.opacities, count), take(scene.sh0, count);
  HarmonicRows rows;
  rows.data = parts[5], rows.size = count, rows.format = HarmonicFormat(page.harmonic_format);
  rows.stride = std::uint32_t(padded_row(rows.format, page.sh_degree)), rows.scale = page.harmonic_scale;
  if (page.has_labels != 0) {
    rows.labels = reinterpret_cast<const std::uint16_t*>(parts[6]);
    expect(*std::max_element(rows.labels, rows.labels + count) < page.rows, "labels of its rows");
  }
  const std::size_t each = 3 * std::size_t(sh_rest_count(page.sh_degree));
  scene.sh_rest.resize(each * count);
  if (each != 0)
    for (std::size_t i = 0; i < count; ++i) rows.load(i, page.sh_degree, scene.sh_rest.data() + each * i);
  k = 7;
  if (page.has_ids != 0) take(content.ids, count);
  const auto is_number = [&](std::uint32_t id) { return id < file.gaussians; };
  expect(std::all_of(content.ids.begin(), content.ids.end(), is_number), "numbers of the file's Gaussians");
  try {
    validate_numbers(scene);
  } catch (const InvalidArgument&) {
    expect(false, "finite numbers");
  }
  return content;
}

PagedScene::PagedScene(PageSource source, std::uint64_t size, std::string name) {
  State state;
  const FileHeader header = read_header(source, size, name);
  state.pages.resize(header.pages);
  source(header.table, bytes_of_vector(state.pages));
  require(header.table_checksum == pages::checksum_of(bytes_of_vector(state.pages)), name,
          offsetof(FileHeader, table_checksum), "the checksum of the table");
  check_tree(state.pages, header, name);
  for (const Page& page : state.pages) {
    state.first_child.push_back(std::uint32_t(state.children.size()));
    if (!page.is_leaf()) state.children.insert(state.children.end(), {page.left, page.right});
  }
  state.first_child.push_back(std::uint32_t(state.children.size()));
  std::string_view model(header.model.data(), header.model.size());
  model = model.substr(0, model.find('\0'));
  try {
    if (!model.empty()) state.model = model_from(model);
  } catch (const InvalidArgument& error) {
    throw FormatError(name, offsetof(FileHeader, model), std::string("a rendering model: ") + error.what());
  }
  state.name = std::move(name);
  state.gaussians = header.gaussians, state.page_size = header.page_size;
  state.sh_degree = int(header.sh_degree);
  state.origin = {header.origin[0], header.origin[1], header.origin[2]};
  auto shared = std::make_shared<State>(std::move(state));
  // The state has the function, which must not keep it.
  shared->read = [source = std::move(source), of = shared.get()](std::uint32_t page) {
    return pages::read_page(*of, source, page);
  };
  state_ = std::move(shared);
}

PageContent PagedScene::read(std::uint32_t page) const {
  if (page >= state_->pages.size())
    detail::refuse("page ", page, ": expected less than ", state_->pages.size());
  return state_->read(page);
}

bool is_page_file(const std::filesystem::path& path) {
  if (is_tileset(path)) return true;
  return beginning_of(path).starts_with(std::string_view(pages::magic.data(), pages::magic.size()));
}

PagedScene open_pages(const std::filesystem::path& path) {
  if (is_tileset(path)) return pages::open_tiles(path);
  if (path.filename() == "lod-meta.json") return pages::open_streamed_sog(path);
  const auto file = std::make_shared<const io::MappedFile>(path);
  const auto read = [file](std::uint64_t offset, std::span<std::byte> to) {
    std::memcpy(to.data(), file->bytes().data() + offset, to.size());
  };
  return PagedScene(read, file->bytes().size(), path.string());
}

std::vector<std::uint32_t> pages::leaves_of(const PagedScene& pages) {
  std::vector<std::uint32_t> leaves;
  for (std::uint32_t i = 0; i < pages.pages().size; ++i)
    if (pages.pages()[i].is_leaf()) leaves.push_back(i);
  std::sort(leaves.begin(), leaves.end(), [&](std::uint32_t a, std::uint32_t b) {
    return pages.pages()[a].first < pages.pages()[b].first;
  });
  return leaves;
}

Scene read_leaves(const PagedScene& pages) {
  Scene all;
  all.model = pages.model(), all.sh_degree = pages.sh_degree(), all.origin = pages.origin();
  for (const std::uint32_t leaf : pages::leaves_of(pages)) append(all, pages.read(leaf).scene);
  return all;
}

}  // namespace swiftgs
