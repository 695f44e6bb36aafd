// SPDX-License-Identifier: Apache-2.0
#include "draw/video.hpp"

#include <array>
#include <cerrno>
#include <csignal>
#include <cstddef>
#include <filesystem>
#include <stdexcept>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include "draw/rgb_bytes.hpp"
#include "draw/team.hpp"
#include "words.hpp"

extern char** environ;

namespace swiftgs::cli {
namespace {

/// Starts ffmpeg with these ends of its streams. Returns 0 or an error of errno.
int start(pid_t& child, const std::vector<std::string>& words, int input, int errors) {
  std::vector<char*> arguments;
  for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t streams;
  posix_spawn_file_actions_init(&streams);
  posix_spawn_file_actions_adddup2(&streams, input, STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&streams, errors, STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&streams, errors, STDERR_FILENO);
  const int error = posix_spawnp(&child, arguments[0], &streams, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&streams);
  return error;
}

std::runtime_error not_installed(const std::string& file) {
  return std::runtime_error("--video " + file +
                            ": the program ffmpeg is not installed, expected it to make the video");
}

}  // namespace

Video::Video(std::string file, int width, int height, double frames_a_second) : file_(std::move(file)) {
  const std::string path = file_.starts_with("-") ? "./" + file_ : file_;
  // Colours of videos are stored for each two by two pixels. Players expect those of BT.709.
  const std::vector<std::string> words{
      "ffmpeg",
      "-nostdin",
      "-loglevel",
      "error",
      "-y",
      "-f",
      "rawvideo",
      "-pixel_format",
      "rgb24",
      "-video_size",
      std::to_string(width) + "x" + std::to_string(height),
      "-framerate",
      text_of_number(frames_a_second),
      "-i",
      "pipe:0",
      "-vf",
      "pad=ceil(iw/2)*2:ceil(ih/2)*2,scale=out_color_matrix=bt709,format=yuv420p",
      "-colorspace",
      "bt709",
      "-color_primaries",
      "bt709",
      "-color_trc",
      "bt709",
      "file:" + path};
  std::array<int, 2> pipe{};
  if (pipe2(pipe.data(), O_CLOEXEC) != 0) throw std::system_error(errno, std::generic_category(), "pipe");
  std::signal(SIGPIPE, SIG_IGN);  // where ffmpeg ends early, a write fails instead
  frames_ = fdopen(pipe[1], "wb"), errors_ = std::tmpfile();
  if (!frames_ || !errors_) throw std::system_error(errno, std::generic_category(), "a temporary file");
  const int error = start(ffmpeg_, words, pipe[0], fileno(errors_));
  close(pipe[0]);
  if (error == 0) return;
  std::fclose(frames_), std::fclose(errors_);
  if (error == ENOENT) throw not_installed(file_);
  throw std::system_error(error, std::generic_category(), "ffmpeg");
}

Video::~Video() {
  if (ffmpeg_ != -1) {
    kill(ffmpeg_, SIGKILL);
    end();
    std::error_code none;
    std::filesystem::remove(file_, none);
  }
  std::fclose(errors_);
}

int Video::end() {
  const bool written = std::fclose(frames_) == 0;
  int status = 0;
  pid_t ended = 0;
  while ((ended = waitpid(ffmpeg_, &status, 0)) == -1 && errno == EINTR) {
  }
  ffmpeg_ = -1;
  return written && ended != -1 && WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

void Video::fail(int exit_status) const {
  // A system may start a program without waiting to see whether it is there.
  if (exit_status == 127) throw not_installed(file_);
  // The last line is of what follows from the first.
  std::rewind(errors_);
  std::array<char, 300> line{};
  if (!std::fgets(line.data(), int(line.size()), errors_)) line[0] = '\0';
  std::string said = line.data();
  while (!said.empty() && said.back() == '\n') said.pop_back();
  if (said.starts_with("[")) said.erase(0, said.find("] ") + 2);  // the part of ffmpeg and its address
  throw std::runtime_error("--video " + file_ + ": ffmpeg failed" + (said.empty() ? "" : ": " + said));
}

void Video::add(const Frame& frame) {
  to_rgb_bytes(frame, bytes_);
  if (std::fwrite(bytes_.data(), 1, bytes_.size(), frames_) == bytes_.size()) return;
  fail(end());
}

void Video::finish() {
  if (const int status = end(); status != 0) fail(status);
}

std::unique_ptr<Video> video_of(const std::string& file, const std::vector<View>& views,
                                double frames_a_second) {
  if (file.empty()) return nullptr;
  if (Team::here().is_shared())
    throw std::invalid_argument("--video " + file + ": found several processes, expected one");
  const Camera& first = views[0].camera;
  const auto size_of = [](const Camera& camera) {
    return std::to_string(camera.width) + "x" + std::to_string(camera.height);
  };
  for (const View& view : views)
    if (size_of(view.camera) != size_of(first))
      throw std::invalid_argument("--video " + file + ": view " + view.name + " has " + size_of(view.camera) +
                                  " pixels, expected " + size_of(first) + " as " + views[0].name + " has");
  return std::make_unique<Video>(file, first.width, first.height, frames_a_second);
}

}  // namespace swiftgs::cli
