// SPDX-License-Identifier: Apache-2.0
#include <swiftgs/edit/affine.hpp>
#include <swiftgs/project/sh.hpp>

#include "gltf_encoder.hpp"
#include "spz_encoder.hpp"

namespace swiftgs::test::gltf_nodes_test {

using nlohmann::json;

namespace {

SceneFile read(const GltfParts& parts) { return test::read(glb(parts)); }
std::string complaint_about(const GltfParts& parts) { return test::complaint_about(glb(parts)); }

/// A map of glTF's axes on a scene's: x and y point the other way.
dvec3 flipped(const dvec3& p) { return {-p.x, -p.y, p.z}; }

/// Checks that each Gaussian of `moved` is that of `scene` after p -> linear p + offset in glTF's axes, where
/// `turn` is the rotation in `linear`.
void check_moved(const Scene& moved, const Scene& scene, const dmat3& linear, const dmat3& turn,
                 const dvec3& offset) {
  const auto map = [&](const dvec3& p) { return flipped(linear * flipped(p)); };
  REQUIRE(moved.size() == scene.size());
  const dvec3 direction(0.48, -0.6, 0.64);
  const dvec3 turned = flipped(turn * flipped(direction));
  const dmat3 in_scene(map({1, 0, 0}), map({0, 1, 0}), map({0, 0, 1}));
  for (std::size_t i = 0; i < scene.size(); ++i) {
    const dvec3 mean = map(dvec3(scene.means[i])) + flipped(offset);
    for (int c = 0; c < 3; ++c) CHECK(double(moved.means[i][c]) == doctest::Approx(mean[c]).epsilon(1e-5));
    check_moved_covariance(moved, scene, i, in_scene);
    const std::size_t rest = 3 * std::size_t(sh_rest_count(scene.sh_degree));
    const vec3 was = sh_colour(scene.sh_degree, scene.sh0[i], &scene.sh_rest[i * rest], vec3(direction));
    const vec3 is = sh_colour(moved.sh_degree, moved.sh0[i], &moved.sh_rest[i * rest], vec3(turned));
    for (int c = 0; c < 3; ++c) CHECK(is[c] == doctest::Approx(was[c]).epsilon(1e-4));
  }
}

/// A node's members as one matrix, by columns.
json matrix_json(const dmat3& m, const dvec3& t) {
  json values;
  for (int column = 0; column < 3; ++column) {
    for (int row = 0; row < 3; ++row) values.push_back(m[column][row]);
    values.push_back(0);
  }
  for (int row = 0; row < 3; ++row) values.push_back(t[row]);
  values.push_back(1);
  return values;
}

const DQuaternion tilt = unit({0.7, -0.2, 0.5, 0.4});
const json tilt_json = {tilt.x, tilt.y, tilt.z, tilt.w};
const dmat3 stretch_alone(2, 0, 0, 0, 1, 0, 0, 0, 0.5);
const json stretch_json = {2, 1, 0.5};

}  // namespace

TEST_CASE("gltf: a node moves Gaussians with their shapes and colours") {
  const Scene scene = some_scene(12, 3);
  GltfParts parts = encode_gltf(scene);
  const dmat3 linear = 2.5 * matrix_of(tilt);
  parts.root["nodes"][0].update(
      {{"rotation", tilt_json}, {"scale", {2.5, 2.5, 2.5}}, {"translation", {1, -2, 3}}});
  check_moved(read(parts).scene, scene, linear, matrix_of(tilt), {1, -2, 3});
  parts.root["nodes"][0] = {{"mesh", 0}, {"matrix", matrix_json(linear, {1, -2, 3})}};
  check_moved(read(parts).scene, scene, linear, matrix_of(tilt), {1, -2, 3});
}

TEST_CASE("gltf: nodes move what is below them and stretches that cancel are none") {
  const Scene scene = some_scene(12, 2);
  GltfParts parts = encode_gltf(scene);
  parts.root["nodes"] =
      json::array({{{"children", json::array({2})}, {"translation", {1, 2, 3}}, {"scale", {1, 2, 4}}},
                   {{"mesh", 0}},
                   {{"children", json::array({1})}, {"scale", {2, 1, 0.5}}, {"translation", {1, 1, 1}}}});
  check_moved(read(parts).scene, scene, dmat3(2.0), dmat3(1.0), {2, 4, 7});
  parts.root["nodes"][0] = {{"children", json::array({2})}, {"rotation", tilt_json}};
  parts.root["nodes"][2] = {{"children", json::array({1})}, {"translation", {1, 1, 1}}};
  check_moved(read(parts).scene, scene, matrix_of(tilt), matrix_of(tilt), matrix_of(tilt) * dvec3(1, 1, 1));
}

TEST_CASE("gltf: a node stretches Gaussians and turns their colours by its rotation") {
  GltfParts parts = encode_gltf(some_scene(12, 3));
  const Scene scene = read(parts).scene;
  const dmat3 turn = matrix_of(tilt), linear = turn * stretch_alone;
  parts.root["nodes"][0].update({{"scale", stretch_json}, {"translation", {1, -2, 3}}});
  check_moved(read(parts).scene, scene, stretch_alone, dmat3(1.0), {1, -2, 3});
  parts.root["nodes"][0]["rotation"] = tilt_json;
  check_moved(read(parts).scene, scene, linear, turn, {1, -2, 3});
  parts.root["nodes"][0] = {{"mesh", 0}, {"matrix", matrix_json(linear, {1, -2, 3})}};
  check_moved(read(parts).scene, scene, linear, turn, {1, -2, 3});
  CHECK(read(parts).notes.empty());
}

TEST_CASE("gltf: stretches of turned nodes shear Gaussians") {
  GltfParts parts = encode_gltf(some_scene(12, 3));
  const Scene scene = read(parts).scene;
  parts.root["nodes"] = json::array({{{"children", json::array({1})}, {"scale", stretch_json}},
                                     {{"mesh", 0}, {"rotation", tilt_json}, {"scale", {1, 3, 1}}}});
  const dmat3 linear = stretch_alone * matrix_of(tilt) * dmat3(1, 0, 0, 0, 3, 0, 0, 0, 1);
  check_moved(read(parts).scene, scene, linear, rotation_of({linear}), {0, 0, 0});
}

TEST_CASE("gltf: half a turn written as negative scales is a rotation") {
  GltfParts parts = encode_gltf(some_scene(12, 3));
  const Scene scene = read(parts).scene;
  parts.root["nodes"][0]["scale"] = {-2, 1, -0.5};
  const dmat3 half(-1, 0, 0, 0, 1, 0, 0, 0, -1);
  check_moved(read(parts).scene, scene, half * stretch_alone, half, {0, 0, 0});
}

TEST_CASE("gltf: Gaussians of an SPZ and of an early splat-transform are stretched in their axes") {
  const Scene scene = some_scene(12, 2);
  GltfParts parts = gltf_with_spz(gzip_spz(encode_spz(scene, 2)), "KHR_gaussian_splatting_compression_spz_2");
  const Scene still = read(parts).scene;
  parts.root["nodes"][0].update({{"rotation", tilt_json}, {"scale", stretch_json}});
  const dmat3 linear = matrix_of(tilt) * stretch_alone;
  check_moved(read(parts).scene, still, linear, matrix_of(tilt), {0, 0, 0});

  parts = encode_gltf(scene);
  parts.root["asset"]["generator"] = "splat-transform 1.10.1";
  const Scene raw = read(parts).scene;
  parts.root["nodes"][0].update({{"rotation", tilt_json}, {"scale", stretch_json}});
  const Scene moved = read(parts).scene;
  for (std::size_t i = 0; i < 12; ++i) check_moved_covariance(moved, raw, i, linear);
}

TEST_CASE("gltf: primitives of different degrees and instances of them make one scene") {
  const Scene scene = some_scene(6, 2);
  GltfParts parts = encode_gltf(scene);
  // The second primitive has the first three Gaussians and band 1; the second mesh has it alone.
  json low = parts.primitive();
  json& attributes = low["attributes"];
  for (int n = 0; n < 5; ++n)
    attributes.erase("KHR_gaussian_splatting:SH_DEGREE_2_COEF_" + std::to_string(n));
  for (json& index : attributes) {
    json accessor = parts.root["accessors"][index.get<std::size_t>()];
    accessor["count"] = 3;
    index = parts.root["accessors"].size();
    parts.root["accessors"].push_back(accessor);
  }
  parts.root["meshes"][0]["primitives"].push_back(low);
  parts.root["meshes"].push_back({{"primitives", json::array({low})}});
  parts.root["nodes"] = {{{"mesh", 1}}, {{"mesh", 0}, {"translation", {10, 2, 3}}}, {{"mesh", 0}}};
  parts.root["scenes"][0]["nodes"] = {0, 1, 2};
  const Scene got = read(parts).scene;
  CHECK_NOTHROW(validate(got));
  REQUIRE(got.size() == 21);
  CHECK(got.sh_degree == 2);
  for (std::size_t i = 0; i < 21; ++i) {
    const std::size_t of = i < 3 ? i : (i - 3) % 9 % 6;
    const bool moved = i >= 3 && i < 12, whole = i >= 3 && (i - 3) % 9 < 6;
    CHECK(got.means[i].x == doctest::Approx(scene.means[of].x - (moved ? 10 : 0)));
    CHECK(got.opacities[i] == scene.opacities[of]);
    if (!moved) {
      CHECK(got.means[i] == scene.means[of]);
      CHECK(got.sh0[i] == scene.sh0[of]);
      CHECK(got.scales[i] == scene.scales[of]);
    }
    for (std::size_t k = 0; k < 24; ++k)
      CHECK(got.sh_rest[24 * i + k] == (k < 9 || whole ? scene.sh_rest[24 * of + k] : 0.0f));
  }
}

TEST_CASE("gltf: the scene that the file names is read, else the first, else all roots") {
  GltfParts parts = encode_gltf(some_scene(4, 0));
  parts.root["nodes"] = json::array(
      {{{"mesh", 0}}, {{"mesh", 0}, {"translation", {1, 0, 0}}}, {{"children", json::array({0})}}});
  parts.root["scenes"] = json::array({{{"nodes", json::array({0})}}, {{"nodes", {0, 1}}}});
  parts.root["scene"] = 1;
  CHECK(read(parts).scene.size() == 8);
  parts.root.erase("scene");
  CHECK(read(parts).scene.size() == 4);
  parts.root.erase("scenes");
  const SceneFile file = read(parts);
  CHECK(file.scene.size() == 8);
  CHECK(file.notes.empty());
}

TEST_CASE("gltf: nodes that mirror or flatten Gaussians are refused by their names and offsets") {
  GltfParts parts = encode_gltf(some_scene(3, 1));
  const dmat3 turn = matrix_of(tilt);
  dmat3 mirrored = turn, flat = turn;
  mirrored[2] = -turn[2], flat[2] = turn[0] - turn[1];
  const std::string mirror = "that does not mirror", flatten = "that does not flatten",
                    lengths = "of columns with lengths of 1e-60 to 1e60";
  for (const auto& [node, expected] : {std::pair{json{{"scale", {1, 1, -1}}}, mirror},
                                       {json{{"scale", {-1, -1, -1}}}, mirror},
                                       {json{{"matrix", matrix_json(mirrored, {})}}, mirror},
                                       {json{{"matrix", matrix_json(flat, {})}}, flatten},
                                       {json{{"scale", {1, 0, 1}}}, lengths},
                                       {json{{"scale", {1e200, 1e200, 1e200}}}, lengths}}) {
    CAPTURE(node.dump());
    parts.root["nodes"][0] = node;
    parts.root["nodes"][0].update({{"mesh", 0}, {"name", "chair"}});
    const std::string message = complaint_about(parts);
    CHECK(contains(message,
                   "expected node 0 \"chair\" to have, with the nodes above it, a matrix " + expected));
    const std::string offset = std::to_string(glb(parts).find(parts.root["nodes"][0].dump()));
    CHECK(contains(message, "a file: byte " + offset + ": "));
  }
  // The node above mirrors, and the one with the mesh is named.
  parts.root["nodes"] = json::array({{{"children", json::array({1})}, {"scale", {1, -1, 1}}}, {{"mesh", 0}}});
  CHECK(contains(complaint_about(parts), "expected node 1 to have, with the nodes above it, a matrix that"));
  parts.root["nodes"][1]["scale"] = {-1, 1, 1};
  CHECK(complaint_about(parts) == "");
  parts.root["nodes"] = json::array({{{"mesh", 0}, {"scale", {1e38, 1e38, 1e38}}}});
  CHECK(contains(complaint_about(parts), "within the range of float"));
  for (const double each : {0.0, 1e-200, 1e200}) {
    parts.root["nodes"][0] = {{"mesh", 0}, {"rotation", {each, each, each, each}}};
    CHECK(contains(complaint_about(parts), "a 'rotation' of length 1"));
  }
  // A node without Gaussians may be of any shape.
  parts.root["nodes"] = json::array({{{"mesh", 0}}, {{"scale", {1, 2, -3}}}});
  parts.root["scenes"][0]["nodes"] = {0, 1};
  CHECK(complaint_about(parts) == "");
}

TEST_CASE("gltf: what nodes hide by the scale 0 or by their visibility is left out and counted") {
  GltfParts parts = encode_gltf(some_scene(3, 0));
  parts.root["extensionsUsed"].push_back("KHR_node_visibility");
  parts.root["extensionsRequired"] = {"KHR_node_visibility"};
  const auto visibility = [](const json& visible) {
    return json{{"extensions", {{"KHR_node_visibility", visible}}}};
  };
  for (const json& hiding : {json{{"scale", {0, 0, 0}}}, visibility({{"visible", false}})}) {
    CAPTURE(hiding.dump());
    parts.root["nodes"] = json::array({{{"mesh", 0}}, hiding, {{"mesh", 0}, {"scale", {1, 2, 3}}}});
    parts.root["nodes"][1]["children"] = json::array({2});
    parts.root["scenes"][0]["nodes"] = {0, 1};
    const SceneFile file = read(parts);
    CHECK(file.scene.size() == 3);
    CHECK(file.notes == std::vector<std::string>{"Gaussians of hidden nodes were left out: 3."});
    parts.root["scenes"][0]["nodes"] = json::array({1});
    CHECK(contains(complaint_about(parts), "in its scene, found only those of hidden nodes"));
  }
  for (const json& shown : {json::object(), json{{"visible", true}}}) {
    parts.root["nodes"][1].update(visibility(shown));
    const SceneFile file = read(parts);
    CHECK(file.scene.size() == 3);
    CHECK(file.notes.empty());
  }
  parts.root["nodes"][1].update(visibility({{"visible", 1}}));
  CHECK(contains(complaint_about(parts), "'visible' to be true or false"));
  parts.root["nodes"][1].update(visibility(false));
  CHECK(contains(complaint_about(parts), "'KHR_node_visibility' of a node to be an object"));
}

TEST_CASE("gltf: skins, morph targets and animations are told of") {
  GltfParts parts = encode_gltf(some_scene(3, 0));
  parts.root["nodes"][0]["skin"] = 0;
  parts.primitive()["targets"] = json::array({{{"POSITION", 0}}});
  parts.root["animations"] = json::array({json::object()});
  CHECK(read(parts).notes ==
        std::vector<std::string>{"Morph targets were left out.", "Animations were left out.",
                                 "Skins were left out: Gaussians are where their nodes are."});
}

TEST_CASE("gltf: nodes that are reached twice are refused") {
  GltfParts parts = encode_gltf(some_scene(3, 0));
  const auto children = [&](const json& of_first, const json& of_second) {
    parts.root["nodes"] = json::array({{{"mesh", 0}, {"children", of_first}}, {{"children", of_second}}});
    return complaint_about(parts);
  };
  CHECK(children(json::array({1}), json::array()) == "");
  CHECK(contains(children(json::array({1}), json::array({0})), "reached twice"));
  CHECK(contains(children(json::array({0}), json::array()), "reached twice"));
  CHECK(contains(children(json::array({1, 1}), json::array()), "reached twice"));
  CHECK(contains(children(json::array({2}), json::array()), "an index below 2 into 'nodes', found 2"));
}

TEST_CASE("gltf: a long chain of nodes is no deeper a recursion") {
  GltfParts parts = encode_gltf(some_scene(3, 0));
  json nodes;
  for (int i = 1; i <= 100'000; ++i)
    nodes.push_back({{"children", json::array({i})}, {"translation", {0, 0, 1}}});
  nodes.push_back({{"mesh", 0}});
  parts.root["nodes"] = nodes;
  const Scene scene = read(parts).scene;
  CHECK(scene.origin.z + double(scene.means[0].z) > 90'000);
}

TEST_CASE("gltf: a small file cannot ask for many instances") {
  GltfParts parts = encode_gltf(some_scene(1000, 0));
  json nodes, indices;
  for (int i = 0; i < 1000; ++i) nodes.push_back({{"mesh", 0}}), indices.push_back(i);
  parts.root["nodes"] = nodes;
  parts.root["scenes"][0]["nodes"] = indices;
  CHECK(contains(complaint_about(parts), "at most 8 Gaussians, those of each instance counted, for each of"));
  parts.root["scenes"][0]["nodes"] = json(std::vector<json>(indices.begin(), indices.begin() + 200));
  CHECK(read(parts).scene.size() == 200'000);
}

// Cesium ion's tiles lie on the Earth: their nodes have translations of millions of metres.
TEST_CASE("gltf: a node far from zero gives the scene an origin") {
  GltfParts parts = encode_gltf(some_scene(12, 0));
  const Scene near = read(parts).scene;
  CHECK(near.origin == dvec3(0));
  parts.root["nodes"][0]["translation"] = {4'000'000.3, 0, 0};
  const SceneFile file = read(parts);
  REQUIRE(file.notes.size() == 1);
  CHECK(contains(file.notes[0], "relative to the origin -"));  // x of glTF points to the other side
  for (std::size_t i = 0; i < 12; ++i) {
    const dvec3 moved = file.scene.origin + dvec3(file.scene.means[i]) - dvec3(near.means[i]);
    CHECK(glm::length(moved - dvec3(-4'000'000.3, 0, 0)) < 1e-5);
  }
}

}  // namespace swiftgs::test::gltf_nodes_test
