#include "trajectories/trajectories.hpp"

namespace gustlab {

namespace {

constexpr TrajectoryRow rows[] = {
    {.name = "hover", .says = "stay at one point", .make = make_hover},
    {.name = "circle",
     .says = "horizontal circle; the vehicle starts at its centre, as in the paper",
     .make = make_circle},
    {.name = "lemniscate",
     .says = "horizontal figure of eight through the origin, the paper's infinity",
     .make = make_lemniscate},
    {.name = "spiral", .says = "horizontal spiral outwards from the origin", .make = make_spiral},
    {.name = "waypoints", .says = "from rest through points to rest with the least snap", .make = make_waypoints},
    {.name = "multisine",
     .says = "sums of sines on every axis, to excite a vehicle for identification",
     .make = make_multisine},
    {.name = "recorded", .says = "the reference of a flight log; without a file, hover", .make = make_recorded},
};

}  // namespace

std::span<const TrajectoryRow> trajectory_registry() { return rows; }

const TrajectoryRow* find_trajectory(std::string_view name) {
  for (const TrajectoryRow& row : rows)
    if (row.name == name) return &row;
  return nullptr;
}

}  // namespace gustlab
