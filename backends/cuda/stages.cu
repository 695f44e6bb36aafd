// SPDX-License-Identifier: Apache-2.0

// The stages that know of bounds, for all bounds of the library. <swiftgs/cuda.cuh> has the same three for
// bounds of the caller.
#include <cstdint>
#include <tuple>

#include <swiftgs/cuda.cuh>

namespace swiftgs {

template <BoundsPolicy Bounds>
void project(Cuda& cuda, const FrameInput& input, const Bounds& bounds, ProjectScratch<Cuda>& scratch,
             Splats<Cuda>& splats, Footprints<Cuda, Bounds>& footprints) {
  kernels::run_project(cuda, input, bounds, scratch, splats, footprints);
}

template <BoundsPolicy Bounds>
void bin(Cuda& cuda, const Views& views, const Bounds& bounds, Splats<Cuda>& splats,
         Footprints<Cuda, Bounds>& footprints, const Limits& limits) {
  kernels::run_bin(cuda, views, bounds, splats, footprints, limits);
}

template <BoundsPolicy Bounds, class Key>
Count emit_instances(Cuda& cuda, const SortJob<Bounds>& job, const Bounds& bounds, const std::uint32_t* order,
                     InstanceScratch<Cuda>& scratch, Pairs<Cuda, Key>& instances) {
  return kernels::run_emission(cuda, job, bounds, order, scratch, instances);
}

namespace {

template <class Bounds, class Key>
using Emission = Count (*)(Cuda&, const SortJob<Bounds>&, const Bounds&, const std::uint32_t*,
                           InstanceScratch<Cuda>&, Pairs<Cuda, Key>&);

template <class Bounds>
struct Stages {
  void (*project)(Cuda&, const FrameInput&, const Bounds&, ProjectScratch<Cuda>&, Splats<Cuda>&,
                  Footprints<Cuda, Bounds>&) = &swiftgs::project;
  void (*bin)(Cuda&, const Views&, const Bounds&, Splats<Cuda>&, Footprints<Cuda, Bounds>&,
              const Limits&) = &swiftgs::bin;
  Emission<Bounds, std::uint16_t> emit_narrow = &emit_instances;
  Emission<Bounds, std::uint32_t> emit_wide = &emit_instances;
  Emission<Bounds, std::uint64_t> emit_with_depth = &emit_instances;
};

template <class... Bounds>
std::tuple<Stages<Bounds>...> stages_within(TypeList<Bounds...>) {
  return {};
}

/// An explicit instantiation cannot follow a list; taking addresses can.
[[gnu::used]] const auto instantiated = stages_within(AllBounds{});

}  // namespace
}  // namespace swiftgs
