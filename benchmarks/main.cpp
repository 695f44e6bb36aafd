// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <exception>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>

#include <swiftgs/version.hpp>

#include "inputs.hpp"
#include "stand.hpp"

int main(int argc, char** argv) {
  using namespace swiftgs;
  try {
    benchmark::Initialize(&argc, argv);
    // What Google Benchmark has left of the arguments names scenes.
    const std::vector<std::string> names(argv + 1, argv + argc);
    bench::Stand stand;
    // Scene by scene, so that each is loaded once.
    for (const bench::Input& input : bench::inputs_named(names)) bench::add_benchmarks(stand, input);

    benchmark::AddCustomContext("compiler", __VERSION__);
    benchmark::AddCustomContext("swiftgs", std::string(version));
    const std::size_t ran = benchmark::RunSpecifiedBenchmarks();
    return ran == 0 || stand.failed() ? 1 : 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "benchmarks: %s\n", error.what());
    return 1;
  }
}
