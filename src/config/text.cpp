#include "config/text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>

#include "config/toml.hpp"

namespace gustlab::config {

namespace {

// edits that turn one word into the other: insert, delete, replace, swap of neighbours (optimal string alignment)
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> before(b.size() + 1), above(b.size() + 1), row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) above[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      row[j] = std::min({above[j] + 1, row[j - 1] + 1, above[j - 1] + (a[i - 1] != b[j - 1])});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) row[j] = std::min(row[j], before[j - 2] + 1);
    }
    before.swap(above);
    above.swap(row);
  }
  return above[b.size()];
}

}  // namespace

std::string lower(std::string_view text) {
  std::string result(text);
  std::transform(result.begin(), result.end(), result.begin(), [](unsigned char c) { return std::tolower(c); });
  return result;
}

std::string suggest(std::string_view typed, const std::vector<std::string>& known) {
  const std::string mistyped = lower(typed);
  std::string nearest;
  // of three letters one may be wrong
  std::size_t best = (mistyped.size() <= 3 ? 1 : std::max<std::size_t>(2, mistyped.size() / 3)) + 1;
  for (const std::string& name : known) {
    const std::string other = lower(name);
    // a name that begins with what was typed counts as near
    const bool begins = mistyped.size() >= 3 && (other.starts_with(mistyped) || mistyped.starts_with(other));
    const std::size_t distance = begins ? 1 : edit_distance(mistyped, other);
    if (distance >= best || distance >= name.size()) continue;
    best = distance;
    nearest = name;
  }
  return nearest.empty() ? "" : fmt::format("did you mean \"{}\"?", nearest);
}

std::string shortest(double value) {
  char buffer[32];
  const auto [end, error] = std::to_chars(buffer, buffer + sizeof buffer, value);
  return std::string(buffer, end);
}

std::string quoted(std::string_view text) {
  std::string result = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') result += '\\', result += c;
    else if (c == '\n') result += "\\n";
    else if (c == '\t') result += "\\t";
    else if (byte < 0x20 || byte == 0x7f) result += fmt::format("\\u{:04X}", byte);
    else result += c;
  }
  return result + '"';
}

namespace {

// of words that no path is as long as, the beginning
std::string without_endless_words(std::string_view text) {
  constexpr std::size_t longest = 4096, kept = 60;
  std::string result;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find_first_of(" \n"), text.size());
    const std::string_view word = text.substr(0, end);
    result += end > longest ? fmt::format("{}… ({} characters)", word.substr(0, kept), end) : std::string(word);
    text.remove_prefix(end);
    if (!text.empty()) result += text.front(), text.remove_prefix(1);
  }
  return result;
}

// bytes of the character that begins here; 0: it is no UTF-8
std::size_t character_size(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  if (byte(0) < 0x80) return 1;
  const std::size_t size = byte(0) >> 5 == 0x06 ? 2 : byte(0) >> 4 == 0x0e ? 3 : byte(0) >> 3 == 0x1e ? 4 : 0;
  if (size == 0 || size > text.size()) return 0;
  unsigned code = byte(0) & (0xffU >> (size + 1));
  for (std::size_t i = 1; i < size; ++i) {
    if (byte(i) >> 6 != 2) return 0;
    code = code << 6 | (byte(i) & 0x3fU);
  }
  // longer than it need be, half of a pair of UTF-16, beyond the last
  constexpr unsigned least[] = {0x80, 0x800, 0x10000};
  return code < least[size - 2] || (code >= 0xd800 && code < 0xe000) || code > 0x10ffff ? 0 : size;
}

}  // namespace

std::string valid_utf8(std::string_view text) {
  std::string result;
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t size = character_size(text.substr(i));
    if (size == 0) result += fmt::format("\\x{:02x}", static_cast<unsigned char>(text[i]));
    else result += text.substr(i, size);
    i += std::max<std::size_t>(1, size);
  }
  return result;
}

std::string printable(std::string_view whole) {
  const std::string shortened = without_endless_words(whole);
  const std::string_view text = shortened;
  std::string result;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto byte = static_cast<unsigned char>(text[i]);
    const auto next = static_cast<unsigned char>(i + 1 < text.size() ? text[i + 1] : 0);
    const std::size_t size = character_size(text.substr(i));
    if (size == 0 || (byte < 0x20 && text[i] != '\n') || byte == 0x7f) {
      result += fmt::format("\\x{:02x}", byte);
    } else if (byte == 0xc2 && next >= 0x80 && next < 0xa0) {
      // the second set of control characters, in UTF-8
      result += fmt::format("\\x{:02x}", next);
      ++i;
    } else {
      result += text.substr(i, size);
      i += size - 1;
    }
  }
  return result;
}

}  // namespace gustlab::config
