// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include <swiftgs/io/image.hpp>
#include <swiftgs/metrics.hpp>

#include "commands.hpp"
#include "json.hpp"
#include "notes.hpp"

namespace swiftgs::cli {
namespace {

struct CompareOptions {
  std::string a, b;
};

/// The colours of the image in `file`, which are compared; says it if there is alpha.
Image colour_of(const std::string& file, std::vector<std::string>& notes) {
  Image image = read_image(file);
  const int channels = image.channels >= 3 ? 3 : 1;
  if (image.channels == channels) return image;
  say_notes(file, {"Alpha is not compared."}, notes);
  Image colour{image.width, image.height, channels, {}};
  for (std::size_t i = 0; i < image.pixels.size(); ++i)
    if (int(i % std::size_t(image.channels)) < channels) colour.pixels.push_back(image.pixels[i]);
  return colour;
}

std::string shape_of(const Image& image) {
  return std::to_string(image.width) + "x" + std::to_string(image.height) + " " +
         (image.channels == 1 ? "grey" : "RGB");
}

void compare(const CompareOptions& options) {
  std::vector<std::string> notes;
  const Image a = colour_of(options.a, notes), b = colour_of(options.b, notes);
  if (shape_of(a) != shape_of(b))
    throw std::invalid_argument(options.b + ": expected " + shape_of(a) + " as in " + options.a + ", found " +
                                shape_of(b));
  const Json differences{{"psnr_db", psnr(a.pixels, b.pixels)},
                         {"ssim", ssim(a.width, a.height, a.channels, a.pixels, b.pixels)},
                         {"max_abs", max_abs_difference(a.pixels, b.pixels)},
                         {"notes", notes}};
  std::printf("%s\n", text_of(differences).c_str());
}

constexpr const char* compare_help =
    R"(Prints psnr_db, ssim, max_abs and notes. Images are PNG, JPEG, PFM or EXR of the same size;
alpha is left out. Values are those of the files, 0 to 1 in files of integers. psnr_db of equal
images is null, as JSON has no infinity.

Example:
  swiftgs compare a.png b.png)";

}  // namespace

void add_compare(CLI::App& app) {
  CLI::App* command = app.add_subcommand("compare", "How two images differ, as JSON");
  command->footer(compare_help);
  const auto options = std::make_shared<CompareOptions>();
  command->add_option("A", options->a, "An image")->required();
  command->add_option("B", options->b, "Another of the same size")->required();
  command->callback([options] { compare(*options); });
}

}  // namespace swiftgs::cli
