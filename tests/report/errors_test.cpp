// SPDX-License-Identifier: Apache-2.0
#include <initializer_list>

#include "report/browser.hpp"
#include "report/made_results.hpp"

using namespace swiftgs::test;

namespace {

bool has_vega() {
  if (!SWIFTGS_HAS_VEGA) skip("the tool was built without Vega (package libjs-vega)");
  return SWIFTGS_HAS_VEGA;
}

/// `report` ends with one line that holds `parts`, and leaves no page.
void refuses(const std::string& content, std::initializer_list<std::string> parts) {
  const TemporaryFolder place;
  place.write("results.json", content);
  const std::string told = refusal(place, "report results.json --out page.html");
  CHECK(told.starts_with("swiftgs: results.json"));
  check_holds(told, parts);
  CHECK(!std::filesystem::exists(place / "page.html"));
}

/// Another value for a member of a good file, and what is said of it. An empty `value` takes the member away.
struct Change {
  const char *place, *value, *said;
};

void refuses_each(const Json& good, std::initializer_list<Change> changes) {
  for (const auto& [place, value, said] : changes) {
    CAPTURE(place);
    Json results = good;
    const Json::json_pointer at(place);
    if (*value)
      results[at] = Json::parse(value);
    else
      results.at(at.parent_pointer()).erase(at.back());
    refuses(results.dump(), {said});
  }
}

const Json good_file = results_of({{}, {.view = "back"}});

}  // namespace

TEST_CASE("report errors: what is no JSON is named with the byte where it ends to be") {
  if (!has_vega()) return;
  const std::string good = results_of({{}}).dump();
  refuses("", {"byte 0: expected JSON that goes on"});
  refuses(good.substr(0, 100), {"byte 100: expected JSON that goes on: the file is cut short"});
  refuses("nothing that was measured", {"byte", "expected JSON"});
  refuses("[1, 2, NaN]", {"byte 7: expected JSON"});
  refuses(good.substr(0, good.size() - 1) + ", \"x\": 1e999}", {"expected numbers that a double can hold"});
  refuses("\xff\xfe{", {"byte 0: expected JSON of swiftgs bench or stress in UTF-8, found a text in UTF-16"});
  refuses(std::string(100000, '['), {"expected objects and arrays at most 16 deep"});
}

TEST_CASE("report errors: a file of another kind or version is refused") {
  if (!has_vega()) return;
  for (const char* other : {"[]", R"({"format": "other", "version": 1})"})
    refuses(other, {"format: expected \"swiftgs-bench\" or \"swiftgs-stress\""});
  refuses_each(good_file, {{"/version", "2", "version: expected 1, found 2"},
                           {"/version", "", "version: expected 1, found null"}});
}

TEST_CASE("report errors: members that are missing or of another type are named") {
  if (!has_vega()) return;
  refuses_each(good_file,
               {{"/rows", "[]", "rows: expected at least one row"},
                {"/machine", "", "machine: expected an object"},
                {"/rows/1/renderer", "", "rows[1].renderer: expected a text"},
                {"/rows/1/width", "0", "rows[1].width: expected a number above 0"},
                {"/rows/0/psnr_db", "\"high\"", "rows[0].psnr_db: expected a number or null"},
                {"/rows/0/ms", "", "rows[0].ms: expected an object"},
                {"/rows/0/ms/total/median", "-1", "rows[0].ms.total.median: expected a number, 0 or more"},
                {"/rows/1/bytes", R"({"project": 1, "sort": 2})",
                 "rows[1].bytes.raster: expected a number, 0 or more"},
                {"/scenes/0/original", "", "scenes[0].original: expected a number"},
                {"/views/0/scale", "null", "views[0].scale: expected a number above 0"}});
}

TEST_CASE("report errors: members of hard frames that are missing or of another type are named") {
  if (!has_vega()) return;
  refuses_each(stress_results_of({{}, {.severity = 1e4}}),
               {{"/version", "2", "version: expected 1, found 2"},
                {"/rows", "[]", "rows: expected at least one row"},
                {"/rows/1/family", "", "rows[1].family: expected a text"},
                {"/rows/1/strict_normalised_error", "\"high\"",
                 "rows[1].strict_normalised_error: expected a number, 0 or more, or null"},
                {"/rows/0/seeds", "0", "rows[0].seeds: expected a number above 0"}});
}

TEST_CASE("report errors: images that are missing or none are named") {
  if (!has_vega()) return;
  refuses_each(
      good_file,
      {{"/rows/0/image", "\"gone.png\"", "expected the image gone.png"},
       {"/rows/0/plane_images", "[{\"plane\": \"id\", \"image\": \"gone.png\"}]",
        "expected the image gone.png"},
       {"/rows/0/plane_images", "[{\"plane\": \"id\"}]", "plane_images.image: expected a text"},
       {"/rows/0/plane_images", "7", "plane_images: expected an array"},
       {"/views/0/reference_image", "\"results.json\"", "expected results.json to be a PNG or JPEG image"}});
}

TEST_CASE("report errors: a page does not take the place of the results it shows") {
  if (!has_vega()) return;
  const TemporaryFolder place;
  place.write("results.json", results_of({{}}).dump());
  const std::string before = content_of(place / "results.json");
  std::filesystem::create_symlink("results.json", place / "link.html");
  std::filesystem::create_hard_link(place / "results.json", place / "other.html");
  for (const std::string out : {"results.json", "./results.json", "link.html", "other.html"}) {
    fails(place, "report results.json --out " + out,
          {"--out " + out + ": expected another file than that of RESULTS"});
    CHECK(content_of(place / "results.json") == before);
  }
}

TEST_CASE("report errors: files that cannot be read or written are named") {
  if (!has_vega()) return;
  const TemporaryFolder place;
  place.write("results.json", results_of({{}}).dump());
  for (const auto& [arguments, part] : {std::pair{"report nowhere.json", "nowhere.json"},
                                        {"report .", ".: Is a directory"},
                                        {"report results.json --out nowhere/page.html", "nowhere/page.html"},
                                        {"report", "RESULTS"}})
    fails(place, arguments, {part});
}
