// SPDX-License-Identifier: Apache-2.0
#include <cstddef>
#include <cstdint>
#include <vector>

#include <doctest/doctest.h>

#include <swiftgs/pick.hpp>

using namespace swiftgs;

namespace {

/// Offers Gaussians with these alphas, at depths 1, 2, ..., whose indices count down to 0, until no more is
/// wanted. Binary fractions keep all arithmetic exact.
PickedPixel pick_of(const std::vector<float>& alphas, float stop_below = 0) {
  PixelPicker picker(stop_below);
  for (std::size_t i = 0; i < alphas.size(); ++i)
    if (!picker.offer(alphas[i], float(i + 1), std::uint32_t(alphas.size() - 1 - i))) break;
  return picker.picked();
}

}  // namespace

TEST_CASE("pick: the largest weight wins and of equal ones the nearest") {
  CHECK(pick_of({}) == PickedPixel());
  CHECK(pick_of({0.25f, 0.5f, 0.125f}) == PickedPixel{1, 0.375f, 2, 1, 2});
  CHECK(pick_of({0.5f, 1}) == PickedPixel{1, 0.5f, 1, 0, 2});
  CHECK(pick_of({0.25f, 0.5f, 1}) == PickedPixel{1, 0.375f, 2, 1, 2});  // the third takes all that is left
  CHECK(pick_of({0.25f, 0.375f, 1}) == PickedPixel{0, 0.46875f, 3, 1, 2});
}

TEST_CASE("pick: the median takes the transmittance below one half and not to it") {
  CHECK(pick_of({0.5f}).median == PickedPixel::nothing);
  CHECK(pick_of({0.5f, 0.0625f, 0.9375f}) == PickedPixel{2, 0.5f, 1, 1, 2});
}

TEST_CASE("pick: a pixel stops as it does when it is drawn") {
  CHECK(pick_of({0.25f, 0.75f}, 0.1875f) == PickedPixel{0, 0.5625f, 2, 0, 2});
  CHECK(pick_of({0.25f, 0.75f}, 0.25f) == PickedPixel{1, 0.25f, 1});
}
