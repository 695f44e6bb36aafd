// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <span>
#include <vector>

#include <swiftgs/scene.hpp>

#include "json_entry.hpp"
#include "sog_files.hpp"

namespace swiftgs::io {
namespace {

using nlohmann::json;

/// An object of `meta.json`, such as "means", and how to read what SOG keeps in one.
class Part {
 public:
  Part(const JsonEntry& root, const char* key)
      : entry_(root.source(), root.member(key),
               offset_of_member(root.source().text(), root.source().text().find('{'), key), key) {}

  const JsonEntry& entry() const { return entry_; }

  /// `count` numbers; one alone stands for all.
  std::vector<double> numbers(const char* key, std::size_t count) const {
    const json& value = entry_.member(key);
    if (value.is_number()) return std::vector<double>(count, value.get<double>());
    std::vector<double> numbers;
    if (value.is_array() && value.size() == count)
      for (const json& number : value)
        if (number.is_number()) numbers.push_back(number.get<double>());
    if (numbers.size() != count)
      entry_.fail(std::string("'") + key + "' to be " + std::to_string(count) + " numbers");
    return numbers;
  }

  std::uint32_t whole(const char* key, std::uint32_t most) const {
    const double number = entry_.number(key);
    if (!(number >= 1 && number <= most && number == std::floor(number)))
      entry_.fail(std::string("'") + key + "' to be a whole number from 1 to " + std::to_string(most));
    return std::uint32_t(number);
  }

  /// Stores the names of as many images as `to` has room for.
  void images(std::span<std::string> to) const {
    const json& names = entry_.member("files");
    const auto expect = [&](bool holds) {
      if (!holds)
        entry_.fail("'files' to be " + std::to_string(to.size()) + " names of files in the same folder");
    };
    expect(names.is_array() && names.size() == to.size());
    for (std::size_t i = 0; i < to.size(); ++i) {
      expect(names[i].is_string());
      to[i] = names[i].get<std::string>();
      expect(stays_inside(to[i]));
    }
  }

  /// What each byte stands for in version 2.
  template <class Activate>
  SogMeta::Table codebook(const Activate& activate) const {
    const std::vector<double> values = numbers("codebook", 256);
    SogMeta::Table table;
    for (int byte = 0; byte < 256; ++byte) table[byte] = float(activate(values[byte]));
    return table;
  }

  /// What each byte of channel `channel` of `channels` stands for in version 1.
  template <class Activate>
  SogMeta::Table range(int channel, std::size_t channels, const Activate& activate) const {
    const double least = numbers("mins", channels)[channel], most = numbers("maxs", channels)[channel];
    SogMeta::Table table;
    for (int byte = 0; byte < 256; ++byte) table[byte] = float(activate(least + (most - least) * byte / 255));
    return table;
  }

 private:
  JsonEntry entry_;
};

constexpr std::uint32_t max_count = 1u << 31;
constexpr std::uint32_t max_palette = 1u << 16;  // a label has 16 bits

double scale_of(double logarithm) { return std::exp(logarithm); }
double opacity_of(double logit) { return 1 / (1 + std::exp(-logit)); }
double as_stored(double value) { return value; }

void set_values_1(SogMeta& meta, const Part& means, const Part& scales, const Part& colours) {
  const json& shape = means.entry().member("shape");
  const bool counted = shape.is_array() && !shape.empty() && shape[0].is_number_unsigned();
  if (!counted || shape[0].get<std::uint64_t>() < 1 || shape[0].get<std::uint64_t>() > max_count)
    means.entry().fail("'shape' to begin with the number of Gaussians");
  meta.count = shape[0].get<std::uint32_t>();
  for (int c = 0; c < 3; ++c) {
    meta.scales[c] = scales.range(c, 3, scale_of);
    meta.colours[c] = colours.range(c, 4, as_stored);
  }
  meta.opacities = colours.range(3, 4, opacity_of);
}

void set_values_2(SogMeta& meta, const Part& scales, const Part& colours) {
  meta.scales.fill(scales.codebook(scale_of));
  meta.colours.fill(colours.codebook(as_stored));
  for (int byte = 0; byte < 256; ++byte) meta.opacities[byte] = float(byte) / 255;
}

void set_sh(SogMeta& meta, const Part& sh) {
  std::array<std::string, 2> names;
  sh.images(names);
  meta.images[sog_sh_palette] = names[0];
  meta.images[sog_sh_labels] = names[1];
  if (meta.version == 1) {
    meta.sh = sh.range(0, 1, as_stored);
  } else {
    meta.sh = sh.codebook(as_stored);
    meta.sh_degree = int(sh.whole("bands", max_sh_degree));
    meta.palette_size = sh.whole("count", max_palette);
  }
}

void set_model(SogMeta& meta, const JsonEntry& root) {
  const std::string model = root.has("model") ? root.string("model") : "default";
  const bool flat = model == "2dgs";
  meta.model.antialiased =
      model == "antialiased" || (root.has("antialias") && root.member("antialias") == json(true));
  if (flat) meta.model.kernel = RenderingModel::Kernel::disk, meta.scales[2].fill(0);
  if (!flat && !meta.model.antialiased && model != "default") meta.unknown_model = model;
}

}  // namespace

SogMeta parse_sog_meta(const Source& source) {
  const json value = parse_json(source);
  const JsonEntry root(source, value, 0, "meta.json of a SOG");
  SogMeta meta;
  const double version = root.has("version") ? root.number("version") : 1;
  if (version != 1 && version != 2) root.fail("SOG version 1 or 2");
  meta.version = int(version);

  const Part means(root, "means"), scales(root, "scales"), rotations(root, "quats"), colours(root, "sh0");
  const std::span<std::string> images(meta.images);
  means.images(images.subspan(sog_means_low, 2));
  scales.images(images.subspan(sog_scales, 1));
  rotations.images(images.subspan(sog_rotations, 1));
  colours.images(images.subspan(sog_colours, 1));
  const auto least = means.numbers("mins", 3), most = means.numbers("maxs", 3);
  for (int axis = 0; axis < 3; ++axis) meta.mean_min[axis] = least[axis], meta.mean_max[axis] = most[axis];
  if (version == 1) {
    set_values_1(meta, means, scales, colours);
  } else {
    const double count = root.number("count");
    if (!(count >= 1 && count <= max_count && count == std::floor(count)))
      root.fail("'count' to be the number of Gaussians");
    meta.count = std::uint32_t(count);
    set_values_2(meta, scales, colours);
  }
  if (root.has("shN") && !root.member("shN").is_null()) set_sh(meta, Part(root, "shN"));
  set_model(meta, root);
  return meta;
}

}  // namespace swiftgs::io
