// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// CUDA graphs of captured work.

#include <cstddef>
#include <memory>
#include <type_traits>

#include <cuda_runtime_api.h>

#include "cuda/device.hpp"

namespace swiftgs::test {

/// What `f` gives to a stream, ready to run.
class Graph {
 public:
  /// Throws if the capture did not stay valid.
  template <class F>
  Graph(const Stream& stream, const F& f, cudaStreamCaptureMode mode = cudaStreamCaptureModeGlobal)
      : stream_(stream) {
    check_cuda(cudaStreamBeginCapture(stream.get(), mode), "cudaStreamBeginCapture");
    f();
    cudaGraph_t graph = nullptr;
    check_cuda(cudaStreamEndCapture(stream.get(), &graph), "cudaStreamEndCapture");
    const std::unique_ptr<std::remove_pointer_t<cudaGraph_t>, Destroy> owner(graph);
    check_cuda(cudaGraphGetNodes(graph, nullptr, &nodes_), "cudaGraphGetNodes");
    check_cuda(cudaGraphInstantiate(&made_, graph, 0), "cudaGraphInstantiate");
  }
  ~Graph() { cudaGraphExecDestroy(made_); }
  Graph(const Graph&) = delete;
  Graph& operator=(const Graph&) = delete;

  void run() const { check_cuda(cudaGraphLaunch(made_, stream_.get()), "cudaGraphLaunch"); }
  std::size_t nodes() const { return nodes_; }

 private:
  struct Destroy {
    void operator()(cudaGraph_t graph) const { cudaGraphDestroy(graph); }
  };

  const Stream& stream_;
  cudaGraphExec_t made_ = nullptr;
  std::size_t nodes_ = 0;
};

}  // namespace swiftgs::test
