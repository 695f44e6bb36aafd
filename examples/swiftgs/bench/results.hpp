// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include <swiftgs/drivers/statistics.hpp>

#include "result_head.hpp"

/// What `bench` measures, as docs/schemas/bench.schema.json describes it.
namespace swiftgs::cli {

/// @units{milliseconds}
struct Duration {
  double median = 0;
  double low = 0, high = 0;  ///< limits of the median's 95 % confidence interval
  double p10 = 0, p90 = 0;
};

struct Durations {
  Duration project, sort, raster, total, wall;
};

/// A scene in one number of Gaussians and one enlargement.
struct SceneResult {
  std::string scene;
  std::size_t gaussians = 0, original = 0;
  double enlarge = 1;
  int sh_degree = 0;
  std::string model;     ///< how it was trained to be drawn, as `text_of` says it
  std::string geometry;  ///< checksum of the Gaussians; empty where no file is written

  bool operator==(const SceneResult&) const = default;
};

/// Which image.
struct Place {
  std::string scene;
  std::size_t gaussians = 0;
  double enlarge = 1;
  std::string view;
  int width = 0, height = 0;
  double scale = 1;
  std::string conventions;

  bool operator==(const Place&) const = default;
  static auto members(auto& self) {
    return std::tie(self.scene, self.gaussians, self.enlarge, self.view, self.width, self.height, self.scale,
                    self.conventions);
  }
};

/// How an image differs from a photograph.
struct PhotoErrors {
  double psnr_db = 0, ssim = 0;
};

/// How an image differs from the reference.
struct Errors {
  double psnr_db = 0, ssim = 0, max_abs = 0;
  std::optional<double> cut_psnr_db;  ///< against the reference with the cut of `ThreeSigmaSquare`
};

struct ViewResult {
  Place place;
  std::optional<PhotoErrors> photo;  ///< of the reference

  static auto members(auto& self) { return std::tie(self.place, self.photo); }
};

struct RowResult {
  Place place;
  int threads = 0;
  std::string renderer;
  std::string planes;     ///< beside colour, as `--planes` has them
  std::string harmonics;  ///< how they are kept, as `name_of` says it
  int frames = 0;
  std::size_t batch = 1;  ///< views of each frame; `ms` are its durations over their number
  Durations ms;
  std::optional<Errors> errors;
  std::optional<PhotoErrors> photo;
  std::uint64_t visible = 0, intersections = 0, contributing_pairs = 0;
  StageMemory bytes;
  std::uint64_t device_bytes = 0, host_bytes = 0;

  static auto members(auto& self) {
    return std::tie(self.place, self.threads, self.renderer, self.planes, self.harmonics, self.frames,
                    self.batch, self.ms, self.errors, self.photo, self.visible, self.intersections,
                    self.contributing_pairs, self.bytes, self.device_bytes, self.host_bytes);
  }
};

struct Results {
  ResultHead head;
  std::vector<SceneResult> scenes;
  std::vector<ViewResult> views;
  std::vector<RowResult> rows;
};

/// The document of `--json`.
std::string to_json(const Results& results);

/// What an earlier run of the command of `head` left in the file at `path`; no rows where the file is not
/// there. Throws `Unavailable` with `path` where it holds anything else, or is of another machine,
/// build or command.
Results resumed_results(const std::string& path, const ResultHead& head);

/// Throws `Unavailable` with `path` unless `found`, if it holds the scene, has the Gaussians of
/// `scene`.
void require_same_scene(const std::string& path, const Results& found, const SceneResult& scene);

}  // namespace swiftgs::cli
