// SPDX-License-Identifier: Apache-2.0
#include <iostream>

#include <swiftgs/camera.hpp>
#include <swiftgs/scene.hpp>
#include <swiftgs/version.hpp>

int main() {
  swiftgs::Scene scene;
  scene.means.push_back({0, 0, 2});
  scene.scales.push_back({1, 1, 1});
  scene.rotations.push_back({});
  scene.opacities.push_back(0.5f);
  scene.sh0.push_back({1, 1, 1});
  swiftgs::validate(scene);
  const swiftgs::Camera camera = swiftgs::look_at({0, 0, 0}, {0, 0, 1}, {0, -1, 0}, 1, 64, 48);
  std::cout << "swiftgs " << swiftgs::version << ": " << swiftgs::view(scene).size() << " Gaussian, "
            << camera.width << " x " << camera.height << " pixels\n";
}
