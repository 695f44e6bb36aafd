// SPDX-License-Identifier: Apache-2.0

// Commands whose views or cases several processes share write what one process writes.
#include <cstdlib>
#include <filesystem>
#include <string>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "cli/command.hpp"

using namespace swiftgs::test;
using nlohmann::json;
using namespace std::string_literals;

namespace {

const std::string tool = "'" SWIFTGS_CLI "' ";

/// Runs the launcher with `arguments`, a shell's.
Outcome launch(const TemporaryFolder& place, const std::string& arguments) {
  const std::string out = (place / "stdout.txt").string(), err = (place / "stderr.txt").string();
  const int status =
      std::system(("cd '" + place.path().string() + "' && export XDG_CACHE_HOME=\"$PWD/cache\" && '" +
                   SWIFTGS_LAUNCH "' " + arguments + " >'" + out + "' 2>'" + err + "'")
                      .c_str());
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, content_of(out), without_progress(content_of(err))};
}

/// Runs the tool on so many ranks.
Outcome on_ranks(const TemporaryFolder& place, int ranks, const std::string& arguments) {
  return launch(place, "-n " + std::to_string(ranks) + " " + tool + arguments);
}

/// Runs two commands as ranks 0 and 1. `first` and `second` are their parts of the launcher's command line.
Outcome on_unlike_ranks(const TemporaryFolder& place, const std::string& first, const std::string& second) {
  return launch(place, "-n 1 " + first + " : -n 1 " + second);
}

/// The rows of a result file without what differs from run to run.
json rows_of(const std::filesystem::path& file, const std::string& member = "rows") {
  json rows = json::parse(content_of(file)).at(member);
  for (json& row : rows)
    for (const char* changes : {"ms", "frames", "device_bytes", "host_bytes", "bytes", "image"})
      row.erase(changes);
  return rows;
}

}  // namespace

TEST_CASE("mpi team: render writes the images and rows of one process") {
  const TemporaryFolder place;
  const std::string what = "render builtin:3000 --views 0-10 --scale 0.1 --batch 2 --stats ";
  run(place, what + "--out one --json one.json");
  const Outcome shared = on_ranks(place, 3, what + "--out three --json three.json");
  CHECK(shared.code == 0);
  CHECK(shared.err == "");
  CHECK(rows_of(place / "one.json") == rows_of(place / "three.json"));
  CHECK(files_in(place / "one") == files_in(place / "three"));
  CHECK(files_in(place / "one").size() == 11);
  for (const std::string& name : files_in(place / "one"))
    CHECK(content_of(place / "one" / name) == content_of(place / "three" / name));
  // One process prints, in the order of the views.
  CHECK(shared.out.find("three/front.png") < shared.out.find("three/orbit-00.png"));
  CHECK(shared.out.find("three/orbit-00.png") < shared.out.find("three/orbit-09.png"));
  CHECK(contains(shared.out, "11 images with "));
}

TEST_CASE("mpi team: check and bench and stress and render of few views find the rows of one process") {
  const std::string stress =
      "stress --renderers serial/early/per-pixel/ellipse --severity max --seeds 1 --size 32x16 ";
  for (const std::string& what :
       {"render builtin:500 --views 0 --scale 0.05 "s,
        "check builtin:500 --views 0-4 --scale 0.05 --repeats 1 --renderers 'serial/early/*/ellipse' "s,
        "bench builtin:500 builtin:300 --views 0-3 --scales 0.05,0.08 --min-frames 2 --max-frames 2 "
        "--renderers 'serial/early/per-pixel/*' "s,
        stress}) {
    CAPTURE(what);
    const TemporaryFolder place;
    const Outcome one = run(place, what + "--json one.json"),
                  shared = on_ranks(place, 3, what + "--json three.json");
    CHECK(shared.code == 0);
    const bool bench = what.starts_with("bench");
    for (const char* member : {"rows", "views", "scenes"})
      if (bench || member == std::string("rows"))
        CHECK(rows_of(place / "one.json", member) == rows_of(place / "three.json", member));
    if (bench) CHECK(rows_of(place / "one.json").size() == 64);
    if (what.starts_with("check")) CHECK(lines_in(shared.out) == lines_in(one.out));
  }
}

TEST_CASE("mpi team: prune keeps the Gaussians that one process keeps") {
  const TemporaryFolder place;
  const std::string what = "prune builtin:2000 --keep 0.3 --views every:3 --scale 0.05 --backend serial ";
  run(place, what + "--out one.ply --json one.json");
  const Outcome shared = on_ranks(place, 3, what + "--out three.ply --json three.json");
  CHECK(shared.code == 0);
  CHECK(content_of(place / "one.ply") == content_of(place / "three.ply"));
  const auto sides = [&](const char* file) {
    json result = json::parse(content_of(place / file));
    for (const char* side : {"before", "after"}) result[side].erase("ms");
    for (const char* head : {"machine", "command"}) result.erase(head);
    return result;
  };
  CHECK(sides("one.json") == sides("three.json"));
}

