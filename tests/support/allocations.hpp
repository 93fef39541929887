// Counts calls of operator new in this program; tests/contract/allocations.cpp replaces it.
#pragma once

#include <cstddef>

namespace gustlab::test {

std::size_t allocations();

}  // namespace gustlab::test
