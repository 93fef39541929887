// One diagnosis, and many of them.
#pragma once

#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "diagnosis/diagnose.hpp"

namespace gustlab {

// Diagnoses, and replaces OUT by the result. `key`, if not empty, is kept beside it: what the result was made of.
diagnosis::Diagnosis diagnose_into(const std::string& out, const diagnosis::DiagnoseOptions& wanted,
                                   const std::string& key = {});
// The key of a finished diagnosis in OUT; empty when there is none.
std::string diagnosed_key(const std::string& out);

// Takes a flight log to those that were `seen`. Throws DataError where it is not there, ConfigError where it is among them.
void check_flight(const std::string& path, std::set<std::filesystem::path>& seen);
// The same of all flights.
void check_flights(const diagnosis::DiagnoseOptions& wanted);
// Warns of every flight that was set aside.
void warn_of_set_aside(const diagnosis::Diagnosis& result);

// Every [[set]] of a file, into OUT/NAME. Sets that are done, from the same bytes by the same program, are not diagnosed again.
void diagnose_batch(const std::string& sets, const std::string& out, int jobs);

}  // namespace gustlab
