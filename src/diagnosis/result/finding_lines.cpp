#include "diagnosis/result/finding_lines.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <utility>

namespace gustlab::diagnosis {

namespace {

// A text in turns of words and numbers: one word more than numbers. A number is as it was written.
struct Wording {
  std::vector<std::string> words = {""};
  std::vector<std::string> numbers;
};

Wording wording_of(const std::string& text) {
  const auto digit = [&](std::size_t i) {
    return i < text.size() && std::isdigit(static_cast<unsigned char>(text[i])) != 0;
  };
  const auto letter = [&](std::size_t i) {
    return i < text.size() && std::isalpha(static_cast<unsigned char>(text[i])) != 0;
  };
  Wording wording;
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t first = i;
    // m/s² and u1 are words
    const bool number = (digit(i) || (text[i] == '-' && digit(i + 1))) &&
                        (i == 0 || (!letter(i - 1) && !digit(i - 1) && text[i - 1] != '.'));
    if (!number) {
      wording.words.back() += text[i++];
      continue;
    }
    for (++i; digit(i) || (i < text.size() && text[i] == '.' && digit(i + 1)); ++i) {
    }
    wording.numbers.push_back(text.substr(first, i - first));
    wording.words.emplace_back();
  }
  return wording;
}

struct Line {
  std::string kind, column;
  std::vector<std::string> files;
  Wording wording;
  std::vector<std::pair<std::string, std::string>> range;  // per number: least and most

  bool is_of(const LogFinding& finding, const Wording& said) const {
    return kind == finding.kind && column == finding.column && wording.words == said.words;
  }
  void add(const std::string& file, const Wording& said) {
    if (std::find(files.begin(), files.end(), file) == files.end()) files.push_back(file);
    for (std::size_t i = 0; i < range.size(); ++i) {
      const auto value = [](const std::string& text) { return std::strtod(text.c_str(), nullptr); };
      if (value(said.numbers[i]) < value(range[i].first)) range[i].first = said.numbers[i];
      if (value(said.numbers[i]) > value(range[i].second)) range[i].second = said.numbers[i];
    }
  }
  std::string text(std::size_t flights) const {
    std::string says = wording.words.front();
    for (std::size_t i = 0; i < range.size(); ++i) {
      const auto& [least, most] = range[i];
      says += (least == most ? least : fmt::format("{}…{}", least, most)) + wording.words[i + 1];
    }
    const std::string where = files.size() == 1
                                  ? files.front()
                                  : fmt::format("{} of {} flights", files.size(), std::max(flights, files.size()));
    return fmt::format("{}: {}{}", where, column == "*" || column.empty() ? "" : column + ": ", says);
  }
};

}  // namespace

std::vector<FindingLine> finding_lines(const std::vector<LogFinding>& findings, std::size_t flights) {
  std::vector<Line> lines;
  for (const LogFinding& finding : findings) {
    const Wording said = wording_of(finding.says);
    auto line = std::find_if(lines.begin(), lines.end(), [&](const Line& l) { return l.is_of(finding, said); });
    if (line == lines.end()) {
      line = lines.insert(lines.end(), {finding.kind, finding.column, {}, said, {}});
      for (const std::string& number : said.numbers) line->range.emplace_back(number, number);
    }
    line->add(finding.file, said);
  }
  std::vector<FindingLine> texts;
  for (const Line& line : lines) texts.push_back({line.kind, line.text(flights)});
  return texts;
}

}  // namespace gustlab::diagnosis
