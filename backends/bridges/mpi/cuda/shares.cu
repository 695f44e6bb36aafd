// SPDX-License-Identifier: Apache-2.0

// What a device does for ranks, for all bounds of the library. <swiftgs/mpi/cuda.cuh> has it for bounds of
// the caller.
#include <tuple>

#include <swiftgs/bounds/all.hpp>
#include <swiftgs/mpi/cuda.cuh>

namespace swiftgs {

template <BoundsPolicy Bounds>
void share_out(Cuda& cuda, const FramePlan& plan, const Bounds& bounds, const StripCuts& cuts,
               Splats<Cuda>& splats, Footprints<Cuda>& footprints, Shares<Cuda>& shares) {
  kernels::run_share_out(cuda, plan, bounds, cuts, splats, footprints, shares);
}

namespace {

template <class F>
using Loop = void (Cuda::*)(Count, const F&) const;
template <class Bounds>
using ShareOut = void (*)(Cuda&, const FramePlan&, const Bounds&, const StripCuts&, Splats<Cuda>&,
                          Footprints<Cuda>&, Shares<Cuda>&);

template <class... F>
std::tuple<Loop<F>...> loops_of(TypeList<F...>) {
  return {&Cuda::for_each<F>...};
}
template <class... Bounds>
std::tuple<ShareOut<Bounds>...> shares_within(TypeList<Bounds...>) {
  return {&share_out<Bounds>...};
}

/// An explicit instantiation cannot follow a list; taking addresses can.
[[gnu::used]] const auto instantiated = std::tuple_cat(loops_of(ExchangeLoops{}), shares_within(AllBounds{}));

}  // namespace
}  // namespace swiftgs
