// SPDX-License-Identifier: Apache-2.0
#include <swiftgs/mpi/cuda.hpp>

namespace swiftgs {

std::unique_ptr<DirectLink> direct_link(const Ranks&, Cuda&) { return nullptr; }

}  // namespace swiftgs
