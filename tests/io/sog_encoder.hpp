// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>
#include <webp/encode.h>

#include <swiftgs/scene.hpp>

#include "files.hpp"
#include "zip_encoder.hpp"

namespace swiftgs::test {

/// Pixels of four bytes, row by row.
struct SogPicture {
  int width = 0, height = 0;
  std::string rgba{};
};

/// A SOG taken apart. A test may falsify any of it before `sog_files` puts it together.
struct SogParts {
  nlohmann::json meta{};
  std::map<std::string, SogPicture> pictures{};
};

inline std::string webp(const SogPicture& picture, bool lossless = true) {
  WebPConfig config;
  REQUIRE(WebPConfigInit(&config));
  config.lossless = lossless, config.exact = 1, config.method = 1;
  WebPPicture image;
  REQUIRE(WebPPictureInit(&image));
  image.use_argb = 1, image.width = picture.width, image.height = picture.height;
  REQUIRE(WebPPictureImportRGBA(&image, reinterpret_cast<const std::uint8_t*>(picture.rgba.data()),
                                4 * picture.width));
  WebPMemoryWriter memory;
  WebPMemoryWriterInit(&memory);
  image.writer = WebPMemoryWrite, image.custom_ptr = &memory;
  REQUIRE(WebPEncode(&config, &image));
  std::string file(reinterpret_cast<const char*>(memory.mem), memory.size);
  WebPMemoryWriterClear(&memory);
  WebPPictureFree(&image);
  return file;
}

/// A picture for `count` Gaussians, of which `pixel(i)` gives four bytes.
template <class Pixel>
SogPicture sog_picture(std::size_t count, const Pixel& pixel) {
  SogPicture picture;
  picture.width = int(std::ceil(std::sqrt(double(count))));
  picture.height = int((count + picture.width - 1) / picture.width);
  for (std::size_t i = 0; i < std::size_t(picture.width) * picture.height; ++i) {
    const std::array<int, 4> bytes = i < count ? pixel(i) : std::array<int, 4>{};
    for (const int byte : bytes) picture.rgba += char(byte);
  }
  return picture;
}

/// Numbers on a grid from the least to the greatest.
struct SogGrid {
  double least = 0, most = 1, steps = 255;

