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

#include "config/text.hpp"
#include "gustlab/errors.hpp"

namespace gustlab {

namespace {

constexpr std::size_t most_bytes = std::size_t{4} << 30;
constexpr double no_sample = std::numeric_limits<double>::quiet_NaN();

}  // namespace

// Lines of a file, one after the other; zlib reads plain files as they are. In memory is the longest line.
class CsvLines {
 public:
  explicit CsvLines(const std::string& path) : path_(path), file_(nullptr, gzclose_r) {
    errno = 0;
    file_.reset(gzopen(path.c_str(), "rb"));
    if (!file_) throw DataError(fmt::format("{}: cannot read ({})", path, std::strerror(errno ? errno : ENOMEM)));
    gzbuffer(file_.get(), 2 * block);
    read_block();
    if (text_.starts_with("\xEF\xBB\xBF")) end_ = 3;
  }

  // The next line, which stays until the next call; false behind the last.
  bool next(std::string_view& line) {
    std::size_t searched = 0, end = std::string::npos;
    begin_ = end_;
    while ((end = text_.find('\n', begin_ + searched)) == std::string::npos) {
      searched = text_.size() - begin_;
      text_.erase(0, begin_);
      before_ += begin_;
      begin_ = 0;
      if (!read_block()) break;
    }
    end = std::min(end, text_.size());
    if (begin_ == text_.size()) return end_ = begin_, false;
    line = std::string_view(text_).substr(begin_, end - begin_);
    end_ = std::min(end + 1, text_.size());
    ++number_;
    return true;
  }
  // of that line, from 1; where it starts in the text
  std::size_t number() const { return number_; }
  std::size_t begin() const { return before_ + begin_; }

  // goes on at a line's begin
  void seek(std::size_t begin) {
    if (gzseek(file_.get(), static_cast<z_off_t>(begin), SEEK_SET) < 0) throw DataError(path_ + ": cannot read again");
    text_.clear();
    begin_ = end_ = 0;
    before_ = begin;
  }

 private:
  static constexpr unsigned block = 1U << 16;

  bool read_block() {
    const std::size_t size = text_.size();
    text_.resize(size + block);
    const int got = gzread(file_.get(), text_.data() + size, block);
    text_.resize(size + static_cast<std::size_t>(std::max(got, 0)));
    if (before_ + text_.size() > most_bytes)
      throw DataError(fmt::format("{}: cannot read (it is larger than {} MiB, decompressed)", path_, most_bytes >> 20));
    int code = Z_OK;
    const char* why = gzerror(file_.get(), &code);
    if (got < 0 || (code != Z_OK && code != Z_STREAM_END))
      throw DataError(fmt::format("{}: cannot read ({})", path_, code == Z_ERRNO ? std::strerror(errno) : why));
    return got > 0;
  }

  std::string path_;
  std::unique_ptr<gzFile_s, int (*)(gzFile)> file_;
  std::string text_;
  std::size_t before_ = 0;           // bytes of the file before this text
  std::size_t begin_ = 0, end_ = 0;  // of the line; where the next begins
  std::size_t number_ = 0;
};

namespace {

constexpr std::size_t longest_cell = 40;  // of what a message shows

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
  while (!text.empty() && (text.back() == ' ' || text.back() == '\t' || text.back() == '\r')) text.remove_suffix(1);
  return text;
}

// where the cell that starts at `begin` ends
std::size_t cell_end(std::string_view line, std::size_t begin) { return std::min(line.find(',', begin), line.size()); }

std::string_view cell_at(std::string_view line, std::size_t begin) {
  std::string_view cell = trimmed(line.substr(begin, cell_end(line, begin) - begin));
  if (cell.starts_with('+')) cell.remove_prefix(1);
  return cell;
}

// whether all of the cell is a number
bool read_number(std::string_view cell, double& value) {
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  return error == std::errc() && end == cell.data() + cell.size();
}

// NaN: no finite number
double number_of(std::string_view cell) {
  double value = no_sample;
  return read_number(cell, value) && std::isfinite(value) ? value : no_sample;
}

// NaN: there is no such cell
double number_in(std::string_view line, std::size_t column) {
  std::size_t begin = 0;
  for (; column > 0 && begin <= line.size(); --column) begin = cell_end(line, begin) + 1;
  return begin <= line.size() ? number_of(cell_at(line, begin)) : no_sample;
}

}  // namespace

CsvNumbers::CsvNumbers(const std::string& path, bool (*lenient)(std::string_view), const std::vector<TimeRange>& only,
                       std::size_t most_rows)
    : path_(path), text_(std::make_unique<CsvLines>(path)), only_(only), most_rows_(most_rows) {
  std::string_view line;
  if (!text_->next(line))
    throw DataError(fmt::format("{}:1:1: the file is empty (a header line and samples are needed)", path_));
  const auto is_control = [](char c) { return static_cast<unsigned char>(c) < 0x20 && c != '\t' && c != '\r'; };
  if (const auto wrong = std::find_if(line.begin(), line.end(), is_control); wrong != line.end())
    throw DataError(fmt::format("{}:1:{}: not a text file (a CSV is needed)", path_, wrong - line.begin() + 1));
  read_header(line);
  for (const std::string& name : names_) lenient_.push_back(lenient(name));
  time_ = static_cast<std::size_t>(std::find(names_.begin(), names_.end(), "time_s") - names_.begin());
  read_on();
}

