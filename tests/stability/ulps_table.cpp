// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <string_view>

#include <nlohmann/json.hpp>

#include "stability/ulps.hpp"

#if defined(SWIFTGS_SEARCH_ON_DEVICE)
#include <swiftgs/cuda.hpp>
#else
#include <hwy/highway.h>
#endif

using namespace swiftgs::test;

namespace {

#if defined(SWIFTGS_SEARCH_ON_DEVICE)
constexpr const char* program = "cuda_ulps_table";
#else
constexpr const char* program = "ulps_table";
#endif

std::vector<Worst> all(int effort) {
  std::vector<Worst> rows;
  for (const auto search :
       {search_projection, search_harmonics, search_exp2, search_alpha, search_transmittance})
    for (const Worst& row : rows_of_targets(search(effort))) rows.push_back(row);
  return rows;
}

#if !defined(SWIFTGS_SEARCH_ON_DEVICE)
/// A search follows the errors of all targets of a machine, so machines without AVX-512 find others.
void add_those_without_avx3(std::vector<Worst>& rows, int effort) {
  hwy::DisableTargets(HWY_AVX3 | HWY_AVX3_DL);
  for (const Worst& other : all(effort)) {
    const auto same = [&](const Worst& row) {
      return row.stage == other.stage && row.target == other.target;
    };
    const auto row = std::find_if(rows.begin(), rows.end(), same);
    if (row != rows.end() && other.ulps > row->ulps) *row = other;
  }
}
#endif

void print_markdown(const std::vector<Worst>& rows) {
  std::cout << "| stage | yardstick | target | worst | at |\n| --- | --- | --- | ---: | --- |\n";
  for (const Worst& row : rows)
    std::cout << "| " << row.stage << " | " << row.yardstick << " | " << row.target << " | "
              << text("%.2f", row.ulps) << " | " << row.at << " |\n";
}

/// `machine` is what benchmarks/describe_machine.sh prints.
void print_json(const std::vector<Worst>& rows, const nlohmann::ordered_json& machine) {
  std::cout << "{\n \"format\": \"swiftgs-bench\",\n \"version\": 1,\n \"machine\": " << machine.dump()
            << ",\n \"command\": \"" << program << " --json\",\n \"rows\": [";
  const char* separator = "\n  ";
  for (const Worst& row : rows) {
    nlohmann::ordered_json json;
    json["stage"] = row.stage, json["target"] = row.target;
    json["ulps"] = std::strtod(text("%.4f", row.ulps).c_str(), nullptr);
    json["yardstick"] = row.yardstick, json["at"] = row.at;
    std::cout << separator << json.dump();
    separator = ",\n  ";
  }
  std::cout << "\n ]\n}\n";
}

}  // namespace

/// ulps_table [--json MACHINE.json] [EFFORT]: the largest error of every stage. EFFORT repeats
/// the searches; 1 is what the tests run, 4 what is recorded.
int main(int argc, char** argv) {
#if defined(SWIFTGS_SEARCH_ON_DEVICE)
  if (!swiftgs::Cuda::usable()) {
    std::cerr << "cuda_ulps_table: expected a device that the kernels of this build run on\n";
    return 1;
  }
#endif
  nlohmann::ordered_json machine;
  int effort = 4;
  for (int i = 1; i < argc; ++i) {
    if (std::string_view(argv[i]) == "--json" && i + 1 < argc) {
      std::ifstream file(argv[++i]);
      machine = nlohmann::ordered_json::parse(file, nullptr, false);
    } else {
      effort = std::atoi(argv[i]);
    }
  }
  if (effort < 1 || machine.is_discarded()) {
    std::cerr
        << "usage: ulps_table [--json MACHINE.json] [EFFORT]; expected what describe_machine.sh prints and "
           "an effort of 1 or more\n";
    return 2;
  }
  std::vector<Worst> rows = all(effort);
#if !defined(SWIFTGS_SEARCH_ON_DEVICE)
  add_those_without_avx3(rows, effort);
#endif
  machine.is_null() ? print_markdown(rows) : print_json(rows, machine);
}
