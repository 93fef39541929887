// The one translation unit that knows toml++.
#include "config/toml.hpp"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>
#include <set>
#include <sstream>

#include "config/text.hpp"
#include "gustlab/errors.hpp"
#include "util/files.hpp"

namespace gustlab::config {

namespace {

constexpr std::string_view command_line = "--set ";

std::string place(const toml::source_region& source, const std::string& path) {
  const std::string& file = source.path ? *source.path : path;
  // an override has no line of its own
  if (file.starts_with(command_line) || source.begin.line == 0) return file;
  return fmt::format("{}:{}:{}", file, source.begin.line, source.begin.column);
}

std::string name(toml::node_type type) {
  switch (type) {
    case toml::node_type::table:
      return "a table";
    case toml::node_type::array:
      return "an array";
    case toml::node_type::string:
      return "a string";
    case toml::node_type::integer:
      return "an integer";
    case toml::node_type::floating_point:
      return "a number";
    case toml::node_type::boolean:
      return "true or false";
    default:
      return "a date or time";
  }
}

std::string literal_text(const toml::node& node) {
  if (const auto* value = node.as_string()) return config::quoted(value->get());
  if (const auto* value = node.as_integer()) return fmt::format("{}", value->get());
  if (const auto* value = node.as_boolean()) return value->get() ? "true" : "false";
  if (const auto* value = node.as_floating_point()) {
    // a number that was written as one must not read back as an integer
    std::string text = shortest(value->get());
    return text.find_first_of(".en") == std::string::npos ? text + ".0" : text;
  }
  std::string text;
  if (const auto* array = node.as_array()) {
    for (const toml::node& item : *array) text += (text.empty() ? "" : ", ") + literal_text(item);
    return "[" + text + "]";
  }
  if (const auto* table = node.as_table()) {
    for (const auto& [key, item] : *table)
      text += fmt::format("{}{} = {}", text.empty() ? "" : ", ", config::quoted(key.str()), literal_text(item));
    return text.empty() ? "{}" : "{ " + text + " }";
  }
  std::ostringstream out;
  node.visit([&out](const auto& value) {
    if constexpr (toml::is_chronological<decltype(value)>) out << value.get();
  });
  return out.str();
}

// nothing that is read from a file may be NaN or infinite
double finite(const Table& table, const toml::node& node, std::string_view key) {
  const double value = *node.value<double>();
  if (!std::isfinite(value)) table.fail(key, fmt::format("\"{}\" must be finite", key), "", "");
  return value;
}

// Tables within tables are destroyed one within the other: what is deeper than any file needs would end the program. toml++
// itself bounds arrays and inline tables, not dotted keys.
constexpr int most_dots = 32;
void check_depth(std::string_view text, const std::string& path) {
  std::size_t line = 1, begin = 0;
  int dots = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '#') {
      i = std::min(text.find('\n', i), text.size()) - 1;
    } else if (c == '"' || c == '\'') {
      // to the end of the string, which toml++ judges; a newline ends one that is never closed
      const bool several = text.substr(i, 3) == std::string(3, c);
      for (i += several ? 3 : 1;
           i < text.size() && (several ? text.substr(i, 3) != std::string(3, c) : text[i] != c && text[i] != '\n');
           ++i) {
        if (c == '"' && text[i] == '\\') ++i;
        if (i < text.size() && text[i] == '\n') ++line, begin = i + 1;
      }
      if (several) i += 2;
      else if (i < text.size() && text[i] == '\n') --i;
    } else if (c == '.') {
      if (++dots > most_dots)
        throw ConfigError(
            fmt::format("{}:{}:{}: a key of more than {} parts (nothing is nested as deep) write a shorter one", path,
                        line, i - begin + 1, most_dots));
    } else if (c != ' ' && c != '\t' && c != '_' && c != '-' && !std::isalnum(static_cast<unsigned char>(c))) {
      dots = 0;
      if (c == '\n') ++line, begin = i + 1;
    }
  }
}

