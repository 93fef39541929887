#include "identification/constraints.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>

#include "gustlab/errors.hpp"

namespace gustlab {
namespace {

// Reads one constraint from left to right into a row of C and its d.
class Reader {
 public:
  Reader(const std::string& text, std::span<const FeatureTerm> terms, std::span<const std::string_view> targets)
      : text_(text), terms_(terms), targets_(targets) {}

  void read(Eigen::Ref<Eigen::RowVectorXd> row, double& d) {
    bool first = true;
    while (!take('=')) {
      const bool minus = take('-');
      if (!minus && !take('+') && !first) fail("\"+\", \"-\" or \"=\" is missing");
      const double factor = next_is_number() ? number() : 1.0;
      take('*');
      row[coefficient()] += minus ? -factor : factor;
      first = false;
    }
    if (first) fail("there is nothing before \"=\"");
    const bool minus = take('-');
    if (!next_is_number()) fail("a number is missing after \"=\"");
    d = (minus ? -1.0 : 1.0) * number();
    skip_space();
    if (at_ != text_.size()) fail("something follows the number");
  }

 private:
  Eigen::Index coefficient() {
    skip_space();
    const std::size_t open = text_.find('[', at_), close = text_.find(']', at_);
    if (open == std::string::npos || close == std::string::npos || close < open) fail("\"target[term]\" is missing");
    std::string_view name = std::string_view(text_).substr(at_, open - at_);
    while (!name.empty() && std::isspace(static_cast<unsigned char>(name.back()))) name.remove_suffix(1);
    const auto target = std::find(targets_.begin(), targets_.end(), name);
    if (target == targets_.end())
      fail(fmt::format("unknown target \"{}\" (there are {})", name, fmt::join(targets_, ", ")));
    const std::string wanted = FeatureTerm::parse(std::string_view(text_).substr(open + 1, close - open - 1)).name();
    const auto term =
        std::find_if(terms_.begin(), terms_.end(), [&](const FeatureTerm& t) { return t.name() == wanted; });
    if (term == terms_.end()) fail(fmt::format("the library has no term \"{}\"", wanted));
    at_ = close + 1;
    return (target - targets_.begin()) * static_cast<Eigen::Index>(terms_.size()) + (term - terms_.begin());
  }

  bool next_is_number() {
    skip_space();
    return at_ < text_.size() && (std::isdigit(static_cast<unsigned char>(text_[at_])) || text_[at_] == '.');
  }
  double number() {
    char* end = nullptr;
    const double value = std::strtod(text_.c_str() + at_, &end);
    at_ = static_cast<std::size_t>(end - text_.c_str());
    if (!std::isfinite(value)) fail("a number is not finite");
    return value;
  }
  bool take(char wanted) {
    skip_space();
    if (at_ == text_.size() || text_[at_] != wanted) return false;
    ++at_;
    return true;
  }
  void skip_space() {
    while (at_ < text_.size() && std::isspace(static_cast<unsigned char>(text_[at_]))) ++at_;
  }
  [[noreturn]] void fail(const std::string& problem) const {
    throw ConfigError(
        fmt::format("constraint \"{}\": {}; write for example fx[T sin theta] + fy[T sin phi] = 0", text_, problem));
  }

  const std::string& text_;
  std::span<const FeatureTerm> terms_;
  std::span<const std::string_view> targets_;
  std::size_t at_ = 0;
};

}  // namespace

LinearConstraints parse_constraints(std::span<const std::string> texts, std::span<const FeatureTerm> terms,
                                    std::span<const std::string_view> targets) {
  LinearConstraints out;
  const Eigen::Index rows = static_cast<Eigen::Index>(texts.size());
  out.C = Eigen::MatrixXd::Zero(rows, static_cast<Eigen::Index>(terms.size() * targets.size()));
  out.d = Eigen::VectorXd::Zero(rows);
  Eigen::RowVectorXd row(out.C.cols());
  for (Eigen::Index i = 0; i < rows; ++i) {
    row.setZero();
    Reader(texts[static_cast<std::size_t>(i)], terms, targets).read(row, out.d[i]);
    out.C.row(i) = row;
  }
  return out;
}

}  // namespace gustlab
