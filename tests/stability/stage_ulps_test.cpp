// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include "stability/record.hpp"

using namespace swiftgs::test;

namespace {

/// Each gate is the recorded number, which docs/conventions.md shows, so that table and gate are one. The
/// record repeats these searches with three more seeds. A twentieth and a tenth of an ulp more are left for
/// compilers, which order and fuse operations differently.
void check_against_the_record(const std::vector<Worst>& found) {
  static const Record record(SWIFTGS_ULPS_JSON);
  REQUIRE(!found.empty());
  for (const Worst& worst : found) {
    CAPTURE(worst.stage);
    CAPTURE(worst.target);
    CAPTURE(worst.at);
    const double recorded = record.ulps(worst);
    REQUIRE(recorded >= 0);
    CHECK(worst.ulps <= recorded * 1.05 + 0.1);
    CHECK(worst.ulps >= 0);
  }
}

}  // namespace

TEST_CASE("stages: the image axes of a Gaussian err no more than is recorded") {
  check_against_the_record(search_axes(1));
}

TEST_CASE("stages: projection errs no more than is recorded on any vector target") {
  check_against_the_record(search_projection(1));
}

TEST_CASE("stages: spherical harmonics err no more than is recorded on any vector target") {
  check_against_the_record(search_harmonics(1));
}

TEST_CASE("stages: the exponential errs no more than is recorded on any vector target") {
  check_against_the_record(search_exp2(1));
}

TEST_CASE(
    "stages: exponents and alphas of all rasterizers err no more than is recorded on any vector target") {
  check_against_the_record(search_alpha(1));
}

TEST_CASE("stages: transmittance errs no more than is recorded after ten to ten thousand layers") {
  check_against_the_record(search_transmittance(1));
}
