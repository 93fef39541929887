// What the pages share: the frame of a page, sections, paragraphs, legends.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace gustlab::report {

// A whole page: one file without script, network or date, for light, dark, paper and a phone.
std::string page(std::string_view title, const std::string& body);
// Empty when its body is.
std::string section(std::string_view title, const std::string& body);
// Of escaped text; empty when there is none.
std::string paragraph(const std::string& words, const char* style = "");
struct Column {
  std::string title;
  bool number = false;
};
// A table of rows "<tr><td>...</td>...</tr>" without tables in their cells, which a phone shows as cards: the cell of class "name",
// then each other one under its column's title. `style`: more classes, each after a space.
std::string card_table(const std::vector<Column>& columns, const std::string& rows, const char* style = "");
// (class of the line, what it is)
std::string legend(const std::vector<std::pair<std::string, std::string>>& entries);
// Class of the n-th line of a chart that has many, from 0.
std::string series_style(std::size_t n);

}  // namespace gustlab::report
