// SPDX-License-Identifier: Apache-2.0
#include "view_sizes.hpp"

#include <map>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>

namespace swiftgs::cli {

std::vector<SizeGroup> group_by_size(const Cameras& cameras, const ViewOptions& options,
                                     const std::vector<double>& scales) {
  using Size = std::pair<int, int>;
  const auto size_of = [](const View& view) { return Size(view.camera.width, view.camera.height); };
  std::map<Size, SizeGroup> sizes;
  std::set<std::pair<std::string, Size>> known;
  for (const double scale : scales) {
    ViewOptions view = options;
    view.scale = scale, view.views = "all";
    for (View& each : views_of(cameras, view, "all")) {
      const Size size = size_of(each);
      if (!known.emplace(each.name, size).second)
        throw std::invalid_argument("--scale: expected factors that give different sizes, found " +
                                    std::to_string(size.first) + "x" + std::to_string(size.second) +
                                    " twice for the view " + each.name);
      sizes[size].views.push_back(std::move(each));
    }
    if (options.views.empty()) continue;
    view.views = options.views;
    for (View& each : views_of(cameras, view, "all")) sizes[size_of(each)].checked.push_back(std::move(each));
  }
  std::vector<SizeGroup> groups;
  for (auto& [size, group] : sizes) groups.push_back(std::move(group));
  return groups;
}

}  // namespace swiftgs::cli
