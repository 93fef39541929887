#include "report/page_parts.hpp"

#include <fmt/format.h>

#include "report/page_style.hpp"
#include "report/svg.hpp"

namespace gustlab::report {

std::string page(std::string_view title, const std::string& body) {
  return "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" "
         "content=\"width=device-width, initial-scale=1\">" +
         fmt::format("<title>{}</title><style>{}</style></head>\n<body><main>\n{}</main></body></html>\n",
                     svg::escape(title), page_style(), body);
}

std::string section(std::string_view title, const std::string& body) {
  return body.empty() ? "" : fmt::format("<section><h2>{}</h2>{}</section>", title, body);
}

std::string paragraph(const std::string& words, const char* style) {
  if (words.empty()) return "";
  return fmt::format("<p{}>{}</p>", *style ? fmt::format(" class=\"{}\"", style) : "", svg::escape(words));
}

std::string card_table(const std::vector<Column>& columns, const std::string& rows, const char* style) {
  std::string head;
  for (const Column& column : columns)
    head += fmt::format("<th{}>{}</th>", column.number ? " class=\"n\"" : "", svg::escape(column.title));
  std::string body;
  std::size_t cell = 0, at = 0;
  for (std::size_t next = rows.find("<t"); next != std::string::npos; next = rows.find("<t", at)) {
    body += rows.substr(at, next + 3 - at);
    at = next + 3;
    if (rows[at - 1] == 'r') cell = 0;
    if (rows[at - 1] != 'd' || cell >= columns.size()) continue;
    const std::string& title = columns[cell++].title;
    if (!title.empty()) body += fmt::format(" data-label=\"{}\"", svg::escape(title));
  }
  return fmt::format("<div class=\"scroll\"><table class=\"cards{}\"><tr>{}</tr>{}</table></div>", style, head,
                     body + rows.substr(at));
}

std::string legend(const std::vector<std::pair<std::string, std::string>>& entries) {
  std::string html = "<ul class=\"legend\">";
  for (const auto& [style, label] : entries)
    html += fmt::format(
        "<li><svg style=\"display:inline\" viewBox=\"0 0 26 10\" aria-hidden=\"true\"><path class=\"{}\" d=\"M1 5L25 "
        "5\"/></svg>{}</li>",
        style, svg::escape(label));
  return html + "</ul>";
}

std::string series_style(std::size_t n) { return fmt::format("many m{}", n % 8 + 1); }

}  // namespace gustlab::report
