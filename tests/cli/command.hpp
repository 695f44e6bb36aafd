// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include <unistd.h>

#ifdef __unix__
#include <sys/wait.h>
#endif

namespace swiftgs::test {

/// A folder of its own that is removed at the end.
class Workplace {
 public:
  Workplace() {
    static int count = 0;
    path_ = std::filesystem::temp_directory_path() /
            ("swiftgs-cli-" + std::to_string(getpid()) + "-" + std::to_string(count++));
    std::filesystem::create_directories(path_);
  }
  ~Workplace() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  Workplace(const Workplace&) = delete;
  Workplace& operator=(const Workplace&) = delete;

  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

inline std::string contents_of(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

inline void write_file(const std::filesystem::path& file, const std::string& contents) {
  std::ofstream(file, std::ios::binary) << contents;
}

inline std::ptrdiff_t lines_in(const std::string& text) { return std::count(text.begin(), text.end(), '\n'); }

/// What a command said and how it ended.
struct Outcome {
  int code = -1;  ///< -1 if it was killed
  std::string out, err;
};

/// Runs the tool in `place`; `arguments` are a shell's.
inline Outcome swiftgs(const Workplace& place, const std::string& arguments) {
  const std::string out = (place / "stdout.txt").string(), err = (place / "stderr.txt").string();
  const int status = std::system(("cd '" + place.path().string() + "' && '" SWIFTGS_CLI "' " + arguments +
                                  " >'" + out + "' 2>'" + err + "'")
                                     .c_str());
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, contents_of(out), contents_of(err)};
}

}  // namespace swiftgs::test
