// A CSV of numbers, plain or gzip-compressed: its rows in memory, with the place of each, all at once or some at a time; or one after the other.
#pragma once

#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "gustlab/flight_log.hpp"

namespace gustlab {

class CsvLines;

class CsvNumbers {
 public:
  static constexpr std::size_t all_rows = std::numeric_limits<std::size_t>::max();

  // Reads the first rows, at most so many. `lenient(name)`: a column in which a cell that is not a finite number counts as empty. `only`:
  // without the rows whose time_s lies in none of these (empty: all rows). Throws DataError at file:line:col of the cell.
  CsvNumbers(const std::string& path, bool (*lenient)(std::string_view name), const std::vector<TimeRange>& only = {},
             std::size_t most_rows = all_rows);
  ~CsvNumbers();
  CsvNumbers(CsvNumbers&&) noexcept;

  // Forgets these rows and reads those behind them; there may be none.
  void read_on();
  // no row is left to read
  bool at_end() const { return at_end_; }

  const std::vector<std::string>& names() const { return names_; }
  std::size_t rows() const { return lines_.size(); }
  // one value per row; NaN: empty
  std::vector<double>& column(std::size_t index) { return columns_[index]; }
  const std::vector<double>& column(std::size_t index) const { return columns_[index]; }
  std::vector<double> cells(std::size_t row) const;
  // whether two rows, or a row and cells, hold the same
  bool same(std::size_t row, std::size_t other) const { return same(row, cells(other)); }
  bool same(std::size_t row, const std::vector<double>& cells) const;

  // where a row stands in the file: its line, from 1, and where that starts in the text
  struct Line {
    std::size_t number, begin;
  };
  const Line& line(std::size_t row) const { return lines_[row]; }
  // file:line:col of a cell, of a column's name, of a row
  std::string where(const Line& line, std::size_t column) const;
  std::string where(std::size_t row, std::size_t column) const;
  std::string where_name(std::size_t column) const;
  std::string where_row(std::size_t row) const;
  // Keeps the rows whose flag is set.
  void keep(const std::vector<bool>& wanted);

 private:
  void read_header(std::string_view line);
  void read_row(std::string_view line);
  bool wanted(std::string_view line) const;

  std::string path_;
  std::unique_ptr<CsvLines> text_;
  std::vector<TimeRange> only_;
  std::size_t most_rows_, time_ = 0;
  bool at_end_ = false;
  std::vector<bool> lenient_;  // of each column
  std::vector<std::string> names_;
  std::vector<Line> lines_;
  std::vector<std::vector<double>> columns_;
};

// Calls `row` with the cells of these columns, row after row, and keeps nothing. A cell that is no finite number, or not there, is NaN.
// Throws DataError when the file cannot be read.
void for_each_row(const std::string& path, const std::vector<std::string>& columns,
                  const std::function<void(const std::vector<double>& cells)>& row);

}  // namespace gustlab