toml::table parse_text(std::string_view text, const std::string& path) {
  check_depth(text, path);
  try {
    return toml::parse(text, path);
  } catch (const toml::parse_error& error) {
    throw ConfigError(fmt::format("{}: not TOML ({})", place(error.source(), path), error.description()));
  }
}

toml::table parse_override(const std::string& text) {
  const std::string where = std::string(command_line) + text;
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0)
    throw ConfigError(
        fmt::format("{}: not an override (there is no key before an equals sign) write --set key=value", where));
  check_depth(text, where);
  try {
    return toml::parse(text, where);
  } catch (const toml::parse_error&) {
    // a bare word is a string
    return parse_text(text.substr(0, equals + 1) + config::quoted(text.substr(equals + 1)), where);
  }
}

void add_leaves(const toml::table& table, const std::string& prefix, std::vector<std::string>& keys) {
  for (const auto& [key, value] : table) {
    const std::string name = prefix + std::string(key.str());
    if (const toml::table* inner = value.as_table(); inner != nullptr && !inner->empty())
      add_leaves(*inner, name + ".", keys);
    else keys.push_back(name);
  }
}

// "a, b" → a and b
std::vector<std::string> split_words(std::string_view text) {
  std::vector<std::string> words(1);
  for (const char c : text) {
    if (c == ',') words.emplace_back();
    else if (c != ' ') words.back() += c;
  }
  return words;
}

// moves what an override says into the document; in an array of tables a name means the table with that type
void merge(toml::table& into, toml::table&& from, const std::string& path) {
  for (auto&& [key, value] : from) {
    toml::node* old = into.get(key);
    if (value.is_table() && old != nullptr && old->is_table()) {
      merge(*old->as_table(), std::move(*value.as_table()), path);
    } else if (value.is_table() && old != nullptr && old->is_array_of_tables()) {
      for (auto&& [type, item] : *value.as_table()) {
        toml::table* entry = nullptr;
        std::vector<std::string> types;
        for (toml::node& candidate : *old->as_array()) {
          types.push_back((*candidate.as_table())["type"].value_or(std::string()));
          if (types.back() == type.str()) entry = candidate.as_table();
        }
        if (entry == nullptr || !item.is_table())
          throw ConfigError(fmt::format("{}: there is no {}.{} to change {}", place(item.source(), path), key.str(),
                                        type.str(), suggest(type.str(), types)));
        merge(*entry, std::move(*item.as_table()), path);
      }
    } else {
      // named once more: clang 14 lets no lambda take part of a structured binding
      value.visit([&into, &name = key](auto&& node) { into.insert_or_assign(name, std::move(node)); });
    }
  }
}

}  // namespace

struct Table::Node {
  std::shared_ptr<toml::table> document;
  toml::table* table = nullptr;
  std::string path;
  std::map<std::string, std::string, std::less<>> places;  // where a key was written, if not in this document
  std::set<std::string, std::less<>> asked;
  std::map<std::string, std::shared_ptr<Node>, std::less<>> children;

  toml::node* ask(std::string_view key) {
    asked.emplace(key);
    return table->get(key);
  }
  std::string known_place(std::string_view key) const {
    const auto known = places.find(key);
    return known == places.end() ? path : known->second;
  }
  // of an entry of an array; an effect's spec knows the array's alone
  std::string entry_place(const toml::node& entry, std::string_view key) const {
    return places.empty() ? place(entry.source(), path) : known_place(key);
  }
};

Table Table::read_file(const std::string& path, const std::vector<std::string>& overrides) {
  return parse(gustlab::read_file<ConfigError>(path), path, overrides);
}

Table Table::parse(std::string_view text, const std::string& path, const std::vector<std::string>& overrides) {
  Table result;
  result.node_ = std::make_shared<Node>();
  result.node_->document = std::make_shared<toml::table>(parse_text(text, path));
  result.node_->table = result.node_->document.get();
  result.node_->path = path;
  for (const std::string& override_text : overrides) merge(*result.node_->table, parse_override(override_text), path);
  return result;
}

