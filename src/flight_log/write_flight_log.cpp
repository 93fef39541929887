#include "flight_log/write_flight_log.hpp"

#include <fmt/format.h>
#include <zlib.h>

#include <array>
#include <charconv>
#include <cmath>
#include <functional>

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

using Sink = std::function<void(std::string_view)>;

// the rows as text, in blocks
void write_csv(const FlightLog& log, const Sink& sink) {
  constexpr std::size_t block_bytes = 1 << 16;
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
    if (text.size() > block_bytes) sink(text), text.clear();
  }
  sink(text);
}

// gzip with an empty header: no name, no time
class Gzip {
 public:
  explicit Gzip(Sink sink) : sink_(std::move(sink)) {
    constexpr int gzip_window = 15 + 16, memory_level = 8;
    if (deflateInit2(&stream_, Z_DEFAULT_COMPRESSION, Z_DEFLATED, gzip_window, memory_level, Z_DEFAULT_STRATEGY) !=
        Z_OK)
      throw IoError("zlib cannot start");
  }
  Gzip(const Gzip&) = delete;
  Gzip& operator=(const Gzip&) = delete;
  ~Gzip() { deflateEnd(&stream_); }
  void add(std::string_view text) { compress(text, Z_NO_FLUSH); }
  void finish() { compress({}, Z_FINISH); }

 private:
  void compress(std::string_view text, int flush) {
    stream_.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(text.data()));
    stream_.avail_in = static_cast<uInt>(text.size());
    do {
      std::array<char, 1 << 16> bytes;
      stream_.next_out = reinterpret_cast<Bytef*>(bytes.data());
      stream_.avail_out = static_cast<uInt>(bytes.size());
      if (deflate(&stream_, flush) == Z_STREAM_ERROR) throw IoError("zlib cannot compress the log");
      sink_({bytes.data(), bytes.size() - stream_.avail_out});
    } while (stream_.avail_out == 0);
  }

  Sink sink_;
  z_stream stream_{};
};

}  // namespace

void write_flight_log(const FlightLog& log, const std::string& csv_path, const std::function<void()>& between) {
  const std::string description = sidecar_text(log.meta), description_path = sidecar_path(csv_path);
  config::Table::parse(description, description_path);
  write_together([&] {
    write_file(csv_path, [&](std::ostream& file) {
      const Sink to_file = [&](std::string_view bytes) {
        between();
        file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
      };
      if (!csv_path.ends_with(".gz")) return write_csv(log, to_file);
      Gzip gzip(to_file);
      write_csv(log, [&](std::string_view text) { gzip.add(text); });
      gzip.finish();
    });
    write_file(description_path, description);
  });
}

void write_flight_log(const FlightLog& log, const std::string& csv_path) {
  write_flight_log(log, csv_path, [] {});
}

}  // namespace gustlab
