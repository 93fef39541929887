// Of names that the flights do not tell apart, the one that is said first.
#pragma once

#include <functional>
#include <optional>
#include <set>

#include "diagnosis/evidence/challenge.hpp"

namespace gustlab::diagnosis {

// The rival that is equal to a finding and has a far more usual size (decisions::far_more_usual) than that; nothing where the finding's own is not
// unusual, and none that was `tried`.
std::optional<Rival> far_more_usual_rival(const Catalogue& catalogue, const Selection& selection,
                                          const Finding& finding, const std::set<int>& tried);

// Fits such a rival in the place of each name that has one, and has that set judged. It is the answer where it is still equal and costs no name.
void say_usual_names(Session& session, Selection& selection, Challenge& judged,
                     const std::function<Challenge(Selection&)>& judge);

}  // namespace gustlab::diagnosis
