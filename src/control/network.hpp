// A small multilayer perceptron with rectified linear units, evaluated without allocation, and its file.
//
// The file is text, one item per line, numbers in the shortest form that reads back the same:
//
//   gustlab-network/1
//   # KEY: VALUE                      any number of provenance lines: experiment, seed, commit, losses, …
//   inputs NAME…                      names with units, for example vx_W_mps; their number is the width of layer 0
//   mean NUMBER…                      one per input
//   scale NUMBER…                     one per input, positive; the network sees (input − mean)/scale
//   layers N0 N1 … NL                 widths; all but the last are followed by max(0, ·)
//   weights 1                         then N1 lines, each N0 weights and the bias; and so on up to layer L
#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace gustlab {

struct NetworkWeights {
  struct Layer {
    Eigen::MatrixXd weight;  // outputs × inputs
    Eigen::VectorXd bias;
  };
  std::vector<std::pair<std::string, std::string>> provenance;
  std::vector<std::string> inputs;
  Eigen::VectorXd mean, scale;
  std::vector<Layer> layers;
};

// `path` stands in messages only. Throws DataError `path:line:col: problem (why); suggestion`.
NetworkWeights parse_network(const std::string& text, const std::string& path);
std::string network_text(const NetworkWeights& weights);

class Network {
 public:
  Network() = default;
  explicit Network(NetworkWeights weights);

  int inputs() const { return weights_.layers.empty() ? 0 : static_cast<int>(weights_.mean.size()); }
  int outputs() const { return weights_.layers.empty() ? 0 : static_cast<int>(weights_.layers.back().bias.size()); }
  const NetworkWeights& weights() const { return weights_; }
  // input: inputs() numbers in the file's units; returns outputs() numbers, valid until the next call
  const Eigen::VectorXd& evaluate(std::span<const double> input);

 private:
  NetworkWeights weights_;
  std::vector<NetworkWeights::Layer> padded_;  // the same, rows filled up with zeros
  std::vector<Eigen::VectorXd> values_;        // of every layer, the normalised input first
  Eigen::VectorXd output_;
};

}  // namespace gustlab
