// SPDX-License-Identifier: Apache-2.0

// Kernels of `Vulkan`: their order and sizes, sorts, lists and picks, and blocks of long lists.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string_view>
#include <vector>

#include <doctest/doctest.h>

#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/metrics.hpp>
#include <swiftgs/swiftgs.hpp>

#include "commands.hpp"
#include "hazards.hpp"
#include "policies/images.hpp"
#include "policies/random_splats.hpp"
#include "vulkan/device.hpp"
#include "vulkan/frames.hpp"

namespace swiftgs::test {
TEST_CASE("vulkan: a barrier stands between dispatches that share what one of them writes") {
  const std::uint32_t memory[8] = {}, *const counted = memory + 4;
  vulkan::Hazards hazards;
  const auto next = [&](auto... accesses) { return hazards.next(vulkan::Push(accesses...).accesses()); };
  CHECK(next(vulkan::reads(memory, 1)));  // what came before is not known
  CHECK(!next(vulkan::writes(memory + 1, 3)));
  CHECK(!next(vulkan::writes(memory + 4, 4)));
  CHECK(next(vulkan::reads(memory + 3, 1)));
  CHECK(!next(vulkan::reads(memory + 3, 1), vulkan::writes(memory, 0)));
  CHECK(next(vulkan::writes(memory + 3, 2)));
  CHECK(next(vulkan::shares(memory + 4, 1)));
  CHECK(!next(vulkan::shares(memory + 4, 1), vulkan::address(memory + 4)));
  CHECK(next(Count(8, counted)));
}

SWIFTGS_VULKAN_CASE("vulkan: blocks of many splats have the same bits by one subgroup and by several") {
  // Where pixels stop: in the first segment, in later ones, and nowhere.
  for (const float opacity : {0.05f, 0.02f, 0.006f}) {
    CAPTURE(opacity);
    Scene scene = random_scene(12'000, 0, 13);
    Random random(14);
    for (std::size_t i = 0; i < scene.size(); ++i) {
      const float z = 2 + 8 * random.f(0, 1);
      scene.means[i] = vec3(random.f(-0.3, 0.3) * z, random.f(-0.3, 0.3) * z, z);
      scene.scales[i] = vec3(random.f(0.05, 0.4) * z, random.f(0.05, 0.4) * z, 0.01f);
      scene.opacities[i] = opacity;
    }
    const Camera camera = forward_camera(21, 19);
    UsualVulkan renderer;
    UsualSerial serial;
    const VulkanScene there = renderer.backend().upload(scene);
    RenderSettings lean;
    lean.outputs.depth = true;
    const Frame shared = renderer.render(there, camera, lean);
    std::size_t longest = 0;
    for (const TileRange& list : to_host(renderer.backend(), renderer.lists().view().ranges))
      longest = std::max<std::size_t>(longest, list.end - list.begin);
    REQUIRE(longest >= vulkan::long_list);
    CHECK(same_planes(renderer.render(there, camera, lean), shared));
    const Frame alone = renderer.render(there, camera, with_planes());
    CHECK(same_bits(shared.depth, alone.depth));
    RenderSettings on_background = with_planes();
    on_background.outputs = lean.outputs;
    CHECK(same_bits(renderer.render(there, camera, on_background).colour, alone.colour));
    // Rounding may decide which splat stops a pixel that shows next to nothing.
    const Frame expected = serial.render(serial.backend().upload(scene), camera, lean);
    CHECK(max_abs_difference(shared.colour, expected.colour) < 1e-3);
    CHECK(max_abs_difference(shared.depth, expected.depth) < 1e-2);
    Renderer<Vulkan, EarlySort, AxisSharedThreshold<FloatCholesky>, OpacityBox> boxes;
    CHECK(same_planes(boxes.render(there, camera, lean), shared));
    // Several views of one frame, each with blocks of its own.
    const Camera cameras[] = {camera, forward_camera(37, 23)};
    const Frame other = renderer.render(there, cameras[1], lean);
    Frame both[2];
    renderer.set_scene(std::make_shared<const Scene>(scene));
    renderer.render({cameras, 2}, lean, {both, 2});
    CHECK(same_planes(both[0], shared));
    CHECK(same_planes(both[1], other));
  }
}

SWIFTGS_VULKAN_CASE("vulkan: more than 65,535 workgroups fill all words and none behind them") {
  Vulkan b;
  const std::size_t words = 65535 * std::size_t(vulkan::usual_threads) + 1;
  VulkanBuffer<std::uint32_t> filled;
  filled.reset(words + 1);
  vulkan::Commands commands(b);
  commands.fill(filled.data(), words + 1, 1);
  commands.fill(filled.data(), words, 7);
  commands.submit();
  const std::vector<std::uint32_t> found = to_host(b, std::as_const(filled).span());
  CHECK(std::count(found.begin(), found.end(), 7u) == std::ptrdiff_t(words));
  CHECK(found.back() == 1);
}

SWIFTGS_VULKAN_CASE("vulkan: sort_pairs is a stable sort by the low bits alone") {
  Vulkan b;
  Random random(4);
  const auto check = [&]<class Key>(std::size_t count, int bits, const Key&) {
    CAPTURE(count);
    CAPTURE(bits);
    std::vector<Key> keys(count);
    std::vector<std::uint32_t> values(count), order(count);
    const Key mask = bits >= int(8 * sizeof(Key)) ? Key(~Key(0)) : Key((Key(1) << bits) - 1);
    for (std::size_t i = 0; i < count; ++i)
      keys[i] = Key(random.bits()), values[i] = std::uint32_t(random.bits()), order[i] = std::uint32_t(i);
    Pairs<Vulkan, Key> pairs;
    pairs.reset(count);
    b.write(keys.data(), pairs.keys.data(), count * sizeof(Key));
    b.write(values.data(), pairs.values.data(), count * sizeof values[0]);
    b.sort_pairs(pairs, count, bits);
    std::stable_sort(order.begin(), order.end(),
                     [&](auto i, auto j) { return (keys[i] & mask) < (keys[j] & mask); });
    std::vector<std::uint32_t> expected;
    for (const std::uint32_t i : order) expected.push_back(values[i]);
    CHECK(to_host(b, std::as_const(pairs.values).span()) == expected);
  };
  for (const std::size_t count : {1, 31, 1024, 1025, 100003}) {
    for (const int bits : {1, 7, 16, 31, 32}) check(count, bits, std::uint32_t());
    check(count, 44, std::uint64_t());
  }
  check((1 << 20) + 3073, 8, std::uint32_t());  // as devices sort a million pairs and more
}

SWIFTGS_VULKAN_CASE("vulkan: splats that are wider than a thread of lavapipe has rounds are listed whole") {
  // Each splat of one row of tiles is followed by one of 127 rows, so one thread of a workgroup has all wide
  // rows.
  const int width = 65536, height = 2032;
  SplatSet splats;
  for (int pair = 0; pair < 17; ++pair) {
    splats.add(make_splat(32768, 8, 12'000, 1, 0, 1), float(2 * pair + 1));
    splats.add(make_splat(8, 1016, 400, 1, 0.5 * 3.141592653589793, 1), float(2 * pair + 2));
  }
  Serial serial;
  const HostLists expected =
      host_lists(serial, build_lists<EarlySort, Ellipse>(serial, splats.job(width, height)));
  REQUIRE(expected.ids.size() == 17 * (4096 + 127));
  Vulkan b;
  const SplatsOn<Vulkan> there(b, splats);
  CHECK(host_lists(b, build_lists<EarlySort, Ellipse>(b, there.job(width, height))) == expected);
}

SWIFTGS_VULKAN_CASE(
    "vulkan: a pick finds a splat behind more of its tile than a thread of lavapipe has rounds") {
  const std::size_t in_front = 70'000;
  Scene scene = random_scene(in_front + 1, 0, 15);
  for (std::size_t i = 0; i < in_front; ++i) {
    scene.means[i] = vec3(-0.4f, -0.4f, 2), scene.scales[i] = vec3(1e-3f);
    scene.opacities[i] = 0.5f;
  }
  scene.means[in_front] = vec3(0, 0, 3), scene.scales[in_front] = vec3(1);
  scene.opacities[in_front] = 0.9f;
  Camera camera = forward_camera(16, 16, 16);
  camera.cx = camera.cy = 8;
  UsualVulkan renderer;
  renderer.render(renderer.backend().upload(scene), camera);
  const PickedPixel picked = renderer.pick(8, 8);
  CHECK(picked.gaussian == in_front);
  CHECK(picked.depth == 3);
}

SWIFTGS_VULKAN_CASE("vulkan: a frame beyond its capacity is drawn again and timed") {
  UsualVulkan renderer;
  const Camera camera = builtin_camera(160, 90);
  RenderSettings settings;
  settings.time = true;
  for (const std::size_t gaussians : {100, 5000, 300, 0}) {
    const Scene scene = make_builtin_scene(gaussians);
    UsualVulkan fresh;
    const Frame frame = renderer.render(renderer.backend().upload(scene), camera, settings);
    CHECK(same_planes(frame, fresh.render(fresh.backend().upload(scene), camera)));
    CHECK(renderer.times().total > 0);
  }
  renderer.trim();
  CHECK(renderer.memory().total() == 0);
}

SWIFTGS_VULKAN_CASE("vulkan: a profile has the kernels of a frame in their order and changes no bit") {
  UsualVulkan renderer;
  const VulkanScene there = renderer.backend().upload(make_builtin_scene(500));
  const Camera camera = builtin_camera(80, 45);
  const Frame expected = renderer.render(there, camera);
  Frame frame;
  const auto kernels = renderer.backend().profile([&] { frame = renderer.render(there, camera); });
  CHECK(same_planes(frame, expected));
  const auto first = [&](std::string_view name) {
    return std::find_if(kernels.begin(), kernels.end(), [&](const auto& k) { return k.name == name; });
  };
  CHECK(first("project") < first("emit"));
  CHECK(first("emit") < first("raster"));
  REQUIRE(first("raster") != kernels.end());
  CHECK(first("raster")->milliseconds > 0);
  CHECK(renderer.backend().profile([] {}).empty());
}

}  // namespace swiftgs::test
