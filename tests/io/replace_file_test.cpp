// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <fstream>
#include <stdexcept>
#include <string>
#include <system_error>
#include <vector>

#include <doctest/doctest.h>
#include <fcntl.h>
#include <sys/inotify.h>
#include <sys/stat.h>
#include <unistd.h>

#include <swiftgs/io/replace_file.hpp>

#include "support/files.hpp"
#include "support/skip.hpp"

namespace swiftgs::test::replace_file_test {

namespace fs = std::filesystem;

TEST_CASE("replace file: content is new or takes the place of what was there") {
  const TemporaryFolder place;
  for (const std::string content : {"first", "second", ""}) {
    replace_file(place / "new.txt", content);
    CHECK(content_of(place / "new.txt") == content);
  }
  CHECK(files_in(place.path()).size() == 1);
}

TEST_CASE("replace file: a file that takes no other's place never has another name") {
  const TemporaryFolder place;
  const int unnamed = ::open(place.path().c_str(), O_TMPFILE | O_WRONLY, 0600);
  if (unnamed < 0) return skip("this file system has no files without a name");
  ::close(unnamed);
  const int watch = ::inotify_init1(IN_NONBLOCK);
  CHECK(::inotify_add_watch(watch, place.path().c_str(), IN_CREATE | IN_MOVED_TO | IN_DELETE) >= 0);
  replace_file(place / "new.txt", "first");
  alignas(inotify_event) std::array<char, 4096> events{};
  const ::ssize_t bytes = ::read(watch, events.data(), events.size());
  ::close(watch);
  std::vector<std::string> names;
  for (::ssize_t at = 0; at < bytes;) {
    const auto* event = reinterpret_cast<const inotify_event*>(events.data() + at);
    names.emplace_back(event->name);
    at += ::ssize_t(sizeof(inotify_event) + event->len);
  }
  CHECK(names == std::vector<std::string>{"new.txt"});
}

TEST_CASE("replace file: a file is as it was where writing ends half way or is only asked about") {
  const TemporaryFolder place;
  place.write("old.txt", "old");
  require_replaceable(place / "old.txt"), require_replaceable(place / "none.txt");
  CHECK(content_of(place / "old.txt") == "old");
  CHECK(files_in(place.path()).size() == 1);
  for (const char* name : {"old.txt", "none.txt"})
    CHECK_THROWS_WITH_AS(replace_file(place / name,
                                      [](const fs::path& file) {
                                        std::ofstream(file) << "half";
                                        throw std::runtime_error("stopped");
                                      }),
                         "stopped", std::runtime_error);
  CHECK(content_of(place / "old.txt") == "old");
  CHECK(files_in(place.path()).size() == 1);
}

TEST_CASE("replace file: the new file has the permissions of the old one") {
  const TemporaryFolder place;
  const fs::path path = place.write("secret.txt", "old");
  for (const fs::perms permissions : {fs::perms(0600), fs::perms(0664), fs::perms(0444)}) {
    fs::permissions(path, permissions);
    replace_file(path, "new");
    CHECK(content_of(path) == "new");
    CHECK(fs::status(path).permissions() == permissions);
  }
}

TEST_CASE("replace file: whoever reads meanwhile has the old file") {
  const TemporaryFolder place;
  const fs::path path = place.write("file.txt", "old");
  replace_file(path, [&](const fs::path& file) {
    CHECK(file.parent_path() == path.parent_path());
    std::ofstream(file) << "new";
    CHECK(content_of(path) == "old");
  });
  CHECK(content_of(path) == "new");
}

TEST_CASE("replace file: a link stays and leads to the new file") {
  const TemporaryFolder place;
  place.write("folder/file.txt", "old");
  fs::create_symlink("folder/file.txt", place / "link.txt");
  replace_file(place / "link.txt", "new");
  CHECK(fs::is_symlink(place / "link.txt"));
  CHECK(content_of(place / "folder/file.txt") == "new");
}

TEST_CASE("replace file: a link to what is not there yet stays and leads to the new file") {
  const TemporaryFolder place;
  fs::create_directories(place / "folder");
  fs::create_symlink("folder/file.txt", place / "link.txt");
  fs::create_symlink(place / "link.txt", place / "folder/chain.txt");
  require_replaceable(place / "folder/chain.txt");
  CHECK(!fs::exists(place / "folder/file.txt"));
  for (const std::string content : {"first", "second"})
    for (const char* name : {"link.txt", "folder/chain.txt"}) {
      replace_file(place / name, content + name);
      CHECK(fs::is_symlink(place / name));
      CHECK(content_of(place / "folder/file.txt") == content + name);
      if (content == "first") fs::remove(place / "folder/file.txt");
    }
  CHECK(files_in(place / "folder").size() == 2);
}

TEST_CASE("replace file: links that lead nowhere are refused and stay") {
  const TemporaryFolder place;
  fs::create_symlink("missing/file.txt", place / "lost.txt");
  fs::create_symlink("round.txt", place / "round.txt");
  const std::string told[][2] = {{"lost.txt", "lost.txt: No such file"},
                                 {"round.txt", "round.txt: Too many levels of symbolic links"}};
  for (const auto& [name, reason] : told) {
    const fs::path path = place / name;
    const char* const expected = reason.c_str();
    CHECK_THROWS_WITH_AS(require_replaceable(path), doctest::Contains(expected), std::system_error);
    CHECK_THROWS_WITH_AS(replace_file(path, "text"), doctest::Contains(expected), std::system_error);
    CHECK(fs::is_symlink(path));
  }
  CHECK(files_in(place.path()).size() == 2);
}

TEST_CASE("replace file: a pipe stays a pipe and is written to") {
  const TemporaryFolder place;
  const fs::path pipe = place / "pipe";
  REQUIRE(::mkfifo(pipe.c_str(), 0600) == 0);
  const int reader = ::open(pipe.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  REQUIRE(reader >= 0);
  require_replaceable(pipe);
  replace_file(pipe, "text");
  CHECK(fs::is_fifo(pipe));
  std::array<char, 16> read{};
  CHECK(::read(reader, read.data(), read.size()) == 4);
  CHECK(std::string(read.data()) == "text");
  ::close(reader);
  CHECK(files_in(place.path()).size() == 1);
}

TEST_CASE("replace file: what cannot be written is named before and while writing") {
  const TemporaryFolder place;
  fs::create_directory(place / "folder");
  place.write("file", "");
  const auto message_of = [](const auto& act) -> std::string {
    try {
      act();
    } catch (const std::system_error& error) {
      return error.what();
    }
    return "no error";
  };
  const char* cases[][2] = {{"folder", "folder: Is a directory"},
                            {"missing/a.txt", "missing/a.txt: No such file"},
                            {"file/a.txt", "file/a.txt: Not a directory"}};
  for (const auto& [name, reason] : cases) {
    const std::filesystem::path path = place / name;
    const std::string before = message_of([&] { require_replaceable(path); });
    const std::string during = message_of([&] { replace_file(path, "text"); });
    CAPTURE(before);
    CHECK(before.find(reason) != std::string::npos);
    CHECK(during == before);
  }
}

}  // namespace swiftgs::test::replace_file_test
