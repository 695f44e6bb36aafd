// SPDX-License-Identifier: Apache-2.0

#include "report/report.hpp"

#include <cstdio>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include <swiftgs/io/replace_file.hpp>

#include "commands.hpp"
#include "json.hpp"
#include "read/distinct_files.hpp"
#include "report/embedded.hpp"

namespace swiftgs::cli {
namespace {

/// Vega in the modules that the page needs of it, in no order: modules.js resolves what each asks for.
constexpr const char* vega_modules[] = {
    "vega-util",       "vega-time",           "vega-format",          "vega-loader",     "vega-dataflow",
    "vega-statistics", "vega-scale",          "vega-canvas",          "vega-scenegraph", "vega-expression",
    "vega-selection",  "vega-event-selector", "vega-functions",       "vega-runtime",    "vega-parser",
    "vega-view",       "vega-transforms",     "vega-view-transforms", "vega-encode"};

/// Of the page itself, each after what it uses.
constexpr const char* own_scripts[] = {
    "stats.js",         "style.js",        "scaling.js", "choices.js", "stress.js",  "plots.js", "bars.js",
    "scaling_plots.js", "stress_plots.js", "table.js",   "charts.js",  "figures.js", "page.js"};

/// `text` with every `from` as `to`.
std::string replaced(std::string_view text, std::string_view from, std::string_view to) {
  std::string result;
  for (std::size_t at; (at = text.find(from)) != text.npos; text.remove_prefix(at + from.size()))
    result.append(text.substr(0, at)).append(to);
  return result.append(text);
}

/// A script within a page, which two texts would end too early or not at all; a backslash in them changes
/// nothing inside of a JavaScript text or pattern.
std::string script(std::string_view code) {
  return "<script>\n" + replaced(replaced(code, "</script", "<\\/script"), "<!--", "<\\!--") + "</script>\n";
}

std::string library() {
  std::string html = script(embedded("modules.js"));
  for (const std::string name : vega_modules)
    html += script("modules.next = \"" + name + "\";\n" + std::string(embedded(name + ".min.js")) + "\n");
  return html;
}

std::string scripts() {
  std::string html;
  for (const char* name : own_scripts) html += script(embedded(name));
  return html;
}

std::string part(std::string_view name, std::string_view data) {
  if (name == "style") return "<style>\n" + std::string(embedded("page.css")) + "</style>\n";
  if (name == "library") return library();
  if (name == "scripts") return scripts();
  if (name == "licences") return replaced(embedded("copyright"), "--", "- -");
  // No text of JSON can end the element: `<` stands in strings alone, where its escape is the same.
  if (name == "data") return replaced(data, "<", "\\u003c");
  throw std::logic_error("page.html: unknown part " + std::string(name));
}

}  // namespace

bool can_plot() { return !embedded("vega-view.min.js").empty(); }

std::string page_of(std::string_view data) {
  constexpr std::string_view begin = "{{", end = "}}";
  std::string_view rest = embedded("page.html");
  std::string html;
  for (std::size_t at; (at = rest.find(begin)) != rest.npos;) {
    const std::size_t close = rest.find(end, at);
    html.append(rest.substr(0, at)).append(part(rest.substr(at + 2, close - at - 2), data));
    rest.remove_prefix(close + end.size());
  }
  return html.append(rest);
}

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