TEST_CASE("mpi team: what all find wrong is said once and at once") {
  const TemporaryFolder place;
  const Outcome missing = on_ranks(place, 3, "render nowhere.ply");
  CHECK(missing.code == 1);
  CHECK(contains(missing.err, "swiftgs: rank 0 of 3: nowhere.ply: No such file or directory\n"));
  CHECK(!contains(missing.err, "rank 1 of 3"));
  const Outcome mistyped = on_ranks(place, 3, "render builtin --vievs 3");
  CHECK(mistyped.code == 1);
  const std::size_t first = mistyped.err.find("swiftgs: render: '--vievs' is not expected");
  CHECK(first != std::string::npos);
  CHECK(mistyped.err.find("swiftgs: render: '--vievs'", first + 1) == std::string::npos);
}

TEST_CASE("mpi team: an error of a file is told as by one process") {
  const TemporaryFolder place;
  place.write("a/file", "");  // in the way of the folder for images
  const std::string what = "render builtin:500 --scale 0.05 --views 0-5 --out a/file/renders";
  const Outcome one = swiftgs::test::swiftgs(place, what), shared = on_ranks(place, 2, what);
  CHECK(one.code == 1);
  CHECK(shared.code == 1);
  CHECK(one.err.starts_with("swiftgs: "));
  CAPTURE(shared.err);
  CHECK(contains(shared.err, "swiftgs: rank 0 of 2: " + one.err.substr(9)));
}

TEST_CASE("mpi team: files and builds and commands that differ are refused at the start") {
  const TemporaryFolder place;
  std::filesystem::create_directories(place / "a");
  std::filesystem::create_directories(place / "b");
  run(place, "convert builtin:2000 a/scene.ply");
  run(place, "convert builtin:2001 b/scene.ply");
  const std::string render = "render scene.ply --scale 0.05";
  const Outcome files = on_unlike_ranks(place, "-wdir a " + tool + render, "-wdir b " + tool + render);
  CHECK(files.code == 1);
  CHECK(contains(files.err, "swiftgs: rank 0 of 2: scene.ply is '"));
  CHECK(contains(files.err, "' on rank 1, expected '"));

  const Outcome commands =
      on_unlike_ranks(place, "-wdir a " + tool + render, "-wdir a " + tool + render + " --batch 2");
  CHECK(commands.code == 1);
  CHECK(contains(commands.err,
                 "the command is 'render scene.ply --scale 0.05 --batch 2' on rank 1, expected "
                 "'render scene.ply --scale 0.05' as on rank 0"));

  std::filesystem::copy_file(SWIFTGS_CLI, place / "other");
  std::system(("echo >>'" + (place / "other").string() + "'").c_str());
  const Outcome builds = on_unlike_ranks(place, "-wdir a " + tool + render, "-wdir a ../other " + render);
  CHECK(builds.code == 1);
  CHECK(contains(builds.err, "the build of the tool is '"));
  CHECK(std::filesystem::is_empty(place / "a") == false);
  CHECK(!std::filesystem::exists(place / "a/renders"));
}

TEST_CASE("mpi team: photographs that differ are refused before anything is drawn") {
  const TemporaryFolder place;
  for (const std::string folder : {"a", "same", "other", "fewer", "renamed"})
    run(place, std::string("render builtin:") + (folder == "other" ? "501" : "500") +
                   " --views 0-2 --scale 0.05 --out " + folder + "/photos");
  std::filesystem::remove(place / "fewer/photos/orbit-00.png");
  std::filesystem::rename(place / "renamed/photos/front.png", place / "renamed/photos/front.PNG");
  std::filesystem::create_directories(place / "none/photos");
  const auto compare = [&](const std::string& command, const std::string& folder) {
    const std::string run_it = " " + tool + command + " --scale 0.05 --photos photos --json r.json";
    const Outcome outcome = on_unlike_ranks(place, "-wdir a" + run_it, "-wdir " + folder + run_it);
    const bool written = std::filesystem::remove(place / "a/r.json");
    CHECK(written == (outcome.code == 0));
    return outcome;
  };
  const std::string check =
      "check builtin:500 --views 0-2 --repeats 1 --renderers serial/early/per-pixel/ellipse";
  CHECK(compare(check, "same").code == 0);
  const auto refuses = [&](const std::string& command, const std::string& folder, const std::string& says) {
    CAPTURE(folder);
    const Outcome outcome = compare(command, folder);
    CHECK(outcome.code == 1);
    CHECK(contains(outcome.err, "swiftgs: rank 0 of 2: photos" + says));
  };
  refuses(check, "other", "/front.png is '");
  refuses(check, "fewer",
          ": the photograph of orbit-00 is 'none' on rank 1, expected 'photos/orbit-00.png' as on rank 0\n");
  refuses(check, "renamed", ": the photograph of front is 'photos/front.PNG' on rank 1, expected ");
  refuses(check, "none", ": the photograph of front is 'none' on rank 1, expected 'photos/front.png'");
  const std::string prune = "prune builtin:500 --keep 0.5 --views 3-10 --backend serial --out small.ply";
  refuses(prune, "other", "/front.png is '");
}