  template <class Numbers>
  static SogGrid around(const Numbers& numbers, double steps = 255) {
    SogGrid grid{numbers.front(), numbers.front(), steps};
    for (const double number : numbers)
      grid.least = std::min(grid.least, number), grid.most = std::max(grid.most, number);
    return grid;
  }
  int index(double number) const {
    return most > least ? int(std::lround((number - least) / (most - least) * steps)) : 0;
  }
  double step() const { return (most - least) / steps; }
  std::vector<double> codebook() const {
    std::vector<double> values;
    for (int i = 0; i < 256; ++i) values.push_back(least + i * step());
    return values;
  }
};

inline std::array<int, 4> sog_rotation(const Quaternion& q) {
  const std::array<double, 4> wxyz = {q.w, q.x, q.y, q.z};
  int largest = 0;
  for (int i = 1; i < 4; ++i)
    if (std::abs(wxyz[i]) > std::abs(wxyz[largest])) largest = i;
  std::array<int, 4> pixel{};
  int next = 0;
  for (int i = 0; i < 4; ++i)
    if (i != largest)
      pixel[next++] =
          int(std::lround(((wxyz[largest] < 0 ? -wxyz[i] : wxyz[i]) / std::sqrt(2.0) + 0.5) * 255));
  pixel[3] = 252 + largest;
  return pixel;
}

/// The file that `SogParts` has a picture for, as both versions name it.
inline constexpr const char* sog_names[] = {"means_l.webp",   "means_u.webp", "scales.webp",
                                            "quats.webp",     "sh0.webp",     "shN_centroids.webp",
                                            "shN_labels.webp"};

/// Quantises `scene` on even grids. Every Gaussian has an entry of its own in the palette of harmonics.
inline SogParts encode_sog(const Scene& scene, int version) {
  using nlohmann::json;
  const std::size_t count = scene.size();
  SogParts parts;
  json& meta = parts.meta;
  const auto logarithm = [](double x) { return std::copysign(std::log1p(std::abs(x)), x); };
  std::array<std::vector<double>, 3> means, scales, colours;
  std::vector<double> all_scales, all_colours, logits;
  for (std::size_t i = 0; i < count; ++i) {
    for (int c = 0; c < 3; ++c) {
      means[c].push_back(logarithm(scene.means[i][c]));
      scales[c].push_back(std::log(double(scene.scales[i][c])));
      colours[c].push_back(scene.sh0[i][c]);
      all_scales.push_back(scales[c].back()), all_colours.push_back(colours[c].back());
    }
    const double opacity = std::clamp(double(scene.opacities[i]), 1e-6, 1 - 1e-6);
    logits.push_back(std::log(opacity / (1 - opacity)));
  }
  std::array<SogGrid, 3> mean_grid, scale_grid, colour_grid;
  for (int c = 0; c < 3; ++c) {
    mean_grid[c] = SogGrid::around(means[c], 65535);
    scale_grid[c] = version == 1 ? SogGrid::around(scales[c]) : SogGrid::around(all_scales);
    colour_grid[c] = version == 1 ? SogGrid::around(colours[c]) : SogGrid::around(all_colours);
  }
  const SogGrid logit_grid = SogGrid::around(logits);
  const auto least = [](const auto& grids) { return json{grids[0].least, grids[1].least, grids[2].least}; };
  const auto most = [](const auto& grids) { return json{grids[0].most, grids[1].most, grids[2].most}; };

  meta["means"] = {
      {"mins", least(mean_grid)}, {"maxs", most(mean_grid)}, {"files", {sog_names[0], sog_names[1]}}};
  meta["scales"]["files"] = nlohmann::json::array({sog_names[2]});
  meta["quats"]["files"] = nlohmann::json::array({sog_names[3]});
  meta["sh0"]["files"] = nlohmann::json::array({sog_names[4]});
  if (version == 1) {
    meta["means"]["shape"] = {count, 3};
    meta["scales"]["mins"] = least(scale_grid), meta["scales"]["maxs"] = most(scale_grid);
    meta["sh0"]["mins"] = least(colour_grid), meta["sh0"]["maxs"] = most(colour_grid);
    meta["sh0"]["mins"].push_back(logit_grid.least), meta["sh0"]["maxs"].push_back(logit_grid.most);
  } else {
    meta["version"] = 2, meta["count"] = count;
    meta["scales"]["codebook"] = scale_grid[0].codebook();
    meta["sh0"]["codebook"] = colour_grid[0].codebook();
  }
  const auto mean_byte = [&](std::size_t i, int shift) {
    const auto byte = [&](int c) { return mean_grid[c].index(means[c][i]) >> shift & 255; };
    return std::array<int, 4>{byte(0), byte(1), byte(2), 255};
  };
  parts.pictures[sog_names[0]] = sog_picture(count, [&](std::size_t i) { return mean_byte(i, 0); });
  parts.pictures[sog_names[1]] = sog_picture(count, [&](std::size_t i) { return mean_byte(i, 8); });
  parts.pictures[sog_names[2]] = sog_picture(count, [&](std::size_t i) {
    const auto byte = [&](int c) { return scale_grid[c].index(scales[c][i]); };
    return std::array<int, 4>{byte(0), byte(1), byte(2), 255};
  });
  parts.pictures[sog_names[3]] =
      sog_picture(count, [&](std::size_t i) { return sog_rotation(scene.rotations[i]); });
  parts.pictures[sog_names[4]] = sog_picture(count, [&](std::size_t i) {
    const auto byte = [&](int c) { return colour_grid[c].index(colours[c][i]); };
    const int opacity =
        version == 1 ? logit_grid.index(logits[i]) : int(std::lround(scene.opacities[i] * 255));
    return std::array<int, 4>{byte(0), byte(1), byte(2), opacity};
  });
  if (scene.sh_degree == 0) return parts;

  const SogGrid grid = SogGrid::around(scene.sh_rest);
  meta["shN"]["files"] = {sog_names[5], sog_names[6]};
  if (version == 1) {
    meta["shN"]["mins"] = grid.least, meta["shN"]["maxs"] = grid.most;
  } else {
    meta["shN"]["count"] = count, meta["shN"]["bands"] = scene.sh_degree;
    meta["shN"]["codebook"] = grid.codebook();
  }
  const int coefficients = sh_rest_count(scene.sh_degree);
  SogPicture palette{64 * coefficients, int((count + 63) / 64)};
  for (std::size_t i = 0; i < scene.sh_rest.size(); ++i) {
    palette.rgba += char(grid.index(scene.sh_rest[i]));
    if (i % 3 == 2) palette.rgba += char(255);
  }
  palette.rgba.resize(4 * std::size_t(palette.width) * palette.height);
  parts.pictures[sog_names[5]] = palette;
  parts.pictures[sog_names[6]] = sog_picture(count, [](std::size_t i) {
    return std::array<int, 4>{int(i & 255), int(i >> 8), 0, 255};
  });
  return parts;
}

/// `meta.json` and the images, by name.
inline std::map<std::string, std::string> sog_files(const SogParts& parts) {
  std::map<std::string, std::string> files{{"meta.json", parts.meta.dump()}};
  for (const auto& [name, picture] : parts.pictures) files[name] = webp(picture);
  return files;
}

inline std::string sog_bundle(const SogParts& parts, ZipStyle style = {}) {
  return zip(sog_files(parts), style);
}

/// Writes a folder and returns the path of its `meta.json`.
inline std::filesystem::path write_sog(const TemporaryFolder& place, const std::string& folder,
                                       const SogParts& parts) {
  for (const auto& [name, content] : sog_files(parts)) place.write(folder + "/" + name, content);
  return place / (folder + "/meta.json");
}

}  // namespace swiftgs::test
