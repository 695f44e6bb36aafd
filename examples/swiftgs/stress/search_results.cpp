// SPDX-License-Identifier: Apache-2.0
#include "stress/search_results.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdio>

#include "draw/renderer_words.hpp"
#include "json_text.hpp"
#include "stress/table.hpp"

namespace swiftgs::cli {
namespace {

Json json_of(const vec3& v) { return {v.x, v.y, v.z}; }
Json json_of(const dvec3& v) { return {v.x, v.y, v.z}; }

Json json_of(const Lens& lens) {
  const Distortion& d = lens.distortion;
  return {{"model", name_of(lens.model)},
          {"radial", d.radial},
          {"rational", d.rational},
          {"tangential", d.tangential},
          {"prism", d.prism}};
}

Json json_of(const dmat3& matrix) {
  Json rows = Json::array();
  for (int row = 0; row < 3; ++row) rows.push_back({matrix[0][row], matrix[1][row], matrix[2][row]});
  return rows;
}

Json json_of(const Similarity& by) {
  return {{"rotation", json_of(by.rotation)}, {"scale", by.scale}, {"translation", json_of(by.translation)}};
}

Json json_of(const Clip& clip) {
  Json half_spaces = Json::array();
  for (int i = 0; i < clip.half_space_count; ++i) {
    const vec4& h = clip.half_spaces[i];
    half_spaces.push_back({h.x, h.y, h.z, h.w});
  }
  return {{"half_spaces", half_spaces}, {"centre", json_of(clip.centre)}, {"radius", clip.radius}};
}

Json json_of(const Camera& c) {
  return {{"width", c.width},
          {"height", c.height},
          {"fx", c.fx},
          {"fy", c.fy},
          {"cx", c.cx},
          {"cy", c.cy},
          {"rotation", json_of(c.rotation)},
          {"translation", json_of(c.translation)},
          {"lens", json_of(c.lens)}};
}

/// `k` leaves nothing to the scene.
Json json_of(const Conventions& k) {
  return {{"near_plane", k.near_plane},
          {"cull_at_near", k.cull_at_near},
          {"far_plane", k.far_plane},
          {"clamp", k.clamp == Conventions::JacobianClamp::around_image ? "around_image" : "around_centre"},
          {"blur", *k.blur},
          {"antialiased", *k.antialiased},
          {"min_compensation", k.min_compensation},
          {"alpha_min", k.alpha_min},
          {"alpha_max", k.alpha_max},
          {"stop", k.stop},
          {"stop_at_equal", k.stop_at_equal}};
}

Json json_of(const Scene& scene, std::size_t i) {
  const Quaternion& q = scene.rotations[i];
  const auto rest = std::ptrdiff_t(3 * sh_rest_count(scene.sh_degree));
  const auto begin = scene.sh_rest.begin() + std::ptrdiff_t(i) * rest;
  return {{"mean", json_of(scene.means[i])},  {"scale", json_of(scene.scales[i])},
          {"rotation", {q.w, q.x, q.y, q.z}}, {"opacity", scene.opacities[i]},
          {"sh0", json_of(scene.sh0[i])},     {"sh_rest", std::vector<float>(begin, begin + rest)}};
}

Json json_of(const SearchRow& row) {
  const RendererWords words(row.renderer);
  return {{"family", row.family},
          {"renderer", row.renderer},
          {"backend", words.backend},
          {"sort", words.sort},
          {"raster", words.raster},
          {"bounds", words.bounds},
          {"plane", row.plane},
          {"tries", row.tries},
          {"normalised_error", row.normalised_error},
          {"error", row.error.empty() ? Json() : Json(row.error)}};
}

}  // namespace

std::string case_text(const StressCase& drawn) {
  Json gaussians = Json::array();
  for (std::size_t i = 0; i < drawn.scene.size(); ++i) gaussians.push_back(json_of(drawn.scene, i));
  return text_of({{"camera", json_of(drawn.camera)},
                  {"conventions", json_of(as_trained(drawn.conventions, drawn.scene.model))},
                  {"background", json_of(drawn.background)},
                  {"world_from_scene", json_of(drawn.world_from_scene)},
                  {"clip", json_of(drawn.clip)},
                  {"sh_degree", drawn.scene.sh_degree},
                  {"gaussians", gaussians}});
}

std::string to_json(const ResultHead& head, const std::vector<SearchRow>& rows) {
  return document_of(head, {{"rows", array_of(rows, [](const SearchRow& row) {
                               std::string text = text_of(json_of(row));
                               text.pop_back();
                               return text + ",\"case\":" + row.drawn + "}";
                             })}});
}

void print_search(const std::vector<SearchRow>& rows) {
  constexpr std::size_t most_shown = 5;
  for (std::size_t begin = 0, end = 0; begin < rows.size(); begin = end) {
    const std::string& renderer = rows[begin].renderer;
    std::vector<const SearchRow*> shown;
    for (; end < rows.size() && rows[end].renderer == renderer; ++end) shown.push_back(&rows[end]);
    std::stable_sort(shown.begin(), shown.end(), [](const SearchRow* a, const SearchRow* b) {
      return a->normalised_error > b->normalised_error;
    });
    std::printf("%s%s: worst normalised error %s in %llu frames\n", begin > 0 ? "\n" : "", renderer.c_str(),
                error_text(shown.front()->normalised_error).c_str(),
                static_cast<unsigned long long>(rows[begin].tries));
    shown.resize(std::min(shown.size(), most_shown));
    for (const SearchRow* row : shown)
      std::printf("  %10s of %-6s from %s%s%s\n", error_text(row->normalised_error).c_str(),
                  row->plane.c_str(), row->family.c_str(), row->error.empty() ? "" : ": ",
                  row->error.c_str());
  }
}

}  // namespace swiftgs::cli
