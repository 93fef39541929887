#pragma once

namespace reality {

/// Compares every effect with the closed form that the catalogue states for it, in a random state.
void check_closed_forms(bool large);

}  // namespace reality
