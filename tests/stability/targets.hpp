// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What a stage runs on: the plain functions and the Cpu backend on each vector target of the machine, or a
/// device where SWIFTGS_SEARCH_ON_DEVICE is defined. Not both in one program: a search follows the errors of
/// all its targets.

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#if defined(SWIFTGS_SEARCH_ON_DEVICE)
#include "cuda/device.hpp"
#else
#include <hwy/targets.h>

#include "policies/backends.hpp"
#include "policies/only_targets.hpp"
#include "policies/tile_lists.hpp"
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

#endif

/// The colours of a frame, where a backend writes them.
template <class B>
class FrameOn {
 public:
  FrameOn(int width, int height) : width_(width), height_(height) {
    colours_.reset(3 * std::size_t(width) * std::size_t(height));
  }
  FrameView view() {
    return {.width = width_,
            .height = height_,
            .colour = {colours_.data(), std::ptrdiff_t(3 * sizeof(float)) * width_}};
  }
  /// What was drawn, on the host.
  std::vector<float> colours(const B& backend) const {
    return to_host(backend, Span<const float>(colours_.span()));
  }

 private:
  int width_, height_;
  typename B::template Buffer<float> colours_;
};

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
  const SplatsView found = splats.view();
  return {to_host(backend, found.shapes), to_host(backend, found.depths), to_host(backend, found.gaussians),
          to_host(backend, shading.finish().each)};
}

}  // namespace swiftgs::test
