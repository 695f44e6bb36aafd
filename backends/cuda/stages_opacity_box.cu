// SPDX-License-Identifier: Apache-2.0
#include <cstdint>

#include <swiftgs/bounds/opacity_box.hpp>
#include <swiftgs/cuda.cuh>

namespace swiftgs {

template void project(Cuda&, const ProjectJob&, const OpacityBox&, ProjectScratch<Cuda>&, Splats<Cuda>&,
                      Footprints<Cuda, OpacityBox>&);
template std::size_t emit_instances(Cuda&, const SortJob<OpacityBox>&, const OpacityBox&,
                                    const std::uint32_t*, InstanceScratch<Cuda>&,
                                    Pairs<Cuda, std::uint16_t>&);
template std::size_t emit_instances(Cuda&, const SortJob<OpacityBox>&, const OpacityBox&,
                                    const std::uint32_t*, InstanceScratch<Cuda>&,
                                    Pairs<Cuda, std::uint32_t>&);
template std::size_t emit_instances(Cuda&, const SortJob<OpacityBox>&, const OpacityBox&,
                                    const std::uint32_t*, InstanceScratch<Cuda>&,
                                    Pairs<Cuda, std::uint64_t>&);

}  // namespace swiftgs
