// SPDX-License-Identifier: Apache-2.0
#include "records.hpp"

#include <algorithm>
#include <cerrno>
#include <string>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <stdio.h>
#include <unistd.h>

#include <swiftgs/error.hpp>

#include "nodes.hpp"
#include "output_file.hpp"

namespace swiftgs::pages {
namespace {

constexpr std::size_t block_records = 4096;

[[noreturn]] void fail(const std::filesystem::path& path) {
  throw FileError({errno != 0 ? errno : EIO, std::generic_category()}, path.string());
}

}  // namespace

Records::Records(std::filesystem::path path) : path_(std::move(path)), file_(nullptr, &std::fclose) {
  const io::UnfinishedFile place(path_);  // a name beside what links lead to, which it removes
  int descriptor = -1;
#if defined(O_TMPFILE)
  const std::filesystem::path folder = place.path().has_parent_path() ? place.path().parent_path() : ".";
  descriptor = ::open(folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
#endif
  if (descriptor < 0) descriptor = ::open(place.path().c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
  if (descriptor < 0) fail(path_);
  file_.reset(::fdopen(descriptor, "w+b"));
  if (!file_) ::close(descriptor), fail(path_);
}

template <class F>
void Records::for_each(std::size_t first, std::size_t count, const F& f) {
  std::vector<Record> block(std::min(block_records, count));
  if (::fseeko(file_.get(), off_t(first * sizeof(Record)), SEEK_SET) != 0) fail(path_);
  for (std::size_t done = 0; done < count; done += block.size()) {
    block.resize(std::min(block_records, count - done));
    errno = 0;
    if (std::fread(block.data(), sizeof(Record), block.size(), file_.get()) != block.size()) fail(path_);
    for (const Record& record : block) f(record);
  }
}

void Records::flush(std::vector<Record>& block) {
  errno = 0;
  if (std::fwrite(block.data(), sizeof(Record), block.size(), file_.get()) != block.size()) fail(path_);
  size_ += block.size();
  block.clear();
}

void Records::add(std::vector<Record>& block, const Record& record) {
  block.push_back(record);
  if (block.size() == block_records) flush(block);
}

void Records::append(const Scene& scene, std::uint32_t first_id) {
  const std::size_t each = 3 * std::size_t(sh_rest_count(scene.sh_degree));
  std::vector<Record> block;
  block.reserve(block_records);
  for (std::size_t i = 0; i < scene.size(); ++i) {
    Record record{scene.means[i],
                  scene.scales[i],
                  scene.rotations[i],
                  scene.opacities[i],
                  scene.sh0[i],
                  {},
                  first_id + std::uint32_t(i)};
    std::copy_n(scene.sh_rest.data() + each * i, each, record.sh_rest);
    add(block, record);
  }
  flush(block);
}

PageContent Records::read(std::size_t first, std::size_t count, const Scene& like) {
  PageContent content{empty_like(like), {}};
  Scene& scene = content.scene;
  const std::size_t each = 3 * std::size_t(sh_rest_count(scene.sh_degree));
  for_each_array([&](const char*, std::size_t values, auto& array) { array.reserve(values * count); }, scene);
  content.ids.reserve(count);
  for_each(first, count, [&](const Record& r) {
    scene.means.push_back(r.mean), scene.scales.push_back(r.scale), scene.rotations.push_back(r.rotation);
    scene.opacities.push_back(r.opacity), scene.sh0.push_back(r.sh0);
    scene.sh_rest.insert(scene.sh_rest.end(), r.sh_rest, r.sh_rest + each);
    content.ids.push_back(r.id);
  });
  return content;
}

std::pair<Records, Records> Records::split(std::size_t left) {
  const std::size_t step = size_ / block_records + 1;
  std::vector<vec3> sample;
  std::size_t number = 0;
  for_each(0, size_, [&](const Record& r) {
    if (number++ % step == 0) sample.push_back(r.mean);
  });
  const int axis = longest_axis(std::move(sample));

  std::vector<float> values(size_);
  number = 0;
  for_each(0, size_, [&](const Record& r) { values[number++] = r.mean[axis]; });
  const auto border = values.begin() + std::ptrdiff_t(left);
  std::nth_element(values.begin(), border, values.end());
  const float first_right = *border;
  auto equal_left = std::size_t(std::count(values.begin(), border, first_right));
  std::pair<Records, Records> halves{Records(path_), Records(path_)};
  std::vector<Record> blocks[2];
  for (auto& block : blocks) block.reserve(block_records);
  for_each(0, size_, [&](const Record& r) {
    const float value = r.mean[axis];
    const bool is_left =
        value < first_right || (value == first_right && equal_left != 0 && equal_left-- != 0);
    is_left ? halves.first.add(blocks[0], r) : halves.second.add(blocks[1], r);
  });
  halves.first.flush(blocks[0]), halves.second.flush(blocks[1]);
  return halves;
}

}  // namespace swiftgs::pages
