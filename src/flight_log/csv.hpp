// A CSV of numbers, whole in memory, that remembers where each cell stands.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace gustlab {

class CsvNumbers {
 public:
  // Reads a plain or gzip-compressed file. `lenient(name)`: a column in which a cell that is not a finite number counts as
  // empty. Throws DataError at file:line:col of the cell.
  CsvNumbers(const std::string& path, bool (*lenient)(std::string_view name));

  const std::vector<std::string>& names() const { return names_; }
  std::size_t rows() const { return lines_.size(); }
  // one value per row; NaN: empty
  std::vector<double>& column(std::size_t index) { return columns_[index]; }
  const std::vector<double>& column(std::size_t index) const { return columns_[index]; }
  bool same(std::size_t row, std::size_t other) const;

  // file:line:col of a cell, of a column's name, of a row
  std::string where(std::size_t row, std::size_t column) const;
  std::string where_name(std::size_t column) const;
  std::string where_row(std::size_t row) const;
  // Keeps the rows whose flag is set.
  void keep(const std::vector<bool>& wanted);

 private:
  void read_header(std::string_view line);
  void read_row(std::size_t line_number, std::size_t begin, std::string_view line, const std::vector<bool>& lenient);
  std::string where(std::size_t line_number, std::size_t line_begin, std::size_t column) const;

  struct Line {
    std::size_t number, begin;
  };
  std::string path_, text_;
  std::vector<std::string> names_;
  std::vector<Line> lines_;
  std::vector<std::vector<double>> columns_;
};

}  // namespace gustlab
