#include "identification/feature_library.hpp"

#include <algorithm>
#include <charconv>

#include "gustlab/errors.hpp"

namespace gustlab {
namespace {

constexpr LibraryRow libraries[] = {
    {"paper", "the seven terms of Adaptive SINDy: 1, theta, phi, T sin theta, T cos theta, T sin phi, T cos phi"},
    {"polynomial", "polynomial:DEGREE:VARIABLES, all monomials up to the degree; default polynomial:2:vx,vy,vz"},
    {"trigonometric", "trigonometric:MULTIPLES:VARIABLES, sin and cos; default trigonometric:1:phi,theta,psi"},
};
constexpr std::size_t max_terms = 200;

std::vector<std::string_view> split(std::string_view text, char separator) {
  std::vector<std::string_view> parts;
  for (;;) {
    const std::size_t end = text.find(separator);
    parts.push_back(text.substr(0, end));
    if (end == std::string_view::npos) return parts;
    text.remove_prefix(end + 1);
  }
}

// the number and the variables after a library's name
struct Arguments {
  int number;
  std::vector<std::string> variables;
};
Arguments arguments(std::string_view text, Arguments out) {
  const std::vector<std::string_view> parts = split(text, ':');
  if (parts.size() > 3)
    throw ConfigError("library \"" + std::string(text) + "\": too many \":\" (NAME:NUMBER:VARIABLES)");
  if (parts.size() > 1) {
    const auto [end, error] = std::from_chars(parts[1].data(), parts[1].data() + parts[1].size(), out.number);
    if (error != std::errc() || end != parts[1].data() + parts[1].size() || out.number < 1 ||
        out.number > FeatureTerm::max_factors) {
      throw ConfigError("library \"" + std::string(text) + "\": \"" + std::string(parts[1]) +
                        "\" is not a whole number from 1 to 4");
    }
  }
  if (parts.size() > 2) {
    out.variables.clear();
    for (std::string_view name : split(parts[2], ',')) out.variables.push_back(FeatureTerm::parse(name).name());
  }
  return out;
}

void add_polynomial(const Arguments& arguments, std::vector<std::string>& names) {
  // each degree in turn, monomials in lexical order of their variables
  names.push_back("1");
  std::vector<std::vector<std::size_t>> monomials = {{}};
  for (int degree = 1; degree <= arguments.number; ++degree) {
    std::vector<std::vector<std::size_t>> next;
    for (const auto& monomial : monomials) {
      for (std::size_t v = monomial.empty() ? 0 : monomial.back(); v < arguments.variables.size(); ++v) {
        next.push_back(monomial);
        next.back().push_back(v);
      }
    }
    for (const auto& monomial : next) {
      std::string name;
      for (std::size_t i = 0; i < monomial.size();) {
        const auto power = std::count(monomial.begin(), monomial.end(), monomial[i]);
        name += (name.empty() ? "" : " ") + arguments.variables[monomial[i]];
        if (power > 1) name += "^" + std::to_string(power);
        i += static_cast<std::size_t>(power);
      }
      names.push_back(name);
    }
    monomials = std::move(next);
  }
}

void add_trigonometric(const Arguments& arguments, std::vector<std::string>& names) {
  for (const std::string& variable : arguments.variables) {
    for (int multiple = 1; multiple <= arguments.number; ++multiple) {
      for (const char* function : {"sin ", "cos "})
        names.push_back(function + std::to_string(multiple) + " " + variable);
    }
  }
}

}  // namespace

std::span<const LibraryRow> library_registry() { return libraries; }

std::vector<FeatureTerm> make_library(std::string_view text) {
  std::vector<std::string> names;
  for (std::string_view part : split(text, '+')) {
    const std::string_view head = part.substr(0, part.find(':'));
    if (part == "paper") {
      for (const char* name : {"1", "theta", "phi", "T sin theta", "T cos theta", "T sin phi", "T cos phi"}) {
        names.push_back(name);
      }
    } else if (head == "polynomial") {
      add_polynomial(arguments(part, {2, {"vx", "vy", "vz"}}), names);
    } else if (head == "trigonometric") {
      add_trigonometric(arguments(part, {1, {"phi", "theta", "psi"}}), names);
    } else {
      for (std::string_view name : split(part, ',')) names.emplace_back(name);
    }
  }
  std::vector<FeatureTerm> terms;
  for (const std::string& name : names) {
    FeatureTerm term = FeatureTerm::parse(name);
    const bool known =
        std::any_of(terms.begin(), terms.end(), [&](const FeatureTerm& t) { return t.name() == term.name(); });
    if (!known) terms.push_back(std::move(term));
  }
  if (terms.size() > max_terms) {
    throw ConfigError("library \"" + std::string(text) + "\": " + std::to_string(terms.size()) +
                      " terms (at most 200); use a lower degree or fewer variables");
  }
  return terms;
}

Eigen::MatrixXd feature_matrix(std::span<const FeatureTerm> terms, std::span<const FeatureInput> samples) {
  Eigen::MatrixXd theta(static_cast<Eigen::Index>(samples.size()), static_cast<Eigen::Index>(terms.size()));
  for (Eigen::Index j = 0; j < theta.cols(); ++j) {
    for (Eigen::Index i = 0; i < theta.rows(); ++i) {
      theta(i, j) = terms[static_cast<std::size_t>(j)].value(samples[static_cast<std::size_t>(i)]);
    }
  }
  return theta;
}

}  // namespace gustlab
