// [environment]: the surfaces near a flight.
#include "config/toml.hpp"

namespace gustlab::config {

Environment read_environment(Table& document) {
  Environment environment;
  auto table = document.table("environment");
  if (!table) return environment;
  environment.ground_z_m = table->number("ground_z_m");
  environment.ceiling_z_m = table->number("ceiling_z_m");
  const auto walls = table->number_rows("walls");
  if (!walls) return environment;
  for (const std::vector<double>& row : *walls) {
    if (row.size() != 4 || (row[2] == 0.0 && row[3] == 0.0))
      table->fail("walls", "a wall is a point and a normal that is not zero", "", "write [px, py, nx, ny]");
    environment.walls.push_back({Vector3(row[0], row[1], 0.0), Vector3(row[2], row[3], 0.0).normalized()});
  }
  return environment;
}

}  // namespace gustlab::config
