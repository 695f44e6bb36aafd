// SPDX-License-Identifier: Apache-2.0
#include <cstdint>

#include <swiftgs/bounds/three_sigma_square.hpp>
#include <swiftgs/cuda.cuh>

namespace swiftgs {

template void project(Cuda&, const ProjectJob&, const ThreeSigmaSquare&, ProjectScratch<Cuda>&, Splats<Cuda>&,
                      Footprints<Cuda, ThreeSigmaSquare>&);
template std::size_t emit_instances(Cuda&, const SortJob<ThreeSigmaSquare>&, const ThreeSigmaSquare&,
                                    const std::uint32_t*, InstanceScratch<Cuda>&,
                                    Pairs<Cuda, std::uint16_t>&);
template std::size_t emit_instances(Cuda&, const SortJob<ThreeSigmaSquare>&, const ThreeSigmaSquare&,
                                    const std::uint32_t*, InstanceScratch<Cuda>&,
                                    Pairs<Cuda, std::uint32_t>&);
template std::size_t emit_instances(Cuda&, const SortJob<ThreeSigmaSquare>&, const ThreeSigmaSquare&,
                                    const std::uint32_t*, InstanceScratch<Cuda>&,
                                    Pairs<Cuda, std::uint64_t>&);

}  // namespace swiftgs
