// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include <swiftgs/io/replace_file.hpp>
#include <swiftgs/version.hpp>

#include "commands.hpp"
#include "json_text.hpp"
#include "read/distinct_files.hpp"
#include "report/files.hpp"
#include "report/page.hpp"
#include "report/results.hpp"

namespace swiftgs::cli {
namespace {

struct ReportOptions {
  std::vector<std::string> results;
  std::string out = "report.html";
};

/// The images of all result files: each once, however many rows name it.
class Images {
 public:
  /// Puts the index of the image in the place of its name, which is relative to the folder of `file`.
  void take(Json& object, const char* member, const std::string& file) {
    const auto name = object.find(member);
    if (name == object.end() || name->is_null()) return;
    const std::filesystem::path path =
        std::filesystem::path(file).parent_path() / name->get_ref<const std::string&>();
    const auto [found, is_new] = index_.emplace(path.lexically_normal().string(), uris_.size());
    if (is_new) uris_.push_back(data_uri_of_image(found->first, file));
    *name = found->second;
  }

  const std::vector<std::string>& uris() const { return uris_; }

 private:
  std::map<std::string, std::size_t> index_;
  std::vector<std::string> uris_;
};

void report(const ReportOptions& options) {
  if (!can_plot())
    throw std::runtime_error(
        "report: expected Vega when this tool was built: install libjs-vega, then configure and build again");
  std::vector<NamedFile> inputs;
  for (const std::string& name : options.results) inputs.push_back({"RESULTS", name});
  require_distinct({{"--out", options.out}}, inputs);
  require_replaceable(options.out);
  Images images;
  Json files = Json::array(), stress = Json::array();
  std::size_t rows = 0;
  for (const std::string& name : options.results) {
    Json results = read_results(name);
    const bool is_stress = results["format"] == stress_format;
    if (!is_stress) {
      for (Json& view : results["views"]) images.take(view, "reference_image", name);
      for (Json& row : results["rows"]) {
        images.take(row, "image", name), images.take(row, "error_image", name);
        for (Json& plane : row["plane_images"]) images.take(plane, "image", name);
      }
    }
    rows += results["rows"].size();
    results["file"] = std::filesystem::path(name).filename().string();
    (is_stress ? stress : files).push_back(std::move(results));
  }
  const Json data{{"tool", "swiftgs " + std::string(version)},
                  {"files", files},
                  {"stress", stress},
                  {"images", images.uris()}};
  const std::string html = page_of(data.dump(-1, ' ', true, Json::error_handler_t::replace));
  replace_file(options.out, html);
  std::printf("%s: %zu rows of %zu %s, %zu images, %.1f MiB\n", options.out.c_str(), rows,
              options.results.size(), options.results.size() == 1 ? "file" : "files", images.uris().size(),
              double(html.size()) / 1048576);
}

constexpr const char* report_help =
    R"(RESULTS are files that swiftgs bench or swiftgs stress wrote. The page holds everything that it
shows and works without a network: run time against error with the Pareto front, stage times,
speed-ups, growth with fitted exponents, normalised errors on hard frames, all rows of bench as a table,
and images where the files name some.

Example:
  swiftgs bench builtin --json results.json
  swiftgs stress --json stress.json
  swiftgs report results.json stress.json --out report.html)";

}  // namespace

void add_report(CLI::App& app) {
  CLI::App* command = app.add_subcommand("report", "A page that shows what bench and stress have measured");
  command->footer(report_help);
  const auto options = std::make_shared<ReportOptions>();
  command->add_option("RESULTS", options->results, "Files of swiftgs bench and swiftgs stress")->required();
  command->add_option("--out", options->out, "File for the page")->capture_default_str();
  command->callback([options] { report(*options); });
}

}  // namespace swiftgs::cli
