// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>

#include <swiftgs/edit/rotation.hpp>

#include "gltf_document.hpp"

namespace swiftgs::io {
namespace {

using nlohmann::json;

template <std::size_t Count>
std::array<double, Count> numbers(const JsonEntry& entry, const char* key,
                                  const std::array<double, Count>& otherwise) {
  if (!entry.has(key)) return otherwise;
  const json& values = entry.member(key);
  const auto fail = [&] { entry.fail(std::to_string(Count) + " numbers in '" + key + "'"); };
  if (!values.is_array() || values.size() != Count) fail();
  std::array<double, Count> result;
  for (std::size_t i = 0; i < Count; ++i) {
    if (!values[i].is_number()) fail();
    result[i] = values[i].template get<double>();
  }
  return result;
}

/// The movement of a node alone.
Affine movement_of(const JsonEntry& node) {
  Affine map;
  if (node.has("matrix")) {
    const auto m = numbers<16>(node, "matrix", {});
    if (m[3] != 0 || m[7] != 0 || m[11] != 0 || m[15] != 1)
      node.fail("a 'matrix' whose last row is 0, 0, 0, 1");
    map.linear = dmat3(dvec3(m[0], m[1], m[2]), dvec3(m[4], m[5], m[6]), dvec3(m[8], m[9], m[10]));
    map.translation = {m[12], m[13], m[14]};
    return map;
  }
  const auto t = numbers<3>(node, "translation", {0, 0, 0}), s = numbers<3>(node, "scale", {1, 1, 1});
  const auto q = numbers<4>(node, "rotation", {0, 0, 0, 1});
  const double length = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
  if (!(length > 0 && std::isfinite(length))) node.fail("a 'rotation' of length 1");
  map.linear = matrix_of(unit({q[3], q[0], q[1], q[2]}));
  for (int axis = 0; axis < 3; ++axis) map.linear[axis] *= s[std::size_t(axis)];
  map.translation = {t[0], t[1], t[2]};
  return map;
}

/// Whether KHR_node_visibility hides a node and those below it.
bool is_hidden(const JsonEntry& node) {
  const json* object = &node.members();
  for (const char* key : {"extensions", gltf_visibility_extension}) {
    const auto found = object->find(key);
    if (found == object->end()) return false;
    if (!found->is_object()) node.fail(std::string("'") + key + "' of a node to be an object");
    object = &*found;
  }
  const auto visible = object->find("visible");
  if (visible == object->end()) return false;
  if (!visible->is_boolean()) node.fail("'visible' to be true or false");
  return !visible->get<bool>();
}

/// Indices in the member `key` of `entry`, an array.
std::vector<std::uint64_t> indices(const JsonEntry& entry, const char* key) {
  std::vector<std::uint64_t> result;
  if (!entry.has(key)) return result;
  const json& values = entry.member(key);
  if (!values.is_array()) entry.fail(std::string("'") + key + "' to be an array");
  for (const json& value : values) {
    if (!value.is_number_unsigned()) entry.fail(std::string("indices in '") + key + "'");
    result.push_back(value.get<std::uint64_t>());
  }
  return result;
}

/// The nodes of the scene to show. Without any scene, those that are no node's children.
std::vector<std::uint64_t> roots(const GltfDocument& document, std::vector<std::string>& notes) {
  const JsonEntry root = document.root();
  if (const std::size_t scenes = document.size("scenes"); scenes > 0) {
    const std::uint64_t shown_scene = whole_number(root, "scene", 0);
    if (scenes > 1)
      notes.push_back("The file has " + std::to_string(scenes) + " scenes; number " +
                      std::to_string(shown_scene) + ", counted from 0, was read.");
    return indices(document.item("scenes", shown_scene, root), "nodes");
  }
  std::vector<bool> child(document.size("nodes"));
  for (std::uint64_t i = 0; i < child.size(); ++i)
    for (const std::uint64_t c : indices(document.item("nodes", i, root), "children"))
      if (c < child.size()) child[c] = true;
  std::vector<std::uint64_t> result;
  for (std::uint64_t i = 0; i < child.size(); ++i)
    if (!child[i]) result.push_back(i);
  return result;
}

struct Step {
  std::uint64_t node, parent;
};

constexpr std::uint64_t no_parent = ~std::uint64_t(0);

}  // namespace

std::vector<GltfPlacement> place_meshes(const GltfDocument& document, std::vector<std::string>& notes) {
  const JsonEntry root = document.root();
  std::vector<GltfPlacement> placements;
  std::vector<Step> waiting;
  for (const std::uint64_t node : roots(document, notes)) waiting.push_back({node, no_parent});
  std::reverse(waiting.begin(), waiting.end());
  std::vector<Affine> movements(document.size("nodes"));
  std::vector<bool> reached(movements.size());
  while (!waiting.empty()) {
    const auto [index, parent] = waiting.back();
    waiting.pop_back();
    const JsonEntry node =
        document.item("nodes", index, parent == no_parent ? root : document.item("nodes", parent, root));
    if (reached[index]) node.fail("a node with one parent, found it reached twice");
    reached[index] = true;
    Affine& movement = movements[index] = movement_of(node);
    if (parent != no_parent) movement = movements[parent] * movement;
    if (is_hidden(node)) movement.linear = dmat3(0.0);
    if (node.has("mesh")) placements.push_back({index, whole_number(node, "mesh"), movement});
    const std::vector<std::uint64_t> children = indices(node, "children");
    for (auto child = children.rbegin(); child != children.rend(); ++child)
      waiting.push_back({*child, index});
  }
  return placements;
}

void expect_drawable(const GltfDocument& document, const GltfPlacement& placement) {
  const char* const expected = placement.movement.unmet();
  if (!expected) return;
  const JsonEntry node = document.item("nodes", placement.node, document.root());
  const std::string name = node.has("name") ? " " + shown(node.member("name")) : "";
  node.fail("node " + std::to_string(placement.node) + name + " to have, with the nodes above it, " +
            expected);
}

}  // namespace swiftgs::io
