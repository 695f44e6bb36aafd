// SPDX-License-Identifier: Apache-2.0
#include "bench/resume.hpp"

#include <filesystem>
#include <fstream>
#include <limits>
#include <stdexcept>

#include "json_text.hpp"

namespace swiftgs::cli {
namespace {

/// What makes two times comparable. The date and the load may change.
constexpr const char* same_machine[] = {"cpu",      "cores", "system", "gpu",     "driver",
                                        "compiler", "flags", "cuda",   "version", "commit"};

[[noreturn]] void fail(const std::string& path, const std::string& what) {
  throw std::runtime_error("--resume " + path + ": " + what);
}

/// A number that `rounded` has written.
double number(const Json& json) {
  return json.is_null() ? std::numeric_limits<double>::quiet_NaN() : json.get<double>();
}

Duration duration_of(const Json& json) {
  return {json.at("median"), json.at("low"), json.at("high"), json.at("p10"), json.at("p90")};
}

Place place_of(const Json& json) {
  return {json.at("scene"), json.at("gaussians"), json.at("enlarge"), json.at("view"),
          json.at("width"), json.at("height"),    json.at("scale"),   json.at("conventions")};
}

std::optional<PhotoErrors> photo_of(const Json& json) {
  if (json.at("photo_psnr_db").is_null()) return std::nullopt;
  return PhotoErrors{json.at("photo_psnr_db"), number(json.at("photo_ssim"))};
}

/// The PSNR of equal images is infinite, and null in the file, as are all errors where there are none.
std::optional<Errors> errors_of(const Json& json) {
  if (json.at("max_abs").is_null()) return std::nullopt;
  const Json &psnr = json.at("psnr_db"), &cut = json.at("cut_psnr_db");
  return Errors{psnr.is_null() ? std::numeric_limits<double>::infinity() : psnr.get<double>(),
                number(json.at("ssim")), json.at("max_abs"),
                cut.is_null() ? std::nullopt : std::optional(cut.get<double>())};
}

SceneResult scene_of(const Json& json) {
  return {json.at("scene"),     json.at("gaussians"), json.at("original"), json.at("enlarge"),
          json.at("sh_degree"), json.at("model"),     json.at("geometry")};
}

ViewResult view_of(const Json& json) { return {place_of(json), photo_of(json)}; }

RowResult row_of(const Json& json) {
  RowResult row;
  row.place = place_of(json);
  row.threads = json.at("threads");
  row.renderer = json.at("renderer"), row.planes = json.at("planes"), row.harmonics = json.at("harmonics");
  row.frames = json.at("frames"), row.batch = json.at("batch");
  const Json& ms = json.at("ms");
  row.ms = {duration_of(ms.at("project")), duration_of(ms.at("sort")), duration_of(ms.at("raster")),
            duration_of(ms.at("total")), duration_of(ms.at("wall"))};
  row.errors = errors_of(json), row.photo = photo_of(json);
  row.visible = json.at("visible"), row.intersections = json.at("intersections");
  row.contributing_pairs = json.at("contributing_pairs");
  const Json& bytes = json.at("bytes");
  row.bytes = {bytes.at("project"), bytes.at("sort"), bytes.at("raster")};
  row.device_bytes = json.at("device_bytes"), row.host_bytes = json.at("host_bytes");
  return row;
}

void require_same(const std::string& path, const std::string& what, const Json& found, const Json& here) {
  if (found != here) fail(path, what + " is " + text_of(found) + "; expected " + text_of(here));
}

}  // namespace

Results resumed_results(const std::string& path, const ResultHead& head) {
  Results results{.head = head, .scenes = {}, .views = {}, .rows = {}};
  std::ifstream in(path, std::ios::binary);
  if (!in && !std::filesystem::exists(path)) return results;
  try {
    const Json found = Json::parse(in), here = Json::parse(document_of(head, {}));
    for (const char* member : {"format", "version", "command"})
      require_same(path, member, found.at(member), here.at(member));
    for (const char* member : same_machine)
      require_same(path, std::string("machine.") + member, found.at("machine").value(member, Json()),
                   here.at("machine").value(member, Json()));
    for (const Json& scene : found.at("scenes")) results.scenes.push_back(scene_of(scene));
    for (const Json& view : found.at("views")) results.views.push_back(view_of(view));
    for (const Json& row : found.at("rows")) results.rows.push_back(row_of(row));
  } catch (const Json::exception& error) {
    fail(path, std::string("expected what bench has written; ") + error.what());
  }
  return results;
}

void require_same_scene(const std::string& path, const Results& found, const SceneResult& scene) {
  for (const SceneResult& other : found.scenes)
    if (other.scene == scene.scene && other.gaussians == scene.gaussians && other.enlarge == scene.enlarge &&
        (other.geometry != scene.geometry || other.model != scene.model))
      fail(path, "scene " + scene.scene +
                     " has changed; expected the Gaussians and the model that the file was measured with");
}

}  // namespace swiftgs::cli
