#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

/// Declares `folder`, the place of the recorded flights (`GUSTLAB_FLIGHTS`), or skips the test and says so. Put tests
/// that use it into files named *_flights_test.cpp: those report as skipped where the flights are not.
#define GUSTLAB_FLIGHTS_OR_SKIP(folder)                                              \
  const char* const folder##_text = std::getenv("GUSTLAB_FLIGHTS");                  \
  if (folder##_text == nullptr || *folder##_text == '\0')                            \
    GTEST_SKIP() << "GUSTLAB_FLIGHTS is not set: the recorded flights are not here"; \
  const std::filesystem::path folder { folder##_text }
