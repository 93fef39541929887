#include "vehicle/edit_vehicle.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <vector>

namespace gustlab {

namespace {

using Lines = std::vector<std::string>;

Lines split(const std::string& text) {
  Lines lines;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    lines.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return lines;
}

std::string join(const Lines& lines) { return fmt::format("{}\n", fmt::join(lines, "\n")); }

std::string_view trimmed(std::string_view line) {
  const std::size_t begin = line.find_first_not_of(" \t");
  if (begin == std::string_view::npos) return {};
  return line.substr(begin, line.find_last_not_of(" \t\r") - begin + 1);
}

bool is_comment(const std::string& line) { return trimmed(line).starts_with('#'); }
bool is_header(const std::string& line) { return trimmed(line).starts_with('['); }

// first line after the header of [table], and the line after its last; std::nullopt when it is not there
std::optional<std::pair<std::size_t, std::size_t>> find_table(const Lines& lines, std::string_view table) {
  const std::string header = fmt::format("[{}]", table);
  const auto at = std::find_if(lines.begin(), lines.end(),
                               [&](const std::string& line) { return trimmed(line).starts_with(header); });
  if (at == lines.end()) return std::nullopt;
  const auto end = std::find_if(at + 1, lines.end(), is_header);
  return std::pair{static_cast<std::size_t>(at - lines.begin()) + 1, static_cast<std::size_t>(end - lines.begin())};
}

bool sets(const std::string& line, std::string_view key) {
  const std::string_view text = trimmed(line);
  return text.starts_with(key) && trimmed(text.substr(key.size())).starts_with('=');
}

// `# key = …`: a number that was only proposed
bool proposes(const std::string& line, std::string_view key) {
  return is_comment(line) && sets(line.substr(line.find('#') + 1), key);
}

// takes a line and the comment lines right above it out; returns where it was
std::size_t erase_with_comments(Lines& lines, std::size_t at, std::size_t first) {
  std::size_t from = at;
  while (from > first && is_comment(lines[from - 1])) --from;
  lines.erase(lines.begin() + static_cast<std::ptrdiff_t>(from), lines.begin() + static_cast<std::ptrdiff_t>(at) + 1);
  return from;
}

}  // namespace

void drop_key(std::string& text, std::string_view table, std::string_view key) {
  Lines lines = split(text);
  const auto place = find_table(lines, table);
  if (!place) return;
  for (std::size_t i = place->first; i < place->second; ++i) {
    if (!sets(lines[i], key)) continue;
    erase_with_comments(lines, i, place->first);
    break;
  }
  text = join(lines);
}

void set_key(std::string& text, std::string_view table, std::string_view key, std::string_view literal,
             std::string_view source) {
  Lines lines = split(text);
  auto place = find_table(lines, table);
  if (!place) {
    // before the first [[effect]], which may be many
    const auto effect = std::find_if(lines.begin(), lines.end(),
                                     [](const std::string& line) { return trimmed(line).starts_with("[[effect]]"); });
    lines.insert(effect, {fmt::format("[{}]", table), ""});
    place = find_table(lines, table);
  }
  std::size_t at = place->first;
  for (std::size_t i = place->second; i-- > place->first;)
    if (sets(lines[i], key) || proposes(lines[i], key)) i = at = erase_with_comments(lines, i, place->first);
  lines.insert(lines.begin() + static_cast<std::ptrdiff_t>(at),
               {fmt::format("# {}", source), fmt::format("{} = {}", key, literal)});
  text = join(lines);
}

void drop_effect(std::string& text, std::string_view type) {
  Lines lines = split(text);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (!trimmed(lines[i]).starts_with("[[effect]]")) continue;
    auto end = std::find_if(lines.begin() + static_cast<std::ptrdiff_t>(i) + 1, lines.end(), is_header);
    const bool wanted = std::any_of(lines.begin() + static_cast<std::ptrdiff_t>(i), end, [&](const std::string& line) {
      return sets(line, "type") && line.find(fmt::format("\"{}\"", type)) != std::string::npos;
    });
    if (!wanted) continue;
    // comments above the next header are its own
    while (end != lines.end() && (is_comment(*(end - 1)) || trimmed(*(end - 1)).empty())) --end;
    lines.erase(lines.begin() + static_cast<std::ptrdiff_t>(i), end);
    --i;
  }
  text = join(lines);
}

}  // namespace gustlab
