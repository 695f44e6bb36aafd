// SPDX-License-Identifier: Apache-2.0
#include "bench/machine.hpp"

#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <memory>
#include <string_view>
#include <thread>

#include <malloc.h>
#include <unistd.h>

#include <swiftgs/tools/processor.hpp>
#include <swiftgs/version.hpp>

#include "build_stamp.hpp"
#include "words.hpp"

namespace swiftgs::cli {
namespace {

constexpr double kib_a_gib = 1024.0 * 1024.0;

std::string trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t\"\n");
  if (first == std::string_view::npos) return {};
  return std::string(text.substr(first, text.find_last_not_of(" \t\"\n") - first + 1));
}

/// What follows `key` and `separator` in the first line of `file` that begins with `key`.
std::string value_in(const char* file, std::string_view key, char separator) {
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);)
    if (line.starts_with(key))
      if (const std::size_t at = line.find(separator); at != std::string::npos)
        return trimmed(line.substr(at + 1));
  return "unknown";
}

double number_in(const char* file, std::string_view key) {
  return std::strtod(value_in(file, key, ':').c_str(), nullptr);
}

std::string today() {
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  gmtime_r(&now, &utc);
  char text[16];
  std::strftime(text, sizeof text, "%Y-%m-%d", &utc);
  return text;
}

/// First line that `command` prints, or nothing where it fails.
std::string answer_of(const char* command) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> pipe(popen(command, "r"), pclose);
  char line[256];
  return pipe && std::fgets(line, sizeof line, pipe.get()) ? trimmed(line) : std::string();
}

std::optional<Machine::Gpu> describe_gpu() {
  if (std::string_view(stamp::cuda).empty()) return std::nullopt;
  const std::string answer = answer_of(
      "nvidia-smi --query-gpu=driver_version,memory.total,name --format=csv,noheader,nounits 2>/dev/null");
  const std::size_t first = answer.find(','), second = answer.find(',', first + 1);
  if (first == std::string::npos || second == std::string::npos) return std::nullopt;
  return Machine::Gpu{trimmed(answer.substr(second + 1)), trimmed(answer.substr(0, first)), stamp::cuda,
                      std::strtod(answer.substr(first + 1).c_str(), nullptr) / 1024};
}

}  // namespace

Machine describe_machine() {
  Machine m;
  m.date = today();
  m.cpu = processor_name();
  m.system = value_in("/etc/os-release", "PRETTY_NAME", '=');
  m.cores = int(std::thread::hardware_concurrency());
  m.memory_gib = double(long(number_in("/proc/meminfo", "MemTotal") / kib_a_gib * 10 + 0.5)) / 10;
  m.gpu = describe_gpu();
  m.compiler = stamp::compiler, m.flags = stamp::flags, m.version = version;
  const char* const commit = std::getenv("SWIFTGS_COMMIT");  // of a copy without its history
  m.commit = commit ? commit : stamp::commit;
  double load = 0;
  m.load = getloadavg(&load, 1) == 1 ? load : 0;
  return m;
}

std::string command_line(std::string_view left_out) {
  std::ifstream in("/proc/self/cmdline", std::ios::binary);
  std::string line = "swiftgs", word;
  std::getline(in, word, '\0');
  while (std::getline(in, word, '\0'))
    if (left_out.empty() || word != left_out) line.append(" ").append(shell_word(word));
  return line;
}

void release_free_memory() {
#if defined(__GLIBC__)
  malloc_trim(0);
#endif
}

std::size_t resident_memory() { return 1024 * std::size_t(number_in("/proc/self/status", "VmRSS")); }

std::size_t available_memory() { return 1024 * std::size_t(number_in("/proc/meminfo", "MemAvailable")); }

}  // namespace swiftgs::cli
