// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include <swiftgs/edit/order.hpp>
#include <swiftgs/error.hpp>
#include <swiftgs/version.hpp>

#include "output_file.hpp"
#include "packed_output.hpp"
#include "scene_encoding.hpp"
#include "scene_format.hpp"
#include "sog_pixels.hpp"
#include "tasks.hpp"

namespace swiftgs::io {
namespace {

/// What `meta.json` says of a model.
RenderingModel sog_model(const RenderingModel& model) {
  if (model.antialiased) return {.antialiased = true};
  return {.kernel = model.kernel};
}

constexpr std::size_t most_colours = 1 << 16;

/// The largest power of two that is at most `count`: half a colour to one for each Gaussian, until labels
/// have all their 16 bits.
std::size_t palette_size(std::size_t count) { return std::min(most_colours, std::bit_floor(count)); }

/// The shortest digits that read as `value`.
template <class Float>
std::string digits(Float value) {
  std::array<char, 32> text;
  return {text.data(), std::to_chars(text.data(), text.data() + text.size(), value).ptr};
}

template <class Numbers>
std::string json_array(const Numbers& numbers, std::size_t count) {
  std::string text = "[";
  for (std::size_t i = 0; i < count; ++i) {
    if (i > 0) text += ",";
    text += digits(numbers[int(i)]);
  }
  return text + "]";
}

std::string json_codebook(const Codebook& codebook) {
  return "\"codebook\":" + json_array(codebook.values(), codebook.values().size());
}

/// The files of a bundle but `meta.json`, and what it says of them.
struct Contents {
  struct Image {
    std::string name;
    std::function<RgbaImage()> make;
  };
  std::vector<Image> images{};
  std::string meta{};
};

Contents contents(const Scene& scene, Order order, const MeanEncoder& means, const Palette& palette,
                  const std::array<Codebook, 3>& codebooks) {
  const Codebook &scales = codebooks[0], &colours = codebooks[1], &coefficients = codebooks[2];
  Contents result;
  result.images = {
      {"means_l.webp", [&scene, order, &means] { return means.image(scene, order, 0); }},
      {"means_u.webp", [&scene, order, &means] { return means.image(scene, order, 8); }},
      {"quats.webp", [&scene, order] { return rotation_image(scene, order); }},
      {"scales.webp", [&scene, order, &scales] { return scale_image(scene, order, scales); }},
      {"sh0.webp", [&scene, order, &colours] { return colour_image(scene, order, colours); }},
  };
  std::string& meta = result.meta;
  meta = "{\"version\":2,\"asset\":{\"generator\":\"SwiftGS " + std::string(version) +
         "\"},\"count\":" + std::to_string(order.size());
  const RenderingModel model = sog_model(scene.model);
  if (model.antialiased) meta += ",\"model\":\"antialiased\"";
  if (model.kernel == RenderingModel::Kernel::disk) meta += ",\"model\":\"2dgs\"";
  meta += ",\"means\":{\"mins\":" + json_array(means.least(), 3) +
          ",\"maxs\":" + json_array(means.most(), 3) + ",\"files\":[\"means_l.webp\",\"means_u.webp\"]}";
  meta += ",\"scales\":{" + json_codebook(scales) + ",\"files\":[\"scales.webp\"]}";
  meta += ",\"quats\":{\"files\":[\"quats.webp\"]}";
  meta += ",\"sh0\":{" + json_codebook(colours) + ",\"files\":[\"sh0.webp\"]}";
  if (scene.sh_degree > 0) {
    result.images.push_back({"shN_labels.webp", [&palette, order] { return label_image(palette, order); }});
    result.images.push_back(
        {"shN_centroids.webp", [&palette, &coefficients] { return palette_image(palette, coefficients); }});
    meta += ",\"shN\":{\"count\":" + std::to_string(palette.size()) +
            ",\"bands\":" + std::to_string(scene.sh_degree) + "," + json_codebook(coefficients) +
            ",\"files\":[\"shN_centroids.webp\",\"shN_labels.webp\"]}";
  }
  meta += "}";
  return result;
}

/// Brings harmonics into the range that they are compared in. Returns how many were beyond.
std::size_t clamp_harmonics(std::vector<float>& values) {
  std::size_t beyond = 0;
  for (float& value : values) {
    if (std::abs(value) <= largest_coordinate) continue;
    value = std::copysign(largest_coordinate, value);
    ++beyond;
  }
  return beyond;
}

void expect_count(const std::filesystem::path& path, std::size_t count) {
  constexpr std::size_t most = most_webp_pixels_a_side / 4 * 4 * (most_webp_pixels_a_side / 4 * 4);
  if (count == 0 || count > most)
    detail::refuse(path.string(), ": expected 1 to ", most, " Gaussians of finite numbers for a SOG, found ",
                   count);
}

/// Writes `scene`, but its higher bands from `harmonics`, which are clamped.
std::uint64_t write_bundle(const std::filesystem::path& path, const Scene& scene,
                           const std::vector<float>& harmonics, const ProgressMeter& progress,
                           LossMeter& losses) {
  expect_count(path, scene.size());
  const Points points{harmonics.data(), scene.size(), 3 * std::size_t(sh_rest_count(scene.sh_degree))};
  Palette palette;
  if (scene.sh_degree > 0) palette = make_palette(points, palette_size(scene.size()), progress.step(0, 0.7));
  std::vector<std::uint32_t> order;
  std::array<Codebook, 3> codebooks;
  for_tasks(4, progress.step(0.7, 0.8), [&](std::size_t task, const Stopping&) {
    if (task == 0) order = spatial_order(scene);
    if (task == 1) codebooks[0] = scale_codebook(scene);
    if (task == 2) codebooks[1] = colour_codebook(scene);
    if (task == 3) codebooks[2] = palette_codebook(palette);
  });
  const MeanEncoder means(scene);
  measure_sog(scene, means, codebooks[0], codebooks[1], losses);
  const Contents files = contents(scene, order, means, palette, codebooks);
  std::vector<std::string> encoded(files.images.size());
  for_tasks(encoded.size(), progress.step(0.8, 1), [&](std::size_t i, const Stopping& stopping) {
    encoded[i] = encode_webp(files.images[i].make(), stopping);
  });

  OutputFile file(path);
  ZipWriter zip(file);
  zip.add("meta.json", files.meta);
  for (std::size_t i = 0; i < encoded.size(); ++i) zip.add(files.images[i].name, encoded[i]);
  zip.finish();
  file.close();
  return file.size();
}

}  // namespace

WrittenScene write_sog(const std::filesystem::path& path, const Scene& scene,
                       const SceneWriteOptions& options, LossMeter& losses) {
  const ProgressMeter progress(options.progress, path.string());
  progress.report(0);
  WrittenScene written = written_whole("SOG version 2", scene);
  written.model = sog_model(scene.model);
  const auto too_large = [](float value) { return std::abs(value) > largest_coordinate; };
  if (std::none_of(scene.sh_rest.begin(), scene.sh_rest.end(), too_large)) {
    written.bytes = write_bundle(path, scene, scene.sh_rest, progress, losses);
  } else {
    std::vector<float> harmonics = scene.sh_rest;
    note_clamped(clamp_harmonics(harmonics), "SH coefficients above band 0", "-1e18 to 1e18", written.notes);
    written.bytes = write_bundle(path, scene, harmonics, progress, losses);
  }
  if (const auto sentence = losses.sentence()) written.notes.push_back(*sentence);
  return written;
}

}  // namespace swiftgs::io
