// SPDX-License-Identifier: Apache-2.0
#include "instances.hpp"

namespace swiftgs {

template <VectorBounds Bounds>
std::size_t emit_instances(Cpu& cpu, const SortJob<Bounds>& job, const Bounds& bounds,
                           const std::uint32_t* order, InstanceScratch<Cpu>& scratch,
                           Pairs<Cpu, std::uint64_t>& instances) {
  return emit_footprints(cpu, job, bounds, order, scratch, instances);
}

template <VectorBounds Bounds>
void group_by_tile(Cpu& cpu, const SortJob<Bounds>& job, const Bounds& bounds, const std::uint32_t* order,
                   GroupScratch<Cpu>& scratch, TileLists<Cpu>& lists) {
  group_footprints(cpu, job, bounds, order, scratch, lists);
}

template std::size_t emit_instances(Cpu&, const SortJob<ThreeSigmaSquare>&, const ThreeSigmaSquare&,
                                    const std::uint32_t*, InstanceScratch<Cpu>&, Pairs<Cpu, std::uint64_t>&);
template void group_by_tile(Cpu&, const SortJob<ThreeSigmaSquare>&, const ThreeSigmaSquare&,
                            const std::uint32_t*, GroupScratch<Cpu>&, TileLists<Cpu>&);
template std::size_t emit_instances(Cpu&, const SortJob<OpacityBox>&, const OpacityBox&, const std::uint32_t*,
                                    InstanceScratch<Cpu>&, Pairs<Cpu, std::uint64_t>&);
template void group_by_tile(Cpu&, const SortJob<OpacityBox>&, const OpacityBox&, const std::uint32_t*,
                            GroupScratch<Cpu>&, TileLists<Cpu>&);
template std::size_t emit_instances(Cpu&, const SortJob<Ellipse>&, const Ellipse&, const std::uint32_t*,
                                    InstanceScratch<Cpu>&, Pairs<Cpu, std::uint64_t>&);
template void group_by_tile(Cpu&, const SortJob<Ellipse>&, const Ellipse&, const std::uint32_t*,
                            GroupScratch<Cpu>&, TileLists<Cpu>&);

}  // namespace swiftgs
