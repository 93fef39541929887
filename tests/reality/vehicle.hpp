// the two vehicles as their files describe them
#pragma once

#include <filesystem>

#include "truth.hpp"

namespace reality {

/// Crazyflie size or Iris size; `drag_known`: the file already has rotor drag, so that wind is visible through it.
Nominal nominal_vehicle(bool large, bool drag_known);

/// Folder name of a vehicle file: says nothing of what a trial conceals.
std::string vehicle_folder(const Nominal& nominal);

/// Writes DIR/<folder>/vehicle.toml and its MJCF.
void write_vehicle(const Nominal& nominal, const std::filesystem::path& dir);

}  // namespace reality
