#include "flight_log/csv.hpp"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <unordered_set>

#include "gustlab/errors.hpp"

namespace gustlab {

namespace {

constexpr std::size_t most_bytes = std::size_t{4} << 30;
constexpr double no_sample = std::numeric_limits<double>::quiet_NaN();

// zlib reads plain files as they are
std::string read_bytes(const std::string& path) {
  errno = 0;
  const std::unique_ptr<gzFile_s, int (*)(gzFile)> file(gzopen(path.c_str(), "rb"), gzclose_r);
  if (!file) throw DataError(fmt::format("{}: cannot read ({})", path, std::strerror(errno ? errno : ENOMEM)));
  gzbuffer(file.get(), 1U << 17);
  std::string text;
  constexpr unsigned block = 1U << 16;
  for (;;) {
    const std::size_t size = text.size();
    text.resize(size + block);
    const int got = gzread(file.get(), text.data() + size, block);
    text.resize(size + static_cast<std::size_t>(std::max(got, 0)));
    if (text.size() > most_bytes)
      throw DataError(fmt::format("{}: cannot read (it is larger than {} MiB, decompressed)", path, most_bytes >> 20));
    int code = Z_OK;
    const char* why = gzerror(file.get(), &code);
    if (got < 0 || (code != Z_OK && code != Z_STREAM_END))
      throw DataError(fmt::format("{}: cannot read ({})", path, code == Z_ERRNO ? std::strerror(errno) : why));
    if (got == 0) return text;
  }
}

constexpr std::size_t longest_cell = 40;  // of what a message shows

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
  while (!text.empty() && (text.back() == ' ' || text.back() == '\t' || text.back() == '\r')) text.remove_suffix(1);
  return text;
}

// the cell that starts at `begin`; npos behind the last
std::size_t cell_end(std::string_view line, std::size_t begin) { return std::min(line.find(',', begin), line.size()); }

}  // namespace

CsvNumbers::CsvNumbers(const std::string& path, bool (*lenient)(std::string_view))
    : path_(path), text_(read_bytes(path)) {
  std::size_t begin = text_.starts_with("\xEF\xBB\xBF") ? 3 : 0, number = 0;
  std::vector<bool> is_lenient;
  while (begin < text_.size()) {
    const std::size_t end = std::min(text_.find('\n', begin), text_.size());
    const std::string_view line(text_.data() + begin, end - begin);
    ++number;
    if (number == 1) {
      const auto is_control = [](char c) { return static_cast<unsigned char>(c) < 0x20 && c != '\t' && c != '\r'; };
      if (const auto wrong = std::find_if(line.begin(), line.end(), is_control); wrong != line.end())
        throw DataError(fmt::format("{}:1:{}: not a text file (a CSV is needed)", path_, wrong - line.begin() + 1));
      read_header(line);
      for (const std::string& name : names_) is_lenient.push_back(lenient(name));
    } else if (!trimmed(line).empty()) {
      read_row(number, begin, line, is_lenient);
    }
    begin = end + 1;
  }
  if (names_.empty())
    throw DataError(fmt::format("{}:1:1: the file is empty (a header line and samples are needed)", path_));
}

void CsvNumbers::read_header(std::string_view line) {
  std::unordered_set<std::string> seen;
  for (std::size_t begin = 0; begin <= line.size(); begin = cell_end(line, begin) + 1) {
    std::string name(trimmed(line.substr(begin, cell_end(line, begin) - begin)));
    if (name.empty()) throw DataError(fmt::format("{}:1:{}: a column has no name", path_, begin + 1));
    if (!seen.insert(name).second)
      throw DataError(fmt::format("{}:1:{}: column \"{}\" is here twice", path_, begin + 1, name));
    names_.push_back(std::move(name));
  }
  columns_.resize(names_.size());
}

void CsvNumbers::read_row(std::size_t number, std::size_t line_begin, std::string_view line,
                          const std::vector<bool>& lenient) {
  std::size_t column = 0;
  for (std::size_t begin = 0; begin <= line.size(); begin = cell_end(line, begin) + 1, ++column) {
    if (column == names_.size())
      throw DataError(fmt::format("{}:{}:{}: this row has more cells than the header's {}", path_, number, begin + 1,
                                  names_.size()));
    std::string_view cell = trimmed(line.substr(begin, cell_end(line, begin) - begin));
    if (cell.starts_with('+')) cell.remove_prefix(1);
    double value = no_sample;
    if (!cell.empty()) {
      const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
      const bool number_read = error == std::errc() && end == cell.data() + cell.size();
      if (!number_read || !std::isfinite(value)) {
        if (!lenient[column])
          throw DataError(fmt::format(
              "{}:{}:{}: \"{}\" in column {} is not a {}number (a missing sample is an empty cell)", path_, number,
              begin + 1, cell.substr(0, longest_cell), names_[column], number_read ? "finite " : ""));
        value = no_sample;
      }
    }
    columns_[column].push_back(value);
  }
  if (column < names_.size())
    throw DataError(fmt::format("{}:{}:{}: this row has {} cells, the header {}", path_, number, line.size() + 1,
                                column, names_.size()));
  lines_.push_back({number, line_begin});
}

bool CsvNumbers::same(std::size_t row, std::size_t other) const {
  return std::all_of(columns_.begin(), columns_.end(), [=](const std::vector<double>& values) {
    return values[row] == values[other] || (std::isnan(values[row]) && std::isnan(values[other]));
  });
}

std::string CsvNumbers::where(std::size_t number, std::size_t line_begin, std::size_t column) const {
  std::size_t begin = line_begin;
  for (std::size_t i = 0; i < column; ++i) begin = text_.find(',', begin) + 1;
  return fmt::format("{}:{}:{}", path_, number, begin - line_begin + 1);
}

std::string CsvNumbers::where(std::size_t row, std::size_t column) const {
  return where(lines_[row].number, lines_[row].begin, column);
}

std::string CsvNumbers::where_name(std::size_t column) const { return where(1, 0, column); }

std::string CsvNumbers::where_row(std::size_t row) const { return fmt::format("{}:{}", path_, lines_[row].number); }

void CsvNumbers::keep(const std::vector<bool>& wanted) {
  const auto filter = [&](auto& values) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < values.size(); ++i)
      if (wanted[i]) values[kept++] = values[i];
    values.resize(kept);
  };
  for (auto& values : columns_) filter(values);
  filter(lines_);
}

}  // namespace gustlab
