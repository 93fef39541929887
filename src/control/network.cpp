#include "control/network.hpp"

#include <algorithm>
#include <charconv>
#include <cstring>
#include <limits>
#include <string_view>

#include "gustlab/errors.hpp"

namespace gustlab {

namespace {

constexpr std::string_view format = "gustlab-network/1";
constexpr std::size_t most_layers = 16, most_units = 4096;

// lines of words with their places
class Reader {
 public:
  Reader(const std::string& text, const std::string& path) : text_(text), path_(path) {}

  // the next line that is not empty; its words
  const std::vector<std::string_view>& next(const char* expected) {
    words_.clear();
    while (words_.empty()) {
      if (at_ >= text_.size()) fail(0, std::string("the file ends where ") + expected + " should be", "train it again");
      const std::size_t end = std::min(text_.find('\n', at_), text_.size());
      line_ = std::string_view(text_).substr(at_, end - at_);
      at_ = end + 1;
      ++line_number_;
      for (std::size_t i = 0; i < line_.size();) {
        const std::size_t start = line_.find_first_not_of(" \t\r", i);
        if (start == std::string_view::npos) break;
        const std::size_t stop = std::min(line_.find_first_of(" \t\r", start), line_.size());
        words_.push_back(line_.substr(start, stop - start));
        i = stop;
      }
    }
    return words_;
  }
  const std::vector<std::string_view>& words() const { return words_; }
  std::string_view line() const { return line_; }
  bool at_end() const { return text_.find_first_not_of(" \t\r\n", at_) == std::string::npos; }

  double number(std::size_t word) const {
    double value = 0.0;
    const std::string_view text = words_[word];
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size() || !(value - value == 0.0))
      fail(word, "\"" + std::string(text) + "\" is not a finite number", "train it again");
    return value;
  }
  void expect_words(std::size_t count, const std::string& what) const {
    if (words_.size() != count)
      fail(words_.size(), what + " needs " + std::to_string(count) + " words and has " + std::to_string(words_.size()),
           "train it again");
  }
  void expect_key(std::string_view key) const {
    if (words_[0] != key)
      fail(0, "\"" + std::string(words_[0]) + "\" stands where \"" + std::string(key) + "\" should", "train it again");
  }
  [[noreturn]] void fail(std::size_t word, const std::string& problem, const std::string& suggestion) const {
    const std::size_t column =
        word < words_.size() ? static_cast<std::size_t>(words_[word].data() - line_.data()) : line_.size();
    throw DataError(path_ + ":" + std::to_string(line_number_) + ":" + std::to_string(column + 1) + ": " +
                    worded(problem, "a network of format " + std::string(format), suggestion));
  }

 private:
  const std::string& text_;
  const std::string& path_;
  std::size_t at_ = 0, line_number_ = 0;
  std::string_view line_;
  std::vector<std::string_view> words_;
};

Eigen::VectorXd numbers(Reader& reader, std::string_view key, std::size_t count) {
  reader.next(key.data());
  reader.expect_key(key);
  reader.expect_words(count + 1, std::string(key));
  Eigen::VectorXd out(static_cast<Eigen::Index>(count));
  for (std::size_t i = 0; i < count; ++i) out[static_cast<Eigen::Index>(i)] = reader.number(i + 1);
  return out;
}

void append(std::string& text, double value) {
  char buffer[32];
  const auto [end, error] = std::to_chars(buffer, buffer + sizeof buffer, value);
  text += ' ';
  text.append(buffer, end);
}

// rows of a layer that are summed together, in the widest vectors of the processor; of any width they give the same bits
constexpr Eigen::Index pack_size = 4;
using Pack = double __attribute__((vector_size(pack_size * sizeof(double))));

// sanitizers do not survive the choice of a function while the program is loaded
#if defined(__x86_64__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define GUSTLAB_WIDEST __attribute__((target_clones("avx2", "default")))
#else
#define GUSTLAB_WIDEST
#endif

// packs stand anywhere in memory
inline void load(Pack& pack, const double* from) { std::memcpy(&pack, from, sizeof pack); }
inline void store(const Pack& pack, double* to) { std::memcpy(to, &pack, sizeof pack); }

// out = bias + weight × in, each sum from the first input to the last; the rows are whole packs. `least`: what is smaller becomes it, and
// a NaN stays one.
GUSTLAB_WIDEST
void layer(const Eigen::MatrixXd& weight, const Eigen::VectorXd& bias, double least, const double* in, double* out) {
  const Eigen::Index rows = weight.rows(), columns = weight.cols();
  const Pack floor = Pack{} + least;
  const auto finish = [&](Eigen::Index row, Pack& sum) {
    Pack more;
    load(more, bias.data() + row);
    sum += more;
    store(sum < floor ? floor : sum, out + row);
  };
  Eigen::Index row = 0;
  for (; row + 3 * pack_size < rows; row += 4 * pack_size) {
    Pack a = {}, b = {}, c = {}, d = {}, of_a, of_b, of_c, of_d;
    for (Eigen::Index j = 0; j < columns; ++j) {
      const double* column = weight.data() + j * rows + row;
      load(of_a, column), load(of_b, column + pack_size);
      load(of_c, column + 2 * pack_size), load(of_d, column + 3 * pack_size);
      a += in[j] * of_a, b += in[j] * of_b, c += in[j] * of_c, d += in[j] * of_d;
    }
    finish(row, a), finish(row + pack_size, b), finish(row + 2 * pack_size, c), finish(row + 3 * pack_size, d);
  }
  for (; row < rows; row += pack_size) {
    Pack sum = {}, of_sum;
    for (Eigen::Index j = 0; j < columns; ++j) {
      load(of_sum, weight.data() + j * rows + row);
      sum += in[j] * of_sum;
    }
    finish(row, sum);
  }
}

}  // namespace