CsvNumbers::~CsvNumbers() = default;
CsvNumbers::CsvNumbers(CsvNumbers&&) noexcept = default;

void CsvNumbers::read_on() {
  lines_.clear();
  for (auto& values : columns_) values.clear();
  std::string_view line;
  while (!at_end_ && lines_.size() < most_rows_) {
    if (!text_->next(line)) {
      at_end_ = true;
      text_.reset();
      break;
    }
    if (trimmed(line).empty() || !wanted(line)) continue;
    lines_.push_back({text_->number(), text_->begin()});
    read_row(line);
  }
}

bool CsvNumbers::wanted(std::string_view line) const {
  if (only_.empty()) return true;
  const double time_s = number_in(line, time_);
  return std::any_of(only_.begin(), only_.end(),
                     [=](const TimeRange& range) { return time_s >= range.from_s && time_s < range.to_s; });
}

void CsvNumbers::read_header(std::string_view line) {
  const std::string_view names = trimmed(line);
  if (const std::size_t other = names.find_first_of(";\t");
      other != std::string_view::npos && names.find(',') == std::string_view::npos)
    throw DataError(
        fmt::format("{}:1:{}: not comma-separated ({} stand between its columns); write commas there, and "
                    "points in numbers",
                    path_, names.data() - line.data() + static_cast<std::ptrdiff_t>(other) + 1,
                    names[other] == ';' ? "semicolons" : "tabs"));
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

void CsvNumbers::read_row(std::string_view line) {
  const std::size_t number = lines_.back().number;
  std::size_t column = 0;
  for (std::size_t begin = 0; begin <= line.size(); begin = cell_end(line, begin) + 1, ++column) {
    if (column == names_.size())
      throw DataError(fmt::format("{}:{}:{}: this row has more cells than the header's {}", path_, number, begin + 1,
                                  names_.size()));
    const std::string_view cell = cell_at(line, begin);
    double value = no_sample;
    if (!cell.empty()) {
      const bool number_read = read_number(cell, value);
      if (!number_read || !std::isfinite(value)) {
        if (!lenient_[column])
          throw DataError(
              fmt::format("{}:{}:{}: \"{}\" in column {} is not a {}number (a missing sample is an empty cell)", path_,
                          number, begin + 1, config::printable(cell.substr(0, longest_cell)), names_[column],
                          number_read ? "finite " : ""));
        value = no_sample;
      }
    }
    columns_[column].push_back(value);
  }
  if (column < names_.size())
    throw DataError(fmt::format("{}:{}:{}: this row has {} cells, the header {}", path_, number, line.size() + 1,
                                column, names_.size()));
}

std::vector<double> CsvNumbers::cells(std::size_t row) const {
  std::vector<double> result;
  for (const auto& values : columns_) result.push_back(values[row]);
  return result;
}

bool CsvNumbers::same(std::size_t row, const std::vector<double>& cells) const {
  for (std::size_t c = 0; c < columns_.size(); ++c)
    if (columns_[c][row] != cells[c] && !(std::isnan(columns_[c][row]) && std::isnan(cells[c]))) return false;
  return true;
}

// only a message asks for a column's place: the line is read again
std::string CsvNumbers::where(const Line& line, std::size_t column) const {
  CsvLines lines(path_);
  lines.seek(line.begin);
  std::string_view text;
  lines.next(text);
  std::size_t begin = 0;
  for (std::size_t i = 0; i < column; ++i) begin = cell_end(text, begin) + 1;
  return fmt::format("{}:{}:{}", path_, line.number, begin + 1);
}

std::string CsvNumbers::where(std::size_t row, std::size_t column) const { return where(lines_[row], column); }

std::string CsvNumbers::where_name(std::size_t column) const { return where({1, 0}, column); }

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

void for_each_row(const std::string& path, const std::vector<std::string>& columns,
                  const std::function<void(const std::vector<double>& cells)>& row) {
  CsvLines lines(path);
  std::string_view line;
  std::vector<std::size_t> slots;  // of each column of the file, where its cell goes
  std::vector<double> cells;
  while (lines.next(line)) {
    if (lines.number() > 1 && trimmed(line).empty()) continue;
    cells.assign(columns.size(), no_sample);
    std::size_t column = 0;
    for (std::size_t begin = 0; begin <= line.size(); begin = cell_end(line, begin) + 1, ++column) {
      const auto slot_of = [&](std::string_view name) {
        return static_cast<std::size_t>(std::find(columns.begin(), columns.end(), name) - columns.begin());
      };
      if (lines.number() == 1) slots.push_back(slot_of(cell_at(line, begin)));
      else if (column < slots.size() && slots[column] < cells.size())
        cells[slots[column]] = number_of(cell_at(line, begin));
    }
    if (lines.number() > 1) row(cells);
  }
}

}  // namespace gustlab
