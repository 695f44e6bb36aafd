// SPDX-License-Identifier: Apache-2.0
#include "gpu_bench.hpp"

#include <algorithm>
#include <chrono>
#include <future>

#include <cuda_profiler_api.h>
#include <cuda_runtime_api.h>

#include <swiftgs/cuda/check.hpp>
#include <swiftgs/metrics.hpp>
#include <swiftgs/reference.hpp>

namespace swiftgs::bench {
namespace {

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t half = values.size() / 2;
  return values.size() % 2 ? values[half] : 0.5 * (values[half - 1] + values[half]);
}

std::size_t memory_in_use() {
  std::size_t free = 0, total = 0;
  check_cuda(cudaMemGetInfo(&free, &total), "cudaMemGetInfo");
  return total - free;
}

}  // namespace

GpuBench::GpuBench(const GpuOptions& options, const Input& input, std::FILE* out)
    : options_(options), input_(input), out_(out), scene_(input.load()) {
  if (input_.views.size() > std::size_t(options.views)) input_.views.resize(std::size_t(options.views));
  check_cuda(cudaFree(nullptr), "cudaFree");  // the context's own memory is there from now on
  empty_ = memory_in_use();
  on_device_ = std::make_unique<Cuda::SceneOn>(Cuda().upload(scene_));
  settings_.conventions.antialiased = scene_.antialiased;
  write("\"kind\":\"scene\",\"gaussians\":%zu,\"sh_degree\":%d,\"device_bytes\":%zu", scene_.size(),
        on_device_->view().sh_degree, memory_in_use() - empty_);
  // Every frame is rendered to one place.
  std::size_t pixels = 0;
  for (const Camera& view : input_.views)
    pixels = std::max(pixels, std::size_t(view.width) * std::size_t(view.height));
  colours_.reset(3 * pixels);
  find_truths();
}

template <class... Values>
void GpuBench::write(const char* format, Values... values) {
  std::fprintf(out_, "{\"scene\":\"%s\",", input_.name.c_str());
  std::fprintf(out_, format, values...);
  std::fprintf(out_, "}\n");
  std::fflush(out_);
}

void GpuBench::find_truths() {
  const auto add = [&](std::size_t view, const char* preset, Conventions::Footprint footprint) {
    Conventions conventions = conventions_named(preset);
    conventions.antialiased = scene_.antialiased, conventions.footprint = footprint;
    truths_.push_back(
        {view, preset, conventions, render_reference(scene_, input_.views[view], conventions).colour});
  };
  const std::size_t compared = std::min(input_.views.size(), std::size_t(options_.compared));
  for (std::size_t view = 0; view < compared; ++view) add(view, "gsplat", Conventions::Footprint::alpha);
  if (compared == 0) return;
  add(0, "gsplat", Conventions::Footprint::three_sigma_square);
  add(0, "inria", Conventions::Footprint::alpha);
  add(0, "inria", Conventions::Footprint::three_sigma_square);
}

double GpuBench::render(const Subject& subject, const Camera& camera, const RenderSettings& settings) {
  using Clock = std::chrono::steady_clock;
  const auto start = Clock::now();
  FrameView frame{.width = camera.width, .height = camera.height};
  frame.colour = {colours_.data(), 3 * sizeof(float) * std::size_t(camera.width)};
  subject.render(camera, settings, frame);
  check_cuda(cudaStreamSynchronize(nullptr), "cudaStreamSynchronize");
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

void GpuBench::measure(const Subject& subject) {
  std::fprintf(stderr, "%s %s\n", input_.name.c_str(), std::string(subject.name).c_str());
  // Buffers grow, and the adaptive sort measures each strategy in four frames, then decides.
  for (int i = 0; i < 9; ++i) render(subject, input_.views.front(), settings_);
  for (std::size_t view = 0; view < input_.views.size(); ++view) time(subject, view);
  write("\"kind\":\"memory\",\"renderer\":\"%s\",\"device_bytes\":%zu", std::string(subject.name).c_str(),
        memory_in_use() - empty_);
  for (const Truth& truth : truths_) compare(subject, truth);
  if (options_.profile) {
    check_cuda(cudaProfilerStart(), "cudaProfilerStart");
    render(subject, input_.views.front(), settings_);
    check_cuda(cudaProfilerStop(), "cudaProfilerStop");
  }
}

void GpuBench::time(const Subject& subject, std::size_t view) {
  const Camera& camera = input_.views[view];
  std::vector<double> project, sort, raster, total, wall;
  for (int i = 0; i < options_.frames + 2; ++i) {
    const double waited = render(subject, camera, settings_);
    if (i < 2) continue;
    const StageTimes ms = subject.times();
    project.push_back(ms.project), sort.push_back(ms.sort), raster.push_back(ms.raster);
    total.push_back(ms.total), wall.push_back(waited);
  }
  RenderSettings counting = settings_;
  counting.count = true;
  if (options_.compared > 0) render(subject, camera, counting);
  const Statistics counts = subject.statistics();
  write(
      "\"kind\":\"frame\",\"renderer\":\"%s\",\"view\":%zu,\"width\":%d,\"height\":%d,\"visible\":%zu,"
      "\"instances\":%zu,\"pairs\":%zu,\"project_ms\":%.5f,\"sort_ms\":%.5f,\"raster_ms\":%.5f,"
      "\"total_ms\":%.5f,\"wall_ms\":%.5f",
      std::string(subject.name).c_str(), view, camera.width, camera.height, counts.visible, counts.instances,
      std::size_t(counts.raster.contributing_pairs), median(project), median(sort), median(raster),
      median(total), median(wall));
}

void GpuBench::compare(const Subject& subject, const Truth& truth) {
  const Camera& camera = input_.views[truth.view];
  RenderSettings settings = settings_;
  settings.conventions = truth.conventions;
  render(subject, camera, settings);
  std::vector<float> frame(truth.colour.size());
  check_cuda(cudaMemcpy(frame.data(), colours_.data(), frame.size() * sizeof(float), cudaMemcpyDeviceToHost),
             "cudaMemcpy to the host");
  auto largest = std::async(std::launch::async, [&] { return max_abs_difference(frame, truth.colour); });
  const bool square = truth.conventions.footprint == Conventions::Footprint::three_sigma_square;
  // JSON has no infinity.
  const double db = std::min(psnr(frame, truth.colour), 999.0);
  write(
      "\"kind\":\"error\",\"renderer\":\"%s\",\"view\":%zu,\"conventions\":\"%s\",\"footprint\":\"%s\","
      "\"psnr_db\":%.3f,\"max_abs\":%.3e",
      std::string(subject.name).c_str(), truth.view, truth.preset, square ? "three-sigma-square" : "alpha",
      db, largest.get());
}

}  // namespace swiftgs::bench
