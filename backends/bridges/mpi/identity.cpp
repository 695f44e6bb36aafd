// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstdio>
#include <memory>
#include <string_view>
#include <system_error>
#include <vector>

#include <link.h>

#include <swiftgs/error.hpp>
#include <swiftgs/mpi/identity.hpp>
#include <swiftgs/version.hpp>

namespace swiftgs {
namespace {

/// FNV-1a of 64 bits: finds accidents, and nobody forges a rank.
class Checksum {
 public:
  void add(const void* data, std::size_t bytes) {
    const auto* at = static_cast<const unsigned char*>(data);
    for (std::size_t i = 0; i < bytes; ++i) sum_ = (sum_ ^ at[i]) * 0x100000001b3u;
  }
  /// A number without padding.
  template <class T>
  void add(const T& value) {
    static_assert(std::is_arithmetic_v<T>);
    add(&value, sizeof value);
  }
  std::uint64_t value() const { return sum_; }
  std::string text() const {
    char digits[17];
    std::snprintf(digits, sizeof digits, "%016llx", static_cast<unsigned long long>(sum_));
    return digits;
  }

 private:
  std::uint64_t sum_ = 0xcbf29ce484222325u;
};

struct CloseFile {
  void operator()(std::FILE* file) const { std::fclose(file); }
};

[[noreturn]] void fail(const std::filesystem::path& path) {
  throw FileError({errno, std::generic_category()}, path.string());
}

void add_block(Checksum& sum, std::FILE* file, const std::filesystem::path& path, std::uint64_t begin,
               std::size_t bytes) {
  std::vector<char> block(bytes);
  if (::fseeko(file, off_t(begin), SEEK_SET) != 0) fail(path);
  const std::size_t read = std::fread(block.data(), 1, bytes, file);
  if (std::ferror(file)) fail(path);
  sum.add(block.data(), read);
}

void add_file(Checksum& sum, const std::filesystem::path& path, std::uint64_t whole_up_to) {
  const std::unique_ptr<std::FILE, CloseFile> file(std::fopen(path.c_str(), "rb"));
  if (!file) fail(path);
  const std::uint64_t size = std::filesystem::file_size(path);
  constexpr std::size_t end_bytes = 64 << 10, block = 4 << 10, blocks = 64;
  if (size <= whole_up_to) {
    constexpr std::size_t step = 1 << 20;
    for (std::uint64_t at = 0; at < size; at += step) add_block(sum, file.get(), path, at, step);
    return;
  }
  add_block(sum, file.get(), path, 0, end_bytes);
  for (std::uint64_t k = 1; k <= blocks; ++k)
    add_block(sum, file.get(), path, size / (blocks + 1) * k / block * block, block);
  add_block(sum, file.get(), path, size - end_bytes, end_bytes);
}

/// The program and our own shared objects; the system's may differ from machine to machine.
std::vector<std::string> our_objects() {
  std::vector<std::string> paths{"/proc/self/exe"};
  const auto add = [](dl_phdr_info* object, std::size_t, void* to) {
    const std::string_view path = object->dlpi_name ? object->dlpi_name : "";
    if (path.substr(path.rfind('/') + 1).starts_with("libswiftgs"))
      static_cast<std::vector<std::string>*>(to)->emplace_back(path);
    return 0;
  };
  ::dl_iterate_phdr(add, &paths);
  std::sort(paths.begin() + 1, paths.end());
  return paths;
}

}  // namespace

std::string build_identity() {
  static const std::string identity = [] {
    Checksum sum;
    for (const std::string& path : our_objects()) add_file(sum, path, ~std::uint64_t(0));
    return std::string(version) + ", checksum " + sum.text();
  }();
  return identity;
}

std::string file_identity(const std::filesystem::path& path) {
  Checksum sum;
  add_file(sum, path, 1 << 20);
  return std::to_string(std::filesystem::file_size(path)) + " bytes, checksum " + sum.text();
}

std::uint64_t views_identity(Span<const View> views) {
  Checksum sum;
  const auto add = [&](const auto&... values) { (sum.add(values), ...); };
  for (const View& view : views) {
    const ViewConstants& c = view.camera;
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 3; ++column) add(c.rotation[row][column]);
      add(c.centre[row], view.background[row]);
    }
    add(c.fx, c.fy, c.cx, c.cy, c.width, c.height, c.left, c.top, c.right, c.bottom);
    add(c.limits.least_u, c.limits.most_u, c.limits.least_v, c.limits.most_v, c.near_plane, c.far_plane);
    // What is left to the scene may differ from rank to rank.
    add(c.blur_of_scene ? -1.0f : c.blur, c.antialiased_of_scene ? 2 : int(c.antialiased));
    add(c.min_compensation, c.alpha_min);
    const Distortion& d = c.lens.distortion;
    add(int(c.lens.model), c.depth_is_distance, c.order_is_distance, c.depth_along_ray,
        int(view.frame.conversion));
    add(c.depth_along_ray && view.asked().occluder);  // it adds attributes, and with them passes
    for (const double number : d.radial) add(number);
    for (const double number : d.rational) add(number);
    add(d.tangential[0], d.tangential[1], d.prism[0], d.prism[1]);
    add(view.rules.alpha_min, view.rules.alpha_max, view.rules.stop_below, view.rules.log2_alpha_min);
    add(view.rules.first_below);
    add(view.grid.columns.begin, view.grid.columns.end, view.grid.rows.begin, view.grid.rows.end);
    add(view.grid.side, view.frame.width, view.frame.height, view.shows.first, view.shows.count);
    for_each_plane([&](std::size_t channels, bool asked, const auto&) { add(asked ? channels : 0); },
                   view.asked().planes(), view.frame);
  }
  return sum.value();
}

}  // namespace swiftgs
