// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdio>
#include <functional>
#include <memory>
#include <regex>
#include <string>
#include <string_view>
#include <vector>

#include <swiftgs/cuda.hpp>
#include <swiftgs/renderer.hpp>

#include "inputs.hpp"

namespace swiftgs::bench {

/// What `gpu_frames` was asked for.
struct GpuOptions {
  std::string out;
  int frames = 15;       ///< timed for each view
  int views = 1 << 30;   ///< of a scene, at most
  int compared = 3;      ///< views that are compared with the reference
  bool profile = false;  ///< render one more frame of the first view, between marks that a profiler looks for
  std::regex renderers{".*"};  ///< which
  std::vector<std::string> scenes;
};

/// Measures renderers, one after another, on one scene. Frames are rendered to one place on the GPU.
class GpuBench {
 public:
  /// Loads the scene and renders what frames are compared with. Writes a line about the scene to `out`.
  GpuBench(const GpuOptions& options, const Input& input, std::FILE* out);

  /// Writes the times of every view, the memory that is in use after them, and errors, a line each. Does
  /// nothing for a renderer that was not asked for.
  template <class Sort, class Raster, class Bounds>
  void measure() {
    using R = Renderer<Cuda, Sort, Raster, Bounds>;
    if (!std::regex_search(std::string(R::name), options_.renderers)) return;
    R renderer;
    measure(Subject{R::name,
                    [&](const Camera& camera, const RenderSettings& settings, const FrameView& frame) {
                      renderer.render_into(on_device_->view(), camera, settings, frame);
                    },
                    [&] { return renderer.times(); }, [&] { return renderer.statistics(); }});
  }

 private:
  /// What can be done with a renderer, whatever its policies.
  struct Subject {
    std::string_view name;
    std::function<void(const Camera&, const RenderSettings&, const FrameView&)> render;
    std::function<StageTimes()> times;
    std::function<Statistics()> statistics;
  };

  /// A float64 frame.
  struct Truth {
    std::size_t view;
    const char* preset;
    Conventions conventions;
    std::vector<double> colour;
  };

  /// One line of JSON, which names the scene.
  template <class... Values>
  void write(const char* format, Values... values);
  void find_truths();

  /// Renders a frame and waits for it. Returns how long that took. @units{milliseconds}
  double render(const Subject& subject, const Camera& camera, const RenderSettings& settings);
  void measure(const Subject& subject);
  void time(const Subject& subject, std::size_t view);
  void compare(const Subject& subject, const Truth& truth);

  const GpuOptions& options_;
  Input input_;
  std::FILE* out_;
  Scene scene_;
  std::size_t empty_ = 0;
  std::unique_ptr<Cuda::SceneOn> on_device_;
  RenderSettings settings_;
  DeviceBuffer<float> colours_;
  std::vector<Truth> truths_;
};

}  // namespace swiftgs::bench
