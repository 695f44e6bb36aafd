// SPDX-License-Identifier: Apache-2.0

// The stages that know of bounds, for all bounds of the library. <swiftgs/cuda.cuh> has the same three for
// bounds of the caller.
#include <cstdint>
#include <tuple>

#include <swiftgs/bounds/all.hpp>
#include <swiftgs/cuda/intersections.cuh>
#include <swiftgs/cuda/project.cuh>
#include <swiftgs/cuda/stages.hpp>

namespace swiftgs {

template <BoundsPolicy Bounds>
void project(Cuda& cuda, const FramePlan& plan, const Bounds& bounds, ProjectScratch<Cuda>& scratch,
             Splats<Cuda>& splats, Footprints<Cuda>& footprints) {
  kernels::run_project(cuda, plan, bounds, scratch, splats, footprints);
}

template <BoundsPolicy Bounds>
void bin(Cuda& cuda, const FramePlan& plan, const Bounds& bounds, Splats<Cuda>& splats,
         Footprints<Cuda>& footprints) {
  kernels::run_bin(cuda, plan, bounds, splats, footprints);
}

template <BoundsPolicy Bounds, class Key>
Count emit_intersections(Cuda& cuda, const SortJob& job, const Bounds& bounds, const std::uint32_t* order,
                         IntersectionScratch<Cuda>& scratch, Pairs<Cuda, Key>& intersections) {
  return kernels::run_emission(cuda, job, bounds, order, scratch, intersections);
}

namespace {

template <class Bounds, class Key>
using Emission = Count (*)(Cuda&, const SortJob&, const Bounds&, const std::uint32_t*,
                           IntersectionScratch<Cuda>&, Pairs<Cuda, Key>&);

template <class Bounds>
struct StagesWithin {
  void (*project)(Cuda&, const FramePlan&, const Bounds&, ProjectScratch<Cuda>&, Splats<Cuda>&,
                  Footprints<Cuda>&) = &swiftgs::project;
  void (*bin)(Cuda&, const FramePlan&, const Bounds&, Splats<Cuda>&, Footprints<Cuda>&) = &swiftgs::bin;
  Emission<Bounds, std::uint16_t> emit_narrow = &emit_intersections;
  Emission<Bounds, std::uint32_t> emit_wide = &emit_intersections;
  Emission<Bounds, std::uint64_t> emit_with_depth = &emit_intersections;
};

template <class... Bounds>
std::tuple<StagesWithin<Bounds>...> stages_within(TypeList<Bounds...>) {
  return {};
}

/// An explicit instantiation cannot follow a list; taking addresses can.
[[gnu::used]] const auto instantiated = stages_within(AllBounds{});

}  // namespace
}  // namespace swiftgs
