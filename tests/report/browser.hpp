// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdlib>
#include <string>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "cli/command.hpp"
#include "support/skip.hpp"

namespace swiftgs::test {

inline std::string source(const std::string& name) { return content_of(SWIFTGS_SOURCES "/" + name); }

/// Whether pages can be drawn here; if not the test is skipped.
inline bool can_draw(const TemporaryFolder& place) {
  if (!SWIFTGS_HAS_VEGA) {
    const Outcome outcome = swiftgs(place, "report results.json");
    CHECK(outcome.code == 1);
    CHECK(outcome.err.find("install libjs-vega") != std::string::npos);
    skip("the tool was built without Vega (package libjs-vega)");
    return false;
  }
  if (std::string(SWIFTGS_BROWSER).empty()) skip("no Chromium here (package chromium)");
  return !std::string(SWIFTGS_BROWSER).empty();
}

/// Opens the page of `html` in a browser and runs `probe` in it, a script whose `tell(value)` says what it
/// found.
inline nlohmann::json found_in(const TemporaryFolder& place, const std::string& html,
                               const std::string& probe) {
  const std::string tell =
      "const tell = value => { const told = document.createElement('pre'); told.id = 'told';"
      " told.textContent = encodeURIComponent(JSON.stringify(value)); document.body.append(told); };\n";
  const std::size_t end_of_page = html.rfind("</body>");
  REQUIRE(end_of_page != html.npos);
  place.write("probed.html",
              std::string(html).insert(end_of_page, "<script>{" + tell + probe + "}</script>\n"));
  const std::string folder = place.path().string();
  const std::string command =
      "timeout 120 '" SWIFTGS_BROWSER "' --headless --no-sandbox --disable-gpu --user-data-dir='" + folder +
      "/profile' --virtual-time-budget=30000 --window-size=1400,1200 --dump-dom 'file://" + folder +
      "/probed.html' >'" + folder + "/drawn.html' 2>'" + folder + "/browser.log'";
  const int status = std::system(command.c_str());
  CAPTURE(content_of(place / "browser.log"));
  REQUIRE(status == 0);
  const std::string drawn = content_of(place / "drawn.html"), begin = "<pre id=\"told\">";
  const std::size_t at = drawn.find(begin), end = drawn.find("</pre>", at);
  REQUIRE_MESSAGE(at != drawn.npos, "the script of the test must reach its end");
  std::string json;
  for (std::size_t i = at + begin.size(); i < end; ++i) {
    if (drawn[i] == '%') {
      json += char(std::stoi(drawn.substr(i + 1, 2), nullptr, 16));
      i += 2;
    } else {
      json += drawn[i];
    }
  }
  return nlohmann::json::parse(json);
}

}  // namespace swiftgs::test
