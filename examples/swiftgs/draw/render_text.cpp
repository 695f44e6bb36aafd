// SPDX-License-Identifier: Apache-2.0
#include "draw/render_text.hpp"

#include <cstdint>
#include <cstdio>

#include "draw/lenses.hpp"

namespace swiftgs::cli {

void print(const RenderResult& result) {
  const StageTimes& ms = result.ms;
  const bool is_pinhole = result.lens == words_of(Lens());
  std::printf("%s  %dx%d  %s%.2f ms (project %.2f, sort %.2f, raster %.2f)\n", result.image.c_str(),
              result.width, result.height, is_pinhole ? "" : (result.lens + "  ").c_str(), ms.total,
              ms.project, ms.sort, ms.raster);
  if (!result.counts) return;
  const Statistics& s = *result.counts;

  const auto line = [](const char* label, std::uint64_t count) {
    std::printf("  %-33s %llu\n", label, static_cast<unsigned long long>(count));
  };
  line("Gaussians", s.gaussians);
  line("visible", s.visible);
  line("intersections", s.intersections);
  std::printf("  %-33s %.2f\n", "intersections a visible Gaussian", s.intersections_a_visible());
  line("contributing pairs", s.raster.contributing_pairs);
  line("pixels stopped early", s.raster.pixels_stopped);
}

}  // namespace swiftgs::cli
