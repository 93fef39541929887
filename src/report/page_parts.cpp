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
