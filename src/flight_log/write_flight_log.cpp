#include <fmt/format.h>
#include <zlib.h>

#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "config/toml.hpp"
#include "flight_log/sidecar.hpp"
#include "gustlab/errors.hpp"

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

// beside its place first, then renamed
void write_whole(const std::string& path, const std::string& bytes) {
  const std::string beside = path + ".part";
  errno = 0;
  std::ofstream file(beside, std::ios::binary);
  file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  file.close();
  std::error_code error;
  if (file) std::filesystem::rename(beside, path, error);
  if (!file || error) {
    const std::string why = error ? error.message() : std::strerror(errno ? errno : EIO);
    std::filesystem::remove(beside, error);
    throw IoError(fmt::format("{}: cannot write ({})", path, why));
  }
}

}  // namespace

void write_flight_log(const FlightLog& log, const std::string& csv_path) {
  const std::string description = sidecar_text(log.meta), description_path = sidecar_path(csv_path);
  config::Table::parse(description, description_path);
  const std::string text = csv_text(log);
  write_whole(csv_path, csv_path.ends_with(".gz") ? compressed(text) : text);
  write_whole(description_path, description);
}

}  // namespace gustlab
