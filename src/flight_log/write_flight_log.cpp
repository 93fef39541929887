#include <fmt/format.h>
#include <zlib.h>

#include <charconv>
#include <cmath>

#include "config/toml.hpp"
#include "flight_log/sidecar.hpp"
#include "gustlab/errors.hpp"
#include "util/files.hpp"

namespace gustlab {

namespace {

void append(std::string& text, double value) {
  if (std::isnan(value)) return;
  char buffer[32];
  text.append(buffer, std::to_chars(buffer, buffer + sizeof buffer, value).ptr);
}

std::string csv_text(const FlightLog& log) {
  std::string text = "time_s";
  for (const LogColumn& column : log.columns) text += "," + column.name;
  text += '\n';
  for (std::size_t row = 0; row < log.rows(); ++row) {
    append(text, log.time_s[row]);
    for (const LogColumn& column : log.columns) {
      text += ',';
      append(text, column.values[row]);
    }
    text += '\n';
  }
  return text;
}

// gzip with an empty header: no name, no time
std::string compressed(const std::string& text) {
  z_stream stream{};
  constexpr int gzip_window = 15 + 16, memory_level = 8;
  if (deflateInit2(&stream, Z_DEFAULT_COMPRESSION, Z_DEFLATED, gzip_window, memory_level, Z_DEFAULT_STRATEGY) != Z_OK)
    throw IoError("zlib cannot start");
  std::string bytes(deflateBound(&stream, text.size()), '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(text.data()));
  stream.avail_in = static_cast<uInt>(text.size());
  stream.next_out = reinterpret_cast<Bytef*>(bytes.data());
  stream.avail_out = static_cast<uInt>(bytes.size());
  const int code = deflate(&stream, Z_FINISH);
  bytes.resize(stream.total_out);
  deflateEnd(&stream);
  if (code != Z_STREAM_END) throw IoError("zlib cannot compress the log");
  return bytes;
}

}  // namespace

void write_flight_log(const FlightLog& log, const std::string& csv_path) {
  const std::string description = sidecar_text(log.meta), description_path = sidecar_path(csv_path);
  config::Table::parse(description, description_path);
  const std::string text = csv_text(log);
  write_together([&] {
    write_file(csv_path, csv_path.ends_with(".gz") ? compressed(text) : text);
    write_file(description_path, description);
  });
}

}  // namespace gustlab
