#include "log.hpp"

#include <cstdio>
#include <fstream>
#include <stdexcept>

namespace reality {
namespace {

void put(std::string& line, double value, int digits) {
  char cell[40];
  std::snprintf(cell, sizeof cell, "%s%.*f", line.empty() ? "" : ",", digits, value);
  line += cell;
}
void put(std::string& line, const Vec3& v, int digits) {
  for (int i = 0; i < 3; ++i) put(line, v[i], digits);
}

void save(const std::filesystem::path& path, const std::string& text) {
  std::ofstream out(path, std::ios::binary);
  out << text;
  if (!out) throw std::runtime_error("cannot write " + path.string());
}

}  // namespace

void write_log(const Flight& flight, const Surroundings& around, const Columns& columns, const std::string& vehicle,
               const std::filesystem::path& csv) {
  std::string text = "time_s,px,py,pz";
  if (columns.velocity) text += ",vx,vy,vz";
  text += ",qw,qx,qy,qz,wx,wy,wz";
  if (columns.accel) text += ",ax,ay,az";
  text += ",u1,u2,u3,u4";
  if (columns.voltage) text += ",vbat";
  text += "\n";
  for (const Sample& s : flight.sample) {
    std::string line;
    put(line, s.time_s, 3);
    put(line, s.reading.position_W_m, 6);
    if (columns.velocity) put(line, s.reading.velocity_W_mps, 6);
    Quat q = s.reading.attitude.normalized();
    if (q.w() < 0) q.coeffs() *= -1;
    put(line, q.w(), 7);
    put(line, Vec3(q.vec()), 7);
    put(line, s.reading.gyro_B_radps, 6);
    if (columns.accel) put(line, s.reading.specific_B_mps2, 5);
    for (const double u : s.command_radps) put(line, u, 3);
    if (columns.voltage) put(line, s.voltage_V, 4);
    text += line + "\n";
  }
  save(csv, text);

  std::string meta = "format = \"gustlab-flight/1\"\nvehicle = \"" + vehicle +
                     "\"\nactuator = \"rotor_speed\"\nsource = \"recording\"\nhold = \"zoh\"\nnotes = \"\"\n";
  if (around.ground_z_m || around.ceiling_z_m || around.wall) meta += "[environment]\n";
  char line[200];
  const auto number = [&](const char* format, auto... values) {
    std::snprintf(line, sizeof line, format, values...);
    meta += line;
  };
  if (around.ground_z_m) number("ground_z_m = %.3f\n", *around.ground_z_m);
  if (around.ceiling_z_m) number("ceiling_z_m = %.3f\n", *around.ceiling_z_m);
  if (around.wall)
    number("walls = [[%.9f, %.9f, %.9f, %.9f]]\n", around.wall->point_W_m.x(), around.wall->point_W_m.y(),
           around.wall->normal_W.x(), around.wall->normal_W.y());
  std::filesystem::path sidecar = csv;
  save(sidecar.replace_extension(".meta.toml"), meta);
}

}  // namespace reality