Table Table::of_effect(const EffectSpec& spec) {
  std::string text;
  for (const auto& [key, value] : spec.values) text += fmt::format("{} = {}\n", config::quoted(key), value);
  Table result = parse(text, spec.where);
  auto& places = result.node_->places;
  places[""] = spec.where;
  for (std::size_t i = 0; i < spec.value_where.size(); ++i) places[spec.values[i].first] = spec.value_where[i];
  return result;
}

bool Table::has(std::string_view key) const { return node_->table->contains(key); }

const std::string& Table::path() const { return node_->path; }

std::string Table::where(std::string_view key) const {
  if (!node_->places.empty()) return node_->known_place(key);
  const toml::node* node = key.empty() ? nullptr : node_->table->get(key);
  return place(node ? node->source() : node_->table->source(), node_->path);
}

std::vector<std::string> Table::keys() const {
  std::vector<std::pair<toml::source_position, std::string>> ordered;
  for (const auto& [key, value] : *node_->table) ordered.emplace_back(key.source().begin, key.str());
  std::stable_sort(ordered.begin(), ordered.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<std::string> names;
  for (auto& [position, key] : ordered) names.push_back(std::move(key));
  return names;
}

void Table::fail(std::string_view key, const std::string& problem, const std::string& why,
                 const std::string& suggestion) const {
  std::string message = where(has(key) ? key : std::string_view{}) + ": " + problem;
  if (!why.empty()) message += " (" + why + ")";
  if (!suggestion.empty()) message += " " + suggestion;
  throw ConfigError(message);
}

// the value under a key as one type; absent is not an error, another type is
#define GUSTLAB_EXPECT(node, condition, key, what) \
  if (!(condition))                                \
  fail(key, fmt::format("\"{}\" must be {}", key, what), fmt::format("this is {}", name((node)->type())), "")

std::optional<double> Table::number(std::string_view key) {
  const toml::node* node = node_->ask(key);
  if (node == nullptr) return std::nullopt;
  GUSTLAB_EXPECT(node, node->is_number(), key, "a number");
  return finite(*this, *node, key);
}

std::optional<std::int64_t> Table::integer(std::string_view key) {
  const toml::node* node = node_->ask(key);
  if (node == nullptr) return std::nullopt;
  GUSTLAB_EXPECT(node, node->is_integer(), key, "an integer");
  return node->value<std::int64_t>();
}

std::optional<bool> Table::flag(std::string_view key) {
  const toml::node* node = node_->ask(key);
  if (node == nullptr) return std::nullopt;
  GUSTLAB_EXPECT(node, node->is_boolean(), key, "true or false");
  return node->value<bool>();
}

std::optional<std::string> Table::text(std::string_view key) {
  const toml::node* node = node_->ask(key);
  if (node == nullptr) return std::nullopt;
  GUSTLAB_EXPECT(node, node->is_string(), key, "a string");
  return node->value<std::string>();
}

std::optional<std::vector<double>> Table::numbers(std::string_view key) {
  toml::node* node = node_->ask(key);
  if (node == nullptr) return std::nullopt;
  GUSTLAB_EXPECT(node, node->is_array(), key, "an array of numbers");
  std::vector<double> values;
  for (const toml::node& item : *node->as_array()) {
    if (!item.is_number())
      throw ConfigError(fmt::format("{}: \"{}\" must be an array of numbers (this entry is {})",
                                    node_->entry_place(item, key), key, name(item.type())));
    values.push_back(finite(*this, item, key));
  }
  return values;
}

std::optional<std::vector<std::string>> Table::texts(std::string_view key) {
  toml::node* node = node_->ask(key);
  if (node == nullptr) return std::nullopt;
  if (const auto path = node->source().path; node->is_string() && path && path->starts_with(command_line))
    return split_words(**node->as_string());
  GUSTLAB_EXPECT(node, node->is_array(), key, "an array of strings");
  std::vector<std::string> values;
  for (const toml::node& item : *node->as_array()) {
    if (!item.is_string())
      throw ConfigError(fmt::format("{}: \"{}\" must be an array of strings (this entry is {})",
                                    node_->entry_place(item, key), key, name(item.type())));
    values.push_back(*item.value<std::string>());
  }
  return values;
}

std::optional<std::vector<std::vector<double>>> Table::number_rows(std::string_view key) {
  toml::node* node = node_->ask(key);
  if (node == nullptr) return std::nullopt;
  std::vector<std::vector<double>> rows;
  GUSTLAB_EXPECT(node, node->is_array(), key, "an array of arrays of numbers");
  for (const toml::node& item : *node->as_array()) {
    GUSTLAB_EXPECT(&item, item.is_array(), key, "an array of arrays of numbers");
    rows.emplace_back();
    for (const toml::node& cell : *item.as_array()) {
      GUSTLAB_EXPECT(&cell, cell.is_number(), key, "an array of arrays of numbers");
      rows.back().push_back(finite(*this, cell, key));
    }
  }
  return rows;
}

std::optional<Table> Table::table(std::string_view key) {
  toml::node* node = node_->ask(key);
  if (node == nullptr) return std::nullopt;
  GUSTLAB_EXPECT(node, node->is_table(), key, "a table");
  std::shared_ptr<Node>& child = node_->children[std::string(key)];
  if (!child) child = std::make_shared<Node>(Node{node_->document, node->as_table(), node_->path, {}, {}, {}});
  Table result;
  result.node_ = child;
  return result;
}

std::vector<Table> Table::tables(std::string_view key) {
  toml::node* node = node_->ask(key);
  if (node == nullptr) return {};
  GUSTLAB_EXPECT(node, node->is_array_of_tables() || (node->is_array() && node->as_array()->empty()), key,
                 fmt::format("tables, each under [[{}]]", key));
  std::vector<Table> result;
  for (toml::node& item : *node->as_array()) {
    std::shared_ptr<Node>& child = node_->children[fmt::format("{}[{}]", key, result.size())];
    if (!child) child = std::make_shared<Node>(Node{node_->document, item.as_table(), node_->path, {}, {}, {}});
    result.emplace_back().node_ = child;
  }
  return result;
}

std::optional<std::vector<std::string>> Table::literals(std::string_view key) {
  toml::node* node = node_->ask(key);
  if (node == nullptr) return std::nullopt;
  GUSTLAB_EXPECT(node, node->is_array(), key, "an array");
  std::vector<std::string> values;
  for (const toml::node& item : *node->as_array()) values.push_back(literal_text(item));
  return values;
}

#undef GUSTLAB_EXPECT

std::optional<std::string> Table::literal(std::string_view key) {
  const toml::node* node = node_->ask(key);
  if (node == nullptr) return std::nullopt;
  return literal_text(*node);
}

std::vector<std::string> override_keys(const std::string& override_text) {
  std::vector<std::string> keys;
  add_leaves(parse_override(override_text), "", keys);
  return keys;
}

double Table::need_number(std::string_view key) {
  const auto value = number(key);
  if (!value) fail({}, fmt::format("\"{}\" is missing", key), "a number is needed here", "");
  return *value;
}

std::string Table::need_text(std::string_view key) {
  const auto value = text(key);
  if (!value) fail({}, fmt::format("\"{}\" is missing", key), "a string is needed here", "");
  return *value;
}

void Table::finish() const {
  for (const std::string& key : keys()) {
    if (node_->asked.contains(key)) continue;
    const auto entry = node_->table->find(key);
    const bool overridden = entry->second.source().path && entry->second.source().path->starts_with(command_line);
    const std::vector<std::string> known(node_->asked.begin(), node_->asked.end());
    const bool elsewhere = overridden || !node_->places.empty();
    std::string message =
        fmt::format("{}: unknown key \"{}\"", elsewhere ? where(key) : place(entry->first.source(), node_->path), key);
    if (known.empty()) message += " (none is known here)";
    else if (const std::string near = suggest(key, known); !near.empty()) message += " " + near;
    else message += fmt::format(" (known: {})", fmt::join(known, ", "));
    throw ConfigError(message);
  }
  for (const auto& [key, child] : node_->children) {
    Table table;
    table.node_ = child;
    table.finish();
  }
}

}  // namespace gustlab::config
