// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Definitions behind `<swiftgs/cuda.hpp>` for code that nvcc compiles: loops over functors, bounds and
/// rasterizers of your own. Compile with `-fmad=false` what instantiates `project` or `emit_instances`: tiles
/// are counted by one kernel and emitted by another, and both must round alike.

#include <swiftgs/bounds/ellipse.hpp>
#include <swiftgs/bounds/opacity_box.hpp>
#include <swiftgs/bounds/three_sigma_square.hpp>
#include <swiftgs/cuda.hpp>
#include <swiftgs/cuda/for_each.cuh>
#include <swiftgs/cuda/instances.cuh>
#include <swiftgs/cuda/project.cuh>

namespace swiftgs {

// Compiled into the library, with the flag that they need.
extern template void project(Cuda&, const ProjectJob&, const ThreeSigmaSquare&, ProjectScratch<Cuda>&,
                             Splats<Cuda>&, Footprints<Cuda, ThreeSigmaSquare>&);
extern template std::size_t emit_instances(Cuda&, const SortJob<ThreeSigmaSquare>&, const ThreeSigmaSquare&,
                                           const std::uint32_t*, InstanceScratch<Cuda>&,
                                           Pairs<Cuda, std::uint16_t>&);
extern template std::size_t emit_instances(Cuda&, const SortJob<ThreeSigmaSquare>&, const ThreeSigmaSquare&,
                                           const std::uint32_t*, InstanceScratch<Cuda>&,
                                           Pairs<Cuda, std::uint32_t>&);
extern template std::size_t emit_instances(Cuda&, const SortJob<ThreeSigmaSquare>&, const ThreeSigmaSquare&,
                                           const std::uint32_t*, InstanceScratch<Cuda>&,
                                           Pairs<Cuda, std::uint64_t>&);
extern template void project(Cuda&, const ProjectJob&, const OpacityBox&, ProjectScratch<Cuda>&,
                             Splats<Cuda>&, Footprints<Cuda, OpacityBox>&);
extern template std::size_t emit_instances(Cuda&, const SortJob<OpacityBox>&, const OpacityBox&,
                                           const std::uint32_t*, InstanceScratch<Cuda>&,
                                           Pairs<Cuda, std::uint16_t>&);
extern template std::size_t emit_instances(Cuda&, const SortJob<OpacityBox>&, const OpacityBox&,
                                           const std::uint32_t*, InstanceScratch<Cuda>&,
                                           Pairs<Cuda, std::uint32_t>&);
extern template std::size_t emit_instances(Cuda&, const SortJob<OpacityBox>&, const OpacityBox&,
                                           const std::uint32_t*, InstanceScratch<Cuda>&,
                                           Pairs<Cuda, std::uint64_t>&);
extern template void project(Cuda&, const ProjectJob&, const Ellipse&, ProjectScratch<Cuda>&, Splats<Cuda>&,
                             Footprints<Cuda, Ellipse>&);
extern template std::size_t emit_instances(Cuda&, const SortJob<Ellipse>&, const Ellipse&,
                                           const std::uint32_t*, InstanceScratch<Cuda>&,
                                           Pairs<Cuda, std::uint16_t>&);
extern template std::size_t emit_instances(Cuda&, const SortJob<Ellipse>&, const Ellipse&,
                                           const std::uint32_t*, InstanceScratch<Cuda>&,
                                           Pairs<Cuda, std::uint32_t>&);
extern template std::size_t emit_instances(Cuda&, const SortJob<Ellipse>&, const Ellipse&,
                                           const std::uint32_t*, InstanceScratch<Cuda>&,
                                           Pairs<Cuda, std::uint64_t>&);

}  // namespace swiftgs
