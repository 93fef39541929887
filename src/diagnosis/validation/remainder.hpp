// Whether anything is left after the chosen effects, and in which channel.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "diagnosis/result/findings.hpp"
#include "diagnosis/selection/selection.hpp"
#include "diagnosis/validation/gust_parts.hpp"

namespace gustlab::diagnosis {

inline constexpr std::array<const char*, 6> channel_name = {"force_x",  "force_y",  "force_z",
                                                            "torque_x", "torque_y", "torque_z"};

struct Remainder {
  std::vector<Alarm> alarms;
  double omnibus_share = 0.0;  // of all structure, what the omnibus test still finds
  bool gust_like =
      false;  // horizontal floor raised and slowly varying, or with a line, and no dependence on the state explains it
  bool names_gust =
      false;  // and it is more than rough air: a line, a second of memory, or clearly stronger sideways than up and down
  bool depends_on_state = false;  // the horizontal force, on where or how fast the vehicle is
  GustParts gust;
};

// Both at the selected model; the session must be linearised there.
// What pushes for long, which takes little time: `gust`, `depends_on_state`, and `gust_like` but for what ask_rest() finds.
// `force_withdrawn`: a force of every flight's own was found and did not stand, so what is left is no gust.
Remainder lasting_push(const Session& session, const Selection& selection, bool force_withdrawn);
// all else
void ask_rest(const Session& session, const Selection& selection, Remainder& result);

// more than chance and more than a thousandth of the information (DIAGNOSIS.md §3.5c)
bool beyond_chance(double delta_chi2, int size, double rows);

}  // namespace gustlab::diagnosis