NetworkWeights parse_network(const std::string& text, const std::string& path) {
  Reader reader(text, path);
  NetworkWeights network;
  reader.next("the format");
  if (reader.line() != format) reader.fail(0, "this is no network", "name a file that `gustlab train` wrote");

  while (reader.next("inputs")[0] == "#") {
    const std::string_view line = reader.line();
    const std::size_t colon = line.find(": ");
    if (colon == std::string_view::npos || colon < 2)
      reader.fail(0, "a provenance line reads `# KEY: VALUE`", "add the colon");
    network.provenance.emplace_back(line.substr(2, colon - 2), line.substr(colon + 2));
  }
  reader.expect_key("inputs");
  const std::vector<std::string_view> names = reader.words();
  network.inputs.assign(names.begin() + 1, names.end());
  const std::size_t width = network.inputs.size();
  network.mean = numbers(reader, "mean", width);
  network.scale = numbers(reader, "scale", width);
  for (std::size_t i = 0; i < width; ++i)
    if (!(network.scale[static_cast<Eigen::Index>(i)] > 0.0))
      reader.fail(i + 1, "a scale is not positive", "train it again");

  reader.next("layers");
  reader.expect_key("layers");
  std::vector<Eigen::Index> widths;
  for (std::size_t i = 1; i < reader.words().size(); ++i) {
    const double units = reader.number(i);
    if (!(units >= 1.0 && units <= most_units) || units != static_cast<double>(static_cast<Eigen::Index>(units)))
      reader.fail(i, "a layer has between 1 and 4096 units", "train it again");
    widths.push_back(static_cast<Eigen::Index>(units));
  }
  if (widths.size() < 2 || widths.size() > most_layers || widths[0] != static_cast<Eigen::Index>(width))
    reader.fail(1, "layers must begin with the number of inputs and go on", "train it again");

  for (std::size_t k = 1; k < widths.size(); ++k) {
    reader.next("weights");
    reader.expect_key("weights");
    reader.expect_words(2, "weights");
    if (reader.words()[1] != std::to_string(k)) reader.fail(1, "layers do not follow each other", "train it again");
    NetworkWeights::Layer layer{Eigen::MatrixXd(widths[k], widths[k - 1]), Eigen::VectorXd(widths[k])};
    for (Eigen::Index row = 0; row < widths[k]; ++row) {
      reader.next("a row of weights");
      reader.expect_words(static_cast<std::size_t>(widths[k - 1]) + 1, "a row of weights");
      for (Eigen::Index column = 0; column < widths[k - 1]; ++column)
        layer.weight(row, column) = reader.number(static_cast<std::size_t>(column));
      layer.bias[row] = reader.number(static_cast<std::size_t>(widths[k - 1]));
    }
    network.layers.push_back(std::move(layer));
  }
  if (!reader.at_end()) {
    reader.next("nothing");
    reader.fail(0, "the file goes on after the last layer", "train it again");
  }
  return network;
}

std::string network_text(const NetworkWeights& weights) {
  std::string text(format);
  text += '\n';
  for (const auto& [key, value] : weights.provenance) text += "# " + key + ": " + value + '\n';
  text += "inputs";
  for (const std::string& name : weights.inputs) text += ' ' + name;
  text += "\nmean";
  for (const double value : weights.mean) append(text, value);
  text += "\nscale";
  for (const double value : weights.scale) append(text, value);
  text += "\nlayers " + std::to_string(weights.mean.size());
  for (const NetworkWeights::Layer& layer : weights.layers) text += ' ' + std::to_string(layer.bias.size());
  text += '\n';
  for (std::size_t k = 0; k < weights.layers.size(); ++k) {
    const NetworkWeights::Layer& layer = weights.layers[k];
    text += "weights " + std::to_string(k + 1) + '\n';
    for (Eigen::Index row = 0; row < layer.weight.rows(); ++row) {
      std::string line;
      for (Eigen::Index column = 0; column < layer.weight.cols(); ++column) append(line, layer.weight(row, column));
      append(line, layer.bias[row]);
      text += line.substr(1) + '\n';
    }
  }
  return text;
}

Network::Network(NetworkWeights weights) : weights_(std::move(weights)) {
  values_.emplace_back(weights_.mean.size());
  for (const NetworkWeights::Layer& layer : weights_.layers) {
    const Eigen::Index rows = layer.bias.size(), padded = (rows + pack_size - 1) / pack_size * pack_size;
    NetworkWeights::Layer& whole = padded_.emplace_back();
    whole.weight = Eigen::MatrixXd::Zero(padded, layer.weight.cols());
    whole.bias = Eigen::VectorXd::Zero(padded);
    whole.weight.topRows(rows) = layer.weight;
    whole.bias.head(rows) = layer.bias;
    values_.emplace_back(padded);
  }
  if (!weights_.layers.empty()) output_.resize(weights_.layers.back().bias.size());
}

const Eigen::VectorXd& Network::evaluate(std::span<const double> input) {
  const Eigen::Map<const Eigen::VectorXd> raw(input.data(), weights_.mean.size());
  values_[0] = (raw - weights_.mean).cwiseQuotient(weights_.scale);
  for (std::size_t k = 0; k < padded_.size(); ++k)
    layer(padded_[k].weight, padded_[k].bias, k + 1 < padded_.size() ? 0.0 : -std::numeric_limits<double>::infinity(),
          values_[k].data(), values_[k + 1].data());
  output_ = values_.back().head(output_.size());
  return output_;
}

}  // namespace gustlab
