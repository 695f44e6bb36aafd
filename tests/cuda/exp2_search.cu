// SPDX-License-Identifier: Apache-2.0

// The exponential of kernels, as it is compiled for a device.
#include <swiftgs/cuda.cuh>

#include "cuda/device.hpp"
#include "exponents.hpp"
#include "stability/exp2_search.hpp"
#include "stability/ulps.hpp"

namespace swiftgs::test {

struct Exp2All {
  const float* in;
  float* out;
  SWIFTGS_HD void operator()(std::size_t i) const { out[i] = kernels::exp2_approx(in[i]); }
};

std::vector<Worst> search_exp2(int effort) {
  const Cuda cuda;
  DeviceBuffer<float> arguments, powers;
  const auto exp2 = [&](std::size_t, const float* in, std::size_t count, float* out) {
    copy_to_device(Span<const float>{in, count}, arguments);
    powers.reset(count);
    cuda.for_each(count, Exp2All{arguments.data(), powers.data()});
    cuda.download(Span<const float>{powers.data(), count}, out);
  };
  std::vector<Worst> all;
  for (const auto& worst : worst_of_exp2(1, exp2, effort))
    all.push_back({"`exp2_approx`", "ulps", "cuda", worst.ulps, text("v %.9g", double(worst.at))});
  return all;
}

}  // namespace swiftgs::test
