// the smallest test frame: counts what fails and says where
#pragma once

#include <cmath>
#include <iostream>

namespace reality {

inline int failures = 0;

inline void expect(bool good, const char* what, const char* file, int line) {
  if (good) return;
  ++failures;
  std::cerr << file << ':' << line << ": " << what << "\n";
}

inline void expect_near(double got, double wanted, double tolerance, const char* what, const char* file, int line) {
  if (std::abs(got - wanted) <= tolerance) return;
  ++failures;
  std::cerr << file << ':' << line << ": " << what << " is " << got << ", not " << wanted << "\n";
}

}  // namespace reality

#define EXPECT(condition) ::reality::expect(condition, #condition, __FILE__, __LINE__)
#define EXPECT_NEAR(got, wanted, tolerance) ::reality::expect_near(got, wanted, tolerance, #got, __FILE__, __LINE__)
