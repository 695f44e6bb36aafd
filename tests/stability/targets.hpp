// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What a stage runs on: the plain functions and the Cpu backend on each vector target of the machine, or a
/// device where SWIFTGS_SEARCH_ON_DEVICE is defined. Not both in one program: a search follows the errors of
/// all its targets.

#include <cstddef>
#include <cstdint>
#include <string>
#include <type_traits>
#include <vector>

#if defined(SWIFTGS_SEARCH_ON_DEVICE)
#include "cuda/device.hpp"
#else
#include <hwy/targets.h>

#include "policies/backends.hpp"
#include "policies/only_targets.hpp"
#endif

namespace swiftgs::test {

#if defined(SWIFTGS_SEARCH_ON_DEVICE)

class Targets {
 public:
  std::size_t size() const { return 1; }
  std::string name(std::size_t) const { return "cuda"; }
  template <class F>
  void on(std::size_t, const F& f) {
    f(cuda_);
  }

 private:
  Cuda cuda_;
};

/// An array of the host where kernels reach it.
template <class T>
class Reachable {
 public:
  explicit Reachable(const std::vector<T>& host) : device_(to_device(host)) {}
  Span<const T> span() const { return device_.span(); }

 private:
  DeviceBuffer<T> device_;
};

/// The colours of a frame where kernels write them.
class ReachableFrame {
 public:
  ReachableFrame(int width, int height) : width_(width), height_(height) {
    colours_.resize(3 * std::size_t(width) * std::size_t(height));
    device_.reset(colours_.size());
  }
  FrameView view() {
    return {.width = width_,
            .height = height_,
            .colour = {device_.data(), std::ptrdiff_t(3 * sizeof(float)) * width_}};
  }
  /// What was drawn, on the host.
  const std::vector<float>& colours(const Cuda& cuda) {
    cuda.download(Span<const float>(device_.span()), colours_.data());
    return colours_;
  }

 private:
  int width_, height_;
  std::vector<float> colours_;
  DeviceBuffer<float> device_;
};

#else

/// Target 0 is `serial`; the others are those that Highway chooses among.
class Targets {
 public:
  Targets() {
    for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) vector_.push_back(target);
  }

  std::size_t size() const { return 1 + vector_.size(); }
  std::string name(std::size_t i) const {
    return i == 0 ? "serial" : std::string("cpu ") + hwy::TargetName(vector_[i - 1]);
  }

  /// Calls f(backend) with the backend of target `i`.
  template <class F>
  void on(std::size_t i, const F& f) {
    if (i == 0) return f(serial_);
    const OnlyTargets only(vector_[i - 1]);
    f(cpu_);
  }

 private:
  Serial serial_;
  Cpu cpu_{1};
  std::vector<std::int64_t> vector_;
};

template <class T>
class Reachable {
 public:
  explicit Reachable(const std::vector<T>& host) : host_(host) {}
  Span<const T> span() const { return {host_.data(), host_.size()}; }

 private:
  const std::vector<T>& host_;
};

class ReachableFrame {
 public:
  ReachableFrame(int width, int height) : view_(prepare(frame_, width, height, {false, false})) {}
  FrameView view() { return view_; }
  template <class B>
  const std::vector<float>& colours(const B&) const {
    return frame_.colour;
  }

 private:
  Frame frame_;
  FrameView view_;
};

#endif

/// Splats of a scene and their colours, on the host.
struct Projected {
  std::vector<SplatShape> shapes;
  std::vector<float> depths;
  std::vector<std::uint32_t> gaussians;
  std::vector<SplatColour> colours;
};

/// Projects and shades.
template <class B>
Projected project_to_host(B& backend, const View& view, const Scene& scene) {
  const auto uploaded = backend.upload(scene);
  const FramePlan plan({&view, 1}, uploaded.view());
  ProjectScratch<B> scratch;
  Splats<B> splats;
  Footprints<B> footprints;
  Colours<B> colours;
  project(backend, plan, Ellipse(), scratch, splats, footprints);
  Shading<B> shading = shade(backend, plan, splats, colours);
  bin(backend, plan, Ellipse(), splats, footprints);
  const auto to_host = [&]<class T>(Span<const T> from) {
    std::vector<T> to(from.size);
    backend.download(from, to.data());
    return to;
  };
  const SplatsView found = splats.view();
  return {to_host(found.shapes), to_host(found.depths), to_host(found.gaussians),
          to_host(shading.finish().each)};
}

}  // namespace swiftgs::test
