// SPDX-License-Identifier: Apache-2.0
#include "read/convert_result.hpp"

#include <cinttypes>
#include <cstdio>
#include <string>

#include "json.hpp"

namespace swiftgs::cli {
namespace {

Json json_of(const ConvertedFile& file) {
  return {{"file", file.name},     {"file_format", file.format},         {"bytes", file.bytes},
          {"stored", file.stored}, {"gaussians", file.gaussians},        {"sh_degree", file.sh_degree},
          {"model", file.model},   {"seconds", rounded(file.seconds, 4)}};
}

Json json_of(const LargestLosses& losses) {
  return {{"position", rounded(losses.position, 6)},
          {"gaussian", losses.position > 0 ? Json(losses.gaussian) : Json()},
          {"displaced", losses.displaced},
          {"scale_factor", rounded(losses.scale, 6)},
          {"opacity", rounded(losses.opacity, 6)},
          {"colour", rounded(losses.colour, 6)}};
}

void print_file(const char* verb, const ConvertedFile& file) {
  std::printf("%-10s %10zu %10" PRIu64 " %6d %12" PRIu64 " %8.2f  %s, %s\n", verb, file.gaussians,
              file.stored - file.gaussians, file.sh_degree, file.bytes, file.seconds, file.name.c_str(),
              file.format.c_str());
}

}  // namespace

std::string to_json(const ConvertResult& result) {
  Json json{{"inputs", Json::array()}, {"steps", Json::array()}, {"output", json_of(result.output)}};
  json["output"]["losses"] = json_of(result.losses);
  for (const ConvertedFile& input : result.inputs) json["inputs"].push_back(json_of(input));
  for (const ConvertStep& step : result.steps)
    json["steps"].push_back(
        {{"what", step.what}, {"gaussians", step.gaussians}, {"sh_degree", step.sh_degree}});
  return document_of(result.head, members_of(json));
}

void print_table(const ConvertResult& result) {
  std::printf("%-10s %10s %10s %6s %12s %8s\n", "", "Gaussians", "left out", "degree", "bytes", "seconds");
  std::size_t before = 0;
  for (const ConvertedFile& input : result.inputs) print_file("read", input), before += input.gaussians;
  for (const ConvertStep& step : result.steps) {
    std::printf("%-10s %10zu %10zu %6d %12s %8s  %s\n", "edited", step.gaussians, before - step.gaussians,
                step.sh_degree, "", "", step.what.c_str());
    before = step.gaussians;
  }
  print_file("written", result.output);
  if (const std::string losses = text_of(result.losses); !losses.empty())
    std::printf("%-10s at most: %s\n", "rounded", losses.c_str());
}

}  // namespace swiftgs::cli
