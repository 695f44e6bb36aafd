// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstring>
#include <numeric>
#include <set>
#include <string>
#include <vector>

#include <doctest/doctest.h>
#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <swiftgs/error.hpp>
#include <swiftgs/io/scene_file.hpp>
#include <swiftgs/tools/split_mix.hpp>

#include "pages/scenes.hpp"

namespace swiftgs::test::build_of_pages {
namespace {

/// Pages in spatial order, by so little memory that files of records are split.
PageBuildOptions with_order() {
  PageBuildOptions options = small_pages();
  options.order = true, options.memory = 4 << 20;
  return options;
}

TEST_CASE("pages: leaves keep the Gaussians of the source in their order") {
  const TemporaryFolder folder;
  const Scene scene = ordered_scene(5000);
  const PagedScene pages = pages_of(folder, scene);
  CHECK(pages.gaussians() == 5000);
  CHECK(pages.pages().size == 2 * 20 - 1);
  check_same(read_leaves(pages), scene);
  CHECK(files_in(folder.path()) == std::set<std::string>{"scene.sgp"});
}

TEST_CASE("pages: ordered leaves have all Gaussians once and tell their numbers") {
  const TemporaryFolder folder;
  const Scene scene = make_builtin_scene(30000);
  const PagedScene pages = pages_of(folder, scene, with_order());
  std::vector<std::uint32_t> ids;
  for (std::uint32_t i = 0; i < pages.pages().size; ++i)
    if (pages.pages()[i].is_leaf()) {
      const PageContent content = pages.read(i);
      ids.insert(ids.end(), content.ids.begin(), content.ids.end());
    }
  check_same(read_leaves(pages), subset(scene, ids));
  std::sort(ids.begin(), ids.end());
  std::vector<std::uint32_t> all(scene.size());
  std::iota(all.begin(), all.end(), 0u);
  CHECK(ids == all);
  // Neighbours share pages: leaves are much smaller than the scene.
  const auto side = [](const Page& page) {
    const vec3 sides = page.bounds.high - page.bounds.low;
    return std::cbrt(double(sides.x) * double(sides.y) * double(sides.z));
  };
  std::vector<double> sides;
  for (const Page& page : pages.pages())
    if (page.is_leaf()) sides.push_back(side(page));
  std::nth_element(sides.begin(), sides.begin() + 60, sides.end());
  CHECK(sides[60] < 0.1 * side(pages.pages()[pages.root()]));
}

TEST_CASE("pages: numbers whose squares leave the range of float merge, and the file opens") {
  const TemporaryFolder folder;
  Scene scene = make_builtin_scene(1000);
  for (vec3& mean : scene.means) mean *= 1e25f;
  const PagedScene pages = pages_of(folder, scene);
  for (std::uint32_t i = 0; i < pages.pages().size; ++i) CHECK(pages.read(i).scene.size() != 0);
  check_same(read_leaves(pages), scene);
}

TEST_CASE("pages: an opacity above 1 is refused by its Gaussian") {
  const TemporaryFolder folder;
  Scene scene = make_builtin_scene(300);
  scene.opacities[7] = 1.5f;
  CHECK_THROWS_WITH_AS(build_pages(scene, folder / "a.sgp", small_pages()),
                       "opacities[7] is 1.500000, expected 0 to 1", InvalidArgument);
}

TEST_CASE("pages: little memory and many threads make the same file") {
  const TemporaryFolder folder;
  const Scene scene = ordered_scene(20000);
  const auto built = [&](int threads, std::size_t memory, bool order) {
    build_pages(scene, folder / "a.sgp",
                {.page_size = 256, .order = order, .memory = memory, .threads = threads});
    return content_of(folder / "a.sgp");
  };
  CHECK((built(1, 64 << 20, false) == built(3, 4 << 20, false)));
  CHECK((built(1, 4 << 20, true) == built(3, 4 << 20, true)));
}

TEST_CASE("pages: a parent has half as many nodes of about the same mass and mean") {
  const TemporaryFolder folder;
  const PagedScene pages = pages_of(folder, ordered_scene(4000));
  const auto area = [](const vec3& s) { return double(s.x * s.y + s.y * s.z + s.z * s.x); };
  const auto mean = [&](const Scene& scene) {
    dvec3 sum(0.0);
    double mass = 0;
    for (std::size_t i = 0; i < scene.size(); ++i) {
      const double m = double(scene.opacities[i]) * area(scene.scales[i]);
      sum += m * dvec3(scene.means[i]), mass += m;
    }
    return sum / mass;
  };
  const auto all = pages.pages();
  for (const Page& page : all) {
    if (page.is_leaf()) continue;
    const Page &left = all[page.left], &right = all[page.right];
    CHECK(page.count == (left.count + right.count + 1) / 2);
    CHECK(page.error_at(1e-3) > 0);
    for (std::size_t k = 0; k < Page::error_count; ++k)
      CHECK(page.errors[k] <= glm::distance(page.bounds.low, page.bounds.high));
  }
  const Scene root = pages.read(pages.root()).scene, leaves = read_leaves(pages);
  CHECK(glm::distance(mean(root), mean(leaves)) < 20);  // of a scene of 190 m to each side
  for (const Quaternion& q : root.rotations)
    CHECK(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z == doctest::Approx(1));
}

TEST_CASE("pages: Gaussians that show nothing or lie on each other can be merged") {
  const TemporaryFolder folder;
  Scene scene = ordered_scene(1000);
  for (std::size_t i = 0; i < 500; ++i) scene.opacities[i] = 0, scene.scales[i] = vec3(0);
  for (std::size_t i = 400; i < 700; ++i) scene.means[i] = scene.means[400];
  const PagedScene pages = pages_of(folder, scene);
  for (std::uint32_t i = 0; i < pages.pages().size; ++i) validate_numbers(pages.read(i).scene);
}

TEST_CASE("pages: several files become one with the origin of the first") {
  const TemporaryFolder folder;
  write_scene(folder / "a.ply", with_degree(ordered_scene(700), 1));
  write_scene(folder / "b.ply", ordered_scene(500));
  const BuiltPages built =
      build_pages({folder / "a.ply", folder / "b.ply"}, folder / "ab.sgp", small_pages());
  CHECK(built.gaussians == 1200);
  CHECK(built.leaves == 5);
  CHECK(built.bytes == std::filesystem::file_size(folder / "ab.sgp"));
  Scene a = load_scene(folder / "a.ply");
  append(a, load_scene(folder / "b.ply"));
  check_same(read_leaves(open_pages(folder / "ab.sgp")), a);
}

TEST_CASE("pages: Gaussians that a file read in parts leaves out are counted once") {
  const TemporaryFolder folder;
  write_scene(folder / "a.ply", ordered_scene(6000));
  std::string text = content_of(folder / "a.ply");
  const std::size_t row = 62 * sizeof(float);  // of mean, normal, harmonics, opacity, scale and rotation
  const float infinite = INFINITY;
  for (const std::size_t back : {1, 3000, 6000})
    std::memcpy(text.data() + text.size() - back * row, &infinite, sizeof infinite);
  folder.write("a.ply", text);
  PageBuildOptions options = small_pages();
  options.memory = 4 << 20;
  const BuiltPages built = build_pages({folder / "a.ply"}, folder / "a.sgp", options);
  CHECK(built.gaussians == 5997);
  CHECK(built.notes == std::vector<std::string>{"Gaussians with a NaN or an infinity are left out: 3."});
}

TEST_CASE("pages: signs of scales that parts of a source lose are counted once") {
  const TemporaryFolder folder;
  write_scene(folder / "a.splat", make_builtin_scene(9000));
  std::string text = content_of(folder / "a.splat");
  for (const std::size_t row : {0, 4000, 8999}) {  // a row has a mean and scales first
    float scale = 0;
    std::memcpy(&scale, text.data() + 32 * row + 12, sizeof scale);
    scale = -scale;
    std::memcpy(text.data() + 32 * row + 12, &scale, sizeof scale);
  }
  folder.write("a.splat", text);
  PageBuildOptions options = small_pages();
  options.memory = 4 << 20;
  CHECK(build_pages({folder / "a.splat"}, folder / "a.sgp", options).notes ==
        std::vector<std::string>{"Scales below 0 are taken without their sign, of Gaussians: 3."});
}

TEST_CASE("pages: a build that is refused leaves nothing behind") {
  const TemporaryFolder folder;
  const Scene scene = ordered_scene(3000);
  const auto refused = [&](const Scene& of, const PageBuildOptions& with) {
    CHECK_THROWS_AS(build_pages(of, folder / "a.sgp", with), InvalidArgument);
  };
  refused(Scene(), small_pages());
  refused(scene, {.page_size = 100});
  refused(scene, {.memory = 1 << 20});
  Scene featured = scene;
  featured.feature_channels = 1, featured.features.resize(scene.size());
  refused(featured, small_pages());
  CHECK(files_in(folder.path()).empty());
}

TEST_CASE("pages: a build cancelled before its first page leaves nothing and progress of others rises to 1") {
  const TemporaryFolder folder;
  write_scene(folder / "a.ply", ordered_scene(3000));
  const auto mode = [&](const char* name) {
    return unsigned(std::filesystem::status(folder / name).permissions());
  };
  PageBuildOptions options = small_pages();
  options.progress = [](double) { return false; };
  CHECK_THROWS_WITH_AS(build_pages({folder / "a.ply"}, folder / "a.sgp", options),
                       (folder / "a.sgp: cancelled").c_str(), Cancelled);
  CHECK(files_in(folder.path()) == std::set<std::string>{"a.ply"});
  std::vector<double> told{0};
  options.progress = [&](double part) {
    CHECK(mode("a.sgp.unfinished") + mode("a.sgp.unfinished.steps") == 2 * 0600);
    return told.push_back(part), true;
  };
  build_pages({folder / "a.ply"}, folder / "a.sgp", options);
  CHECK(told.size() > 12);
  told.push_back(1);
  CHECK(std::is_sorted(told.begin(), told.end()));
  CHECK(mode("a.sgp") == mode("a.ply"));
  std::filesystem::permissions(folder / "a.sgp", std::filesystem::perms(0640));
  build_pages({folder / "a.ply"}, folder / "a.sgp", small_pages());
  CHECK(mode("a.sgp") == 0640);
}

TEST_CASE("pages: files that no build made are refused and left as they are") {
  for (const std::string name : {"a.sgp.unfinished", "a.sgp.unfinished.steps"})
    for (const bool linked : {false, true}) {
      const TemporaryFolder folder;
      folder.write(name, "notes, longer than a header");
      if (linked) std::filesystem::create_hard_link(folder / name, folder / "other");
      const std::string expected =
          linked ? "a regular file of this user with one name" : "what a build of pages left";
      CHECK_THROWS_WITH_AS(build_pages(ordered_scene(500), folder / "a.sgp", small_pages()),
                           ((folder / name).string() + ": expected none, or " + expected).c_str(),
                           InvalidArgument);
      CHECK(content_of(folder / name) == "notes, longer than a header");
      CHECK(files_in(folder.path()).size() == (linked ? 2 : 1));
    }
}

TEST_CASE("pages: files of a build lie beside what a link leads to") {
  const TemporaryFolder folder;
  const int file = ::open((folder / "a.sgp").c_str(), O_CREAT | O_RDWR | O_CLOEXEC, 0600);
  REQUIRE(file >= 0);
  // A link in a folder that takes no files.
  build_pages(ordered_scene(1000), "/proc/self/fd/" + std::to_string(file), small_pages());
  ::close(file);
  CHECK(open_pages(folder / "a.sgp").gaussians() == 1000);
  CHECK(files_in(folder.path()) == std::set<std::string>{"a.sgp"});
}

/// Runs `build` in a process of its own and returns how that ended, as `waitpid` tells.
template <class Build>
int status_of(const Build& build) {
  const pid_t child = ::fork();
  REQUIRE(child >= 0);
  if (child == 0) {
    try {
      build();
    } catch (const FileError&) {
      ::_exit(3);
    } catch (...) {
    }
    ::_exit(0);
  }
  int status = 0;
  REQUIRE(::waitpid(child, &status, 0) == child);
  return status;
}

Scene resumed_scene() {
  Scene scene = make_builtin_scene(6000);
  // Signs of 0, which a page need not keep; and all zeros, whose bands it leaves out.
  for (std::size_t i = 0; i < scene.sh_rest.size() / 2; ++i)
    if (i % 3 != 0 || i < 45 * 500) scene.sh_rest[i] = i % 2 == 0 ? -0.0f : 0.0f;
  return scene;
}

TEST_CASE("pages: a build that is killed anywhere twice resumes and writes the bytes of a whole one") {
  const TemporaryFolder folder;
  const Scene scene = resumed_scene();
  const std::string old = "what was there";
  for (const bool order : {false, true}) {
    const PageBuildOptions options = order ? with_order() : small_pages();
    const std::size_t pages = build_pages(scene, folder / "whole.sgp", options).pages;
    const std::string whole = content_of(folder / "whole.sgp");
    std::size_t last = 0;
    for (const double part : {0.3, 0.4, 0.55, 0.8, 1.0}) {
      folder.write("a.sgp", old);
      PageBuildOptions killed = options;
      for (const double until : {part, (part + 1) / 2}) {
        killed.progress = [until](double done) { return done < until || ::raise(SIGKILL) == 0; };
        CHECK(WTERMSIG(status_of([&] { build_pages(scene, folder / "a.sgp", killed); })) == SIGKILL);
      }
      CHECK(content_of(folder / "a.sgp") == old);
      const BuiltPages built = build_pages(scene, folder / "a.sgp", options);
      INFO("order ", order, ", part ", part);
      CHECK(built.resumed > last);
      CHECK(built.resumed < pages);
      CHECK(built.pages == pages);
      CHECK(built.notes.empty());
      CHECK((content_of(folder / "a.sgp") == whole));
      CHECK(files_in(folder.path()) == std::set<std::string>{"a.sgp", "whole.sgp"});
      last = built.resumed;
    }
  }
}

TEST_CASE("pages: a build whose disk is full or whose file has no place resumes where it has") {
  const TemporaryFolder folder;
  const Scene scene = resumed_scene();
  const std::size_t pages = build_pages(scene, folder / "whole.sgp", small_pages()).pages;
  const int status = status_of([&] {
    ::signal(SIGXFSZ, SIG_IGN);
    const rlimit most{2'000'000, 2'000'000};
    ::setrlimit(RLIMIT_FSIZE, &most);
    build_pages(scene, folder / "a.sgp", small_pages());
  });
  CHECK(WEXITSTATUS(status) == 3);
  CHECK(build_pages(scene, folder / "a.sgp", small_pages()).resumed > 10);
  CHECK((content_of(folder / "a.sgp") == content_of(folder / "whole.sgp")));
  PageBuildOptions options = small_pages();
  options.progress = [&](double) { return std::filesystem::create_directories(folder / "b.sgp/in"), true; };
  CHECK_THROWS_AS(build_pages(scene, folder / "b.sgp", options), FileError);
  std::filesystem::remove_all(folder / "b.sgp");
  CHECK(build_pages(scene, folder / "b.sgp", small_pages()).resumed == pages);
  CHECK((content_of(folder / "b.sgp") == content_of(folder / "whole.sgp")));
}

TEST_CASE("pages: what an unfinished build left is used only where it is whole and of the same build") {
  const TemporaryFolder folder;
  const Scene scene = resumed_scene();
  const PageBuildOptions options = with_order();
  const std::size_t pages = build_pages(scene, folder / "whole.sgp", options).pages;
  const std::string whole = content_of(folder / "whole.sgp");
  PageBuildOptions cancelled = options;
  cancelled.progress = [](double done) { return done < 0.8; };
  CHECK_THROWS_WITH_AS(build_pages(scene, folder / "a.sgp", cancelled),
                       doctest::Contains("steps remain: the same build resumes"), Cancelled);
  const std::string names[]{"a.sgp.unfinished", "a.sgp.unfinished.steps"};
  std::string left[]{content_of(folder / names[0]), content_of(folder / names[1])};
  CHECK(is_page_file(folder / names[0]) == false);
  cancelled.progress = [](double done) { return done > 0.34; };  // while it looks at what is left
  CHECK_THROWS_AS(build_pages(scene, folder / "a.sgp", cancelled), Cancelled);
  CHECK((content_of(folder / names[0]) == left[0] && content_of(folder / names[1]) == left[1]));
  // Builds where an earlier build left these files, one of them with other content.
  const auto built_on = [&](int file, const std::string& content, const Scene& of,
                            const PageBuildOptions& by) {
    folder.write(names[1 - file], left[1 - file]), folder.write(names[file], content);
    return build_pages(of, folder / "a.sgp", by);
  };
  SplitMix64 random(3);
  std::size_t all = built_on(0, left[0], scene, options).resumed, most = 0, least = pages;
  CHECK(all > pages / 2);
  for (int k = 0; k < 60; ++k) {
    std::string broken = left[k % 2];
    const std::size_t at = random.bits() % broken.size();
    if (k % 3 == 0)
      broken.resize(at);
    else
      broken[at] = char(broken[at] ^ (1 << random.bits() % 8));
    const std::size_t resumed = built_on(k % 2, broken, scene, options).resumed;
    most = std::max(most, resumed), least = std::min(least, resumed);
    INFO("file ", k % 2, ", byte ", at);
    CHECK((content_of(folder / "a.sgp") == whole));
  }
  CHECK(least < all / 4);
  CHECK(most <= all);
  CHECK(files_in(folder.path()) == std::set<std::string>{"a.sgp", "whole.sgp"});

  const std::string note =
      (folder / "a.sgp").string() + ".unfinished was of other Gaussians, options or version: it began anew.";
  Scene other = scene;
  other.opacities.back() *= 0.5f;
  PageBuildOptions larger = options;
  larger.page_size = 512, larger.memory = 8 << 20;
  for (const BuiltPages& built :
       {built_on(0, left[0], other, options), built_on(0, left[0], scene, larger)}) {
    CHECK(built.resumed == 0);
    CHECK(built.notes == std::vector<std::string>{note});
  }
  // Steps of one build behind the key of another, as of another algorithm.
  larger.progress = [](double done) { return done < 0.8; };
  CHECK_THROWS_AS(build_pages(scene, folder / "b.sgp", larger), Cancelled);
  larger.progress = {};
  left[1].replace(0, 16, content_of(folder / "b.sgp.unfinished.steps"), 0, 16);
  CHECK(built_on(1, left[1], scene, larger).resumed == 0);
  build_pages(scene, folder / "b.sgp", larger);
  CHECK((content_of(folder / "a.sgp") == content_of(folder / "b.sgp")));
}

TEST_CASE("pages: two builds of one file at a time are refused") {
  const TemporaryFolder folder;
  const Scene scene = ordered_scene(1000);
  PageBuildOptions options = small_pages();
  options.progress = [&](double) {
    CHECK_THROWS_WITH_AS(
        build_pages(scene, folder / "a.sgp", small_pages()),
        doctest::Contains("a.sgp.unfinished.steps: another build writes it, expected one at a time"),
        InvalidArgument);
    return true;
  };
  build_pages(scene, folder / "a.sgp", options);
  CHECK(files_in(folder.path()) == std::set<std::string>{"a.sgp"});
}

}  // namespace
}  // namespace swiftgs::test::build_of_pages
