// SPDX-License-Identifier: Apache-2.0
#include <cstdint>

#include <swiftgs/bounds/ellipse.hpp>
#include <swiftgs/cuda.cuh>

namespace swiftgs {

template void project(Cuda&, const ProjectJob&, const Ellipse&, ProjectScratch<Cuda>&, Splats<Cuda>&,
                      Footprints<Cuda, Ellipse>&);
template std::size_t emit_instances(Cuda&, const SortJob<Ellipse>&, const Ellipse&, const std::uint32_t*,
                                    InstanceScratch<Cuda>&, Pairs<Cuda, std::uint16_t>&);
template std::size_t emit_instances(Cuda&, const SortJob<Ellipse>&, const Ellipse&, const std::uint32_t*,
                                    InstanceScratch<Cuda>&, Pairs<Cuda, std::uint32_t>&);
template std::size_t emit_instances(Cuda&, const SortJob<Ellipse>&, const Ellipse&, const std::uint32_t*,
                                    InstanceScratch<Cuda>&, Pairs<Cuda, std::uint64_t>&);

}  // namespace swiftgs
