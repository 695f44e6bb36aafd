// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include <sys/types.h>

#include <swiftgs/frame.hpp>

#include "read/views.hpp"

namespace swiftgs::cli {

/// A video that the program ffmpeg makes of frames while they are drawn. The ending of its name says the
/// format.
class Video {
 public:
  /// Starts ffmpeg. Throws `Unavailable` if it is not installed.
  Video(std::string file, int width, int height, double frames_a_second);
  /// Ends ffmpeg, and leaves no file unless `finish` was called.
  ~Video();
  Video(const Video&) = delete;
  Video& operator=(const Video&) = delete;

  /// Adds a frame of the video's size. Throws `Unavailable` with what ffmpeg said if it ended.
  void add(const Frame& frame);
  /// Returns when the file is whole. Throws as `add`.
  void finish();

 private:
  /// Ends ffmpeg. Returns its exit status, or -1 if it did not end by itself or did not take all frames.
  int end();
  [[noreturn]] void fail(int exit_status) const;

  std::string file_;
  pid_t ffmpeg_ = -1;  ///< -1 after its end
  std::FILE *frames_ = nullptr, *errors_ = nullptr;
  std::vector<unsigned char> bytes_;
};

/// The video called `file` of all `views`, or null for no name. Throws `InvalidArgument` where their
/// sizes differ or several processes share them, and as `Video`.
std::unique_ptr<Video> video_of(const std::string& file, const std::vector<View>& views,
                                double frames_a_second);

}  // namespace swiftgs::cli
