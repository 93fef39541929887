#include "diagnosis/selection/stability.hpp"

#include <algorithm>
#include <cmath>

#include "diagnosis/selection/subset_search.hpp"
#include "gustlab/random.hpp"
#include "util/parallel.hpp"

namespace gustlab::diagnosis {

namespace {

constexpr int half_samples = 40;

}  // namespace

std::vector<double> inclusion(const Session& session, const Grams& grams, const std::vector<int>& chosen,
                              const std::set<int>& left_out, const std::map<int, std::vector<int>>& equals) {
  std::vector<double> share(session.catalogue().groups().size(), 0.0);
  if (chosen.empty()) return share;
  SubsetSearch search(session.catalogue(), session.vehicle(), std::log(grams.rows));
  std::erase_if(search.candidates, [&](int g) { return left_out.contains(g); });
  const RandomStream random(20261121, 0, "half_samples");
  const int most = std::min(static_cast<int>(chosen.size()) + 1, most_effects);
  std::vector<std::vector<int>> found(half_samples);
  parallel_for(half_samples / 2, session.jobs(), [&](std::int64_t draw) {
    std::vector<bool> first(static_cast<std::size_t>(grams.clusters));
    for (std::size_t i = 0; i < first.size(); ++i)
      first[i] = random.uniform4(static_cast<std::uint64_t>(draw) * 100000 + i)[0] < 0.5;
    for (const bool half : {true, false}) {
      Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(grams.columns + 1, grams.columns + 1);
      for (std::size_t b = 0; b < grams.block.size(); ++b) {
        const bool drawn = first[static_cast<std::size_t>(grams.cluster[b])] == half;
        if (drawn || grams.known[b]) gram += grams.block[b];
      }
      const auto by_size = search.run(project_out(gram, session.biases()), most, 5);
      found[static_cast<std::size_t>(2 * draw + (half ? 0 : 1))] =
          SubsetSearch::choose(by_size, search.gained_by_chance()).groups;
    }
  });
  for (const std::vector<int>& groups : found) {
    const auto is_found = [&](int g) { return std::ranges::count(groups, g) > 0; };
    for (const int g : groups) ++share[static_cast<std::size_t>(g)];
    for (const auto& [g, others] : equals)
      if (!is_found(g) && std::ranges::any_of(others, is_found)) ++share[static_cast<std::size_t>(g)];
  }
  for (double& s : share) s /= half_samples;
  return share;
}

}  // namespace gustlab::diagnosis
