// SPDX-License-Identifier: Apache-2.0

// Frames of one and more views on a CUDA stream: `rendered` one by one, `batched` in one frame, `recorded`
// without the host, and as a `graph` that runs again after `set_views`. Times are those of a view: `host_us`
// of the host, `device_us` from the first to the last kernel of a run of frames.
#include <algorithm>
#include <array>
#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <cuda_runtime_api.h>

#include <swiftgs/cuda.hpp>
#include <swiftgs/cuda/check.hpp>
#include <swiftgs/swiftgs.hpp>

#include "stand.hpp"

namespace swiftgs::bench {
namespace {

constexpr int frames_of_run = 40;

/// A scene, and views of it one behind the other: frame k shows views k, k + 1, ... of the capture, all as
/// large as the first.
class GraphStand {
 public:
  GraphStand(const Input& input, std::size_t views) : cameras_(input.views), views_(views) {
    check_cuda(cudaStreamCreateWithFlags(&stream_, cudaStreamNonBlocking), "cudaStreamCreateWithFlags");
    for (cudaEvent_t& event : events_) check_cuda(cudaEventCreate(&event), "cudaEventCreate");
    for (Camera& camera : cameras_) camera.width = cameras_[0].width, camera.height = cameras_[0].height;
    renderer_.emplace(Cuda(stream_));
    scene_.emplace(renderer_->backend().upload(input.load()));
    const std::size_t pixels = std::size_t(cameras_[0].width) * std::size_t(cameras_[0].height);
    images_.reset(3 * pixels * views), report_.reset(1);

    // Room for all frames, which one renderer learns and another one records with.
    Capacity most;
    for (std::size_t k = 0; k < cameras_.size(); ++k) {
      batch(k);
      const Statistics counts = renderer_->statistics();
      most.splats = std::max(most.splats, counts.visible);
      // Recorded frames have tiles of half the side of those that `render_into` may have taken.
      most.intersections = std::max(most.intersections, 4 * counts.intersections);
    }
    recorder_.emplace(Cuda(stream_));
    const std::vector<View> first = views_of(0);
    recorder_->reserve(scene_->view(), {first.data(), views}, most);
    check_cuda(cudaStreamBeginCapture(stream_, cudaStreamCaptureModeThreadLocal), "cudaStreamBeginCapture");
    recorder_->record(scene_->view(), report_.data());
    cudaGraph_t graph = nullptr;
    check_cuda(cudaStreamEndCapture(stream_, &graph), "cudaStreamEndCapture");
    check_cuda(cudaGraphInstantiate(&graph_, graph, 0), "cudaGraphInstantiate");
    check_cuda(cudaGraphDestroy(graph), "cudaGraphDestroy");
  }
  ~GraphStand() {
    cudaStreamSynchronize(stream_);
    cudaGraphExecDestroy(graph_);
    for (cudaEvent_t event : events_) cudaEventDestroy(event);
    renderer_.reset(), recorder_.reset(), scene_.reset();
    cudaStreamDestroy(stream_);
  }
  GraphStand(const GraphStand&) = delete;
  GraphStand& operator=(const GraphStand&) = delete;

  void render(std::size_t k) {
    for (const View& view : views_of(k)) renderer_->render_into(scene_->view(), {&view, 1});
  }
  void batch(std::size_t k) {
    const std::vector<View> views = views_of(k);
    renderer_->render_into(scene_->view(), {views.data(), views.size()});
  }
  void record(std::size_t k) {
    set_views(k);
    recorder_->record(scene_->view(), report_.data());
  }
  void launch(std::size_t k) {
    set_views(k);
    check_cuda(cudaGraphLaunch(graph_, stream_), "cudaGraphLaunch");
  }

  /// A run of frames. Sets the manual time and the counters of `state`.
  template <class F>
  void run(benchmark::State& state, const F& frame) {
    for (std::size_t k = 0; k < cameras_.size(); ++k) frame(k);
    double host = 0, device = 0, runs = 0;
    std::size_t k = 0;
    while (state.KeepRunning()) {
      renderer_->backend().wait();
      check_cuda(cudaEventRecord(events_[0], stream_), "cudaEventRecord");
      const auto from = std::chrono::steady_clock::now();
      for (int i = 0; i < frames_of_run; ++i) frame(k++);
      const auto to = std::chrono::steady_clock::now();
      check_cuda(cudaEventRecord(events_[1], stream_), "cudaEventRecord");
      renderer_->backend().wait();
      float ms = 0;
      check_cuda(cudaEventElapsedTime(&ms, events_[0], events_[1]), "cudaEventElapsedTime");
      const double of_view = 1.0 / (frames_of_run * double(views_));
      host += std::chrono::duration<double, std::micro>(to - from).count() * of_view;
      device += 1000 * ms * of_view, ++runs;
      state.SetIterationTime(1e-3 * double(ms) * of_view);
    }
    state.counters["host_us"] = host / runs;
    state.counters["device_us"] = device / runs;
    FrameReport report;
    renderer_->backend().download(std::as_const(report_).span(), &report);
    if (report.overflowed != 0) state.SkipWithError("a recorded frame overflowed");
  }

 private:
  std::vector<View> views_of(std::size_t k) {
    std::vector<View> views;
    const std::ptrdiff_t pitch = 3 * std::ptrdiff_t(sizeof(float)) * cameras_[0].width;
    for (std::size_t v = 0; v < views_; ++v) {
      const Camera& camera = cameras_[(k + v) % cameras_.size()];
      FrameView frame{.width = camera.width, .height = camera.height};
      frame.colour = {images_.data() + v * (images_.size() / views_), pitch};
      views.push_back(make_view(camera, Conventions::gsplat(), frame));
    }
    return views;
  }
  void set_views(std::size_t k) {
    const std::vector<View> views = views_of(k);
    recorder_->set_views({views.data(), views.size()});
  }

  std::vector<Camera> cameras_;
  std::size_t views_;
  cudaStream_t stream_ = nullptr;
  cudaGraphExec_t graph_ = nullptr;
  std::array<cudaEvent_t, 2> events_{};
  std::optional<DeviceScene> scene_;
  DeviceBuffer<float> images_;
  DeviceBuffer<FrameReport> report_;
  std::optional<Renderer<Cuda>> renderer_, recorder_;
};

}  // namespace

void add_benchmarks(Stand&, const Input& input) {
  if (!Cuda::usable()) return;
  for (const std::size_t views : {1, 2, 4, 16}) {
    const auto stand = std::make_shared<std::unique_ptr<GraphStand>>();  // made when a benchmark of it runs
    const auto add = [&](const char* what, void (GraphStand::*frame)(std::size_t)) {
      const std::string name =
          std::string(what) + "/" + input.name + "/" + input.size() + "/" + std::to_string(views);
      benchmark::RegisterBenchmark(name.c_str(),
                                   [=](benchmark::State& state) {
                                     if (!*stand) *stand = std::make_unique<GraphStand>(input, views);
                                     (*stand)->run(state, [&](std::size_t k) { ((**stand).*frame)(k); });
                                   })
          ->UseManualTime()
          ->Unit(benchmark::kMillisecond);
    };
    add("rendered", &GraphStand::render), add("batched", &GraphStand::batch);
    add("recorded", &GraphStand::record), add("graph", &GraphStand::launch);
  }
}

}  // namespace swiftgs::bench
