#include "diagnosis/estimation/slow_and_fast.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace gustlab::diagnosis {

namespace {

constexpr Eigen::Index widths[] = {3, 5, 9, 15, 25, 41, 71, 121, 201};  // of moving averages, samples
constexpr Eigen::Index sixths = 6;                                      // of a flight, whose scores are independent
constexpr double least_share = 0.2, errors = 2.0;

// what a candidate does along one channel of a flight, and what is left there
struct Course {
  std::size_t flight;
  Eigen::VectorXd does, left;
};

std::vector<Course> courses_of(const SignatureSeries& parts, const Eigen::VectorXd& fitted) {
  std::vector<Course> courses;
  for (std::size_t f = 0; f < parts.size(); ++f)
    for (const Signature& part : parts[f]) courses.push_back({f, part.by * fitted, part.left});
  return courses;
}

Eigen::VectorXd moving_mean(const Eigen::VectorXd& x, Eigen::Index width) {
  const Eigen::Index n = x.size(), half = width / 2;
  Eigen::VectorXd before = Eigen::VectorXd::Zero(n + 1), mean(n);
  std::partial_sum(x.begin(), x.end(), before.begin() + 1);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Eigen::Index first = std::max<Eigen::Index>(0, i - half), end = std::min(n, i + half + 1);
    mean[i] = (before[end] - before[first]) / static_cast<double>(end - first);
  }
  return mean;
}

// information that one band gives of the size, and how much of that the whole fit leaves, per sixth of each flight
struct Band {
  Eigen::ArrayXd information, remaining;
  explicit Band(Eigen::Index clusters)
      : information(Eigen::ArrayXd::Zero(clusters)), remaining(Eigen::ArrayXd::Zero(clusters)) {}
  void add(std::size_t flight, const Eigen::VectorXd& does, const Eigen::VectorXd& left) {
    for (Eigen::Index s = 0; s < sixths; ++s) {
      const Eigen::Index first = s * does.size() / sixths, size = (s + 1) * does.size() / sixths - first;
      const Eigen::Index cluster = static_cast<Eigen::Index>(flight) * sixths + s;
      information[cluster] += does.segment(first, size).squaredNorm();
      remaining[cluster] += does.segment(first, size).dot(left.segment(first, size));
    }
  }
  double share() const { return 1.0 + remaining.sum() / information.sum(); }
  double variance() const {
    const auto n = static_cast<double>(information.size());
    return (remaining - (share() - 1.0) * information).square().sum() * n / (n - 1.0) / std::pow(information.sum(), 2);
  }
};

}  // namespace

double slow_fast_difference(const SignatureSeries& parts, const Eigen::VectorXd& fitted) {
  const std::vector<Course> courses = courses_of(parts, fitted);
  double sum = 0.0, divided = 0.0;
  for (const Eigen::Index width : widths) {
    Band slow(std::ssize(parts) * sixths), fast = slow;
    for (const Course& course : courses) {
      const Eigen::VectorXd does = moving_mean(course.does, width), left = moving_mean(course.left, width);
      slow.add(course.flight, does, left);
      fast.add(course.flight, course.does - does, course.left - left);
    }
    const double in_slow = slow.information.sum(), in_fast = fast.information.sum();
    if (!(std::min(in_slow, in_fast) > least_share * (in_slow + in_fast))) continue;
    const double difference = std::abs(slow.share() - fast.share());
    sum += std::max(0.0, difference - errors * std::sqrt(slow.variance() + fast.variance())), divided += 1.0;
  }
  return divided > 0.0 ? sum / divided : 0.0;
}

}  // namespace gustlab::diagnosis
