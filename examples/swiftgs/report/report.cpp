// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include <swiftgs/io/replace_file.hpp>

#include "commands.hpp"
#include "json_text.hpp"
#include "read/distinct_files.hpp"
#include "report/page.hpp"
#include "report/results.hpp"

namespace swiftgs::cli {
namespace {

struct ReportOptions {
  std::vector<std::string> results;
  std::string out = "report.html";
};

void report(const ReportOptions& options) {
  if (!can_plot())
    throw std::runtime_error(
        "report: expected Vega when this tool was built: install libjs-vega, then configure and build again");
  std::vector<NamedFile> inputs;
  for (const std::string& name : options.results) inputs.push_back({"RESULTS", name});
  require_distinct({{"--out", options.out}}, inputs);
  require_replaceable(options.out);
  Json files = Json::array(), stress = Json::array();
  std::size_t rows = 0;
  for (const std::string& name : options.results) {
    Json results = read_results(name);
    const bool is_stress = results["format"] == stress_format;
    rows += results["rows"].size();
    results["file"] = std::filesystem::path(name).filename().string();
    (is_stress ? stress : files).push_back(std::move(results));
  }
  const Json data{{"files", files}, {"stress", stress}};
  const std::string html = page_of(data.dump(-1, ' ', true, Json::error_handler_t::replace));
  replace_file(options.out, html);
  std::printf("%s: %zu rows of %zu %s, %.1f MiB\n", options.out.c_str(), rows, options.results.size(),
              options.results.size() == 1 ? "file" : "files", double(html.size()) / 1048576);
}

constexpr const char* report_help =
    R"(RESULTS are files that swiftgs bench or swiftgs stress wrote. The page holds everything that it
shows and works without a network: run time against error with the Pareto front, stage times,
speed-ups, growth with fitted exponents, normalised errors on hard frames, and a table of all renderers.

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
