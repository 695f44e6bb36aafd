// SPDX-License-Identifier: Apache-2.0
#include "report/browser.hpp"

using namespace swiftgs::test;

TEST_CASE("report: the page computes what is known of made rows") {
  const TemporaryFolder place;
  if (!can_draw(place)) return;
  std::string html = "<!doctype html><body>";
  for (const std::string name : {"stats", "style", "scaling", "choices", "stress"})
    html += "<script>" + source("examples/swiftgs/report/" + name + ".js") + "</script>";
  const nlohmann::json told = found_in(place, html + "</body>", source("tests/report/statistics.js"));
  CHECK(told["count"] > 0);
  for (const nlohmann::json& wrong : told["wrong"]) FAIL_CHECK(wrong.get<std::string>());
}
