// SPDX-License-Identifier: Apache-2.0
#define DOCTEST_CONFIG_IMPLEMENT
#include <optional>

#include <doctest/doctest.h>

#include "mpi/ranks_here.hpp"
#include "support/skip.hpp"

namespace swiftgs::test {
namespace {
constexpr int exit_skipped = 77;  // SKIP_RETURN_CODE of every test
std::optional<Ranks> started;
bool skipped = false;
}  // namespace

Ranks& ranks_here() { return *started; }

void skip(const std::string& reason) {
  skipped = true;
  MESSAGE("skipped: ", reason);
}
}  // namespace swiftgs::test

/// Runs the tests on all ranks at once: each goes through all of them, in the same order. A program whose
/// tests cannot run here is skipped as a whole.
int main(int argc, char** argv) {
  using namespace swiftgs::test;
  return swiftgs::run_on_ranks("test", [&](swiftgs::Ranks& ranks) {
    started.emplace(ranks);
    doctest::Context context(argc, argv);
    context.setOption("no-intro", ranks.rank() != 0);
    const int failed = context.run();
    // One rank that fails is enough, and all end with the same code.
    const bool passed = ranks.all(failed == 0);
    started.reset();
    return !passed ? 1 : skipped ? exit_skipped : 0;
  });
}
