// SPDX-License-Identifier: Apache-2.0

// The loops that sort out splats for ranks, for all bounds of the library.
#include <tuple>

#include <swiftgs/bounds/all.hpp>
#include <swiftgs/cuda.cuh>
#include <swiftgs/mpi/packing.hpp>

namespace swiftgs {
namespace {

template <class F>
using Loop = void (Cuda::*)(Count, const F&) const;

template <class... F>
std::tuple<Loop<F>...> loops_of(TypeList<F...>) {
  return {&Cuda::for_each<F>...};
}

template <class... Bounds>
auto loops_within(TypeList<Bounds...>) {
  return std::tuple_cat(loops_of(PackLoops{}),
                        loops_of(TypeList<CountForBands<Bounds>, ListForBands<Bounds>>{})...);
}

/// An explicit instantiation cannot follow a list; taking addresses can.
[[gnu::used]] const auto instantiated = loops_within(AllBounds{});

}  // namespace
}  // namespace swiftgs
