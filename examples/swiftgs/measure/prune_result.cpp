// SPDX-License-Identifier: Apache-2.0
#include "measure/prune_result.hpp"

#include <cstdio>

#include "json_text.hpp"

namespace swiftgs::cli {
namespace {

Json json_of(const std::optional<double>& value) { return value ? Json(*value) : Json(); }

Json json_of(const PruneSide& side) {
  return {{"gaussians", side.gaussians},
          {"ms", json_of(side.ms)},
          {"photo_psnr_db", json_of(side.photo_psnr_db)},
          {"photo_ssim", json_of(side.photo_ssim)},
          {"unpruned_psnr_db", json_of(side.unpruned_psnr_db)}};
}

void print_row(const char* name, const PruneSide& side) {
  std::printf("%-8s %10zu", name, side.gaussians);
  if (side.ms) std::printf(" %10.2f", *side.ms);
  if (side.photo_psnr_db) std::printf(" %9.2f", *side.photo_psnr_db);
  if (side.photo_ssim) std::printf(" %11.4f", *side.photo_ssim);
  if (side.unpruned_psnr_db) std::printf(" %12.2f", *side.unpruned_psnr_db);
  std::printf("\n");
}

}  // namespace

std::string to_json(const PruneResult& result) {
  const Json json{{"scene", result.scene},
                  {"score", result.score},
                  {"keep", result.keep},
                  {"backend", result.backend},
                  {"conventions", result.conventions},
                  {"views", result.views},
                  {"held_out", result.held_out},
                  {"kept_weight", result.kept_weight},
                  {"before", json_of(result.before)},
                  {"after", json_of(result.after)}};
  return document_of(result.head, members_of(json));
}

void print_table(const PruneResult& result) {
  std::printf("%-8s %10s", "", "Gaussians");
  if (result.before.ms) std::printf(" %10s", "ms a frame");
  if (result.before.photo_psnr_db) std::printf(" %9s", "photo dB");
  if (result.before.photo_ssim) std::printf(" %11s", "photo SSIM");
  if (result.after.unpruned_psnr_db) std::printf(" %12s", "unpruned dB");
  std::printf("\n");
  print_row("before", result.before);
  print_row("after", result.after);
}

}  // namespace swiftgs::cli
