// SPDX-License-Identifier: Apache-2.0
#include <cstddef>

#include <swiftgs/contribution.hpp>
#include <swiftgs/cuda.cuh>

namespace swiftgs {

// Loops of `Contributions`, compiled as projection is: both must see the same Gaussians.
template void Cuda::for_each(std::size_t, const ClearSums&) const;
template void Cuda::for_each(std::size_t, const ProjectShapes&) const;
template void Cuda::for_each(std::size_t, const KeepVisible&) const;
template void Cuda::for_each(std::size_t, const HideSplats&) const;

}  // namespace swiftgs
