#include "control/network.hpp"

#include <gmock/gmock.h>

#include "gustlab/errors.hpp"

namespace gustlab {
namespace network_test {

NetworkWeights small() {
  NetworkWeights weights;
  weights.provenance = {{"experiment", "test"}, {"seed", "1"}};
  weights.inputs = {"a", "b"};
  weights.mean = Eigen::Vector2d(1.0, -1.0);
  weights.scale = Eigen::Vector2d(2.0, 0.5);
  weights.layers = {
      {(Eigen::MatrixXd(3, 2) << 1.0, 0.0, 0.0, 1.0, -1.0, -1.0).finished(), Eigen::Vector3d(0.0, 0.1, 0.2)},
      {(Eigen::MatrixXd(1, 3) << 1.0, 2.0, 1.0 / 3.0).finished(), Eigen::VectorXd::Constant(1, -0.5)}};
  return weights;
}

TEST(Network, IsItsFormula) {
  Network network(small());
  // x = (2, 0.8): hidden (2, 0.9, max(0, −2.6)) → 2 + 1.8 − 0.5
  const std::array<double, 2> input{5.0, -0.6};
  EXPECT_NEAR(network.evaluate(input)[0], 3.3, 1e-12);
  EXPECT_EQ(network.inputs(), 2);
  EXPECT_EQ(network.outputs(), 1);
}

TEST(Network, LetsANanThrough) {
  Network network(small());
  EXPECT_TRUE(std::isnan(network.evaluate(std::array<double, 2>{std::nan(""), 0.0})[0]));
}

TEST(Network, GoesToTextAndBackToTheBit) {
  const std::string text = network_text(small());
  const NetworkWeights back = parse_network(text, "w");
  EXPECT_EQ(network_text(back), text);
  EXPECT_EQ(back.provenance, small().provenance);
  EXPECT_EQ(back.layers[1].weight, small().layers[1].weight);
}

TEST(Network, SaysWhereAFileIsWrong) {
  const std::string good = network_text(small());
  const auto message = [&](const std::string& from, const std::string& to) -> std::string {
    std::string text = good;
    text.replace(text.find(from), from.size(), to);
    try {
      parse_network(text, "w");
    } catch (const DataError& error) {
      return error.what();
    }
    return "accepted";
  };
  EXPECT_THAT(message("gustlab-network/1", "something/2"), testing::StartsWith("w:1:1: this is no network"));
  EXPECT_THAT(message("mean 1", "mean x"), testing::StartsWith("w:5:6: \"x\" is not a finite number"));
  EXPECT_THAT(message("mean 1", "mean nan"), testing::HasSubstr("not a finite number"));
  EXPECT_THAT(message("scale 2 0.5", "scale 2 0"), testing::HasSubstr("not positive"));
  EXPECT_THAT(message("scale 2 0.5", "scale 2"), testing::HasSubstr("needs 3 words and has 2"));
  EXPECT_THAT(message("layers 2 3 1", "layers 4 3 1"), testing::HasSubstr("begin with the number of inputs"));
  EXPECT_THAT(message("layers 2 3 1", "layers 2 30000 1"), testing::HasSubstr("between 1 and 4096"));
  EXPECT_THAT(message("weights 2", "weights 7"), testing::HasSubstr("do not follow"));
  EXPECT_THAT(message("0 1 0.1\n", ""), testing::HasSubstr("w:"));
  EXPECT_THAT(message("-0.5", "-0.5\nmore"), testing::HasSubstr("goes on"));
  EXPECT_THAT(message("weights 2\n1 2 0.3333333333333333 -0.5\n", ""), testing::HasSubstr("the file ends"));
}

}  // namespace network_test
}  // namespace gustlab
