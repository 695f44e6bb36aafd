// SPDX-License-Identifier: Apache-2.0
#include "records.hpp"

#include <algorithm>
#include <span>
#include <utility>

#include "nodes.hpp"
#include "page_file.hpp"

namespace swiftgs::pages {
namespace {

constexpr std::size_t block_records = 4096;

}  // namespace

template <class F>
void Records::for_each(std::size_t first, std::size_t count, const F& f) {
  std::vector<Record> block(std::min(block_records, count));
  for (std::size_t done = 0; done < count; done += block.size()) {
    block.resize(std::min(block_records, count - done));
    file_.read((first + done) * sizeof(Record), std::as_writable_bytes(std::span(block)));
    for (const Record& record : block) f(record);
  }
}

void Records::flush(std::vector<Record>& block) {
  file_.write(size_ * sizeof(Record), std::as_bytes(std::span(block)));
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
    checksum_ = checksum_of(std::as_bytes(std::span(&record, 1)), checksum_);
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
  std::vector<vec3> sample;
  for (std::size_t k = 0; k < size_; k += size_ / block_records + 1)
    for_each(k, 1, [&](const Record& r) { sample.push_back(r.mean); });
  const int axis = longest_axis(std::move(sample));

  std::vector<float> values(size_);
  std::size_t number = 0;
  for_each(0, size_, [&](const Record& r) { values[number++] = r.mean[axis]; });
  const auto border = values.begin() + std::ptrdiff_t(left);
  std::nth_element(values.begin(), border, values.end());
  const float first_right = *border;
  auto equal_left = std::size_t(std::count(values.begin(), border, first_right));
  std::pair<Records, Records> halves{Records(folder_), Records(folder_)};
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
