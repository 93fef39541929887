#include "report/json_part.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "config/text.hpp"

namespace gustlab {

namespace {

// destroying, copying and printing JSON goes as deep as the text does
constexpr int deepest_json = 100;

// The structure is read here, so that each value's place is known; what is no list is read by nlohmann::json.
class JsonReader {
 public:
  using Json = nlohmann::ordered_json;

  // `wanted`: the way to a value whose place is asked for
  explicit JsonReader(const std::string& text, const std::vector<std::string>* wanted = nullptr)
      : text_(text), wanted_(wanted), at_(text.starts_with("\xEF\xBB\xBF") ? 3 : 0) {}

  Json read() {
    Json value = read_value(0);
    if (peek() != '\0') fail("the JSON ended before this");
    return value;
  }
  std::size_t found() const { return found_; }

 private:
  [[noreturn]] void fail(const std::string& why) const { throw JsonFault(at_, why); }
  [[noreturn]] void fail_without(const char* expected) const {
    if (at_ == text_.size()) fail("the JSON is not complete");
    fail(fmt::format("expected {}", expected));
  }

  // the next letter that is not blank; at the end NUL, which is in no JSON
  char peek() {
    at_ = std::min(text_.find_first_not_of(" \t\r\n", at_), text_.size());
    return at_ < text_.size() ? std::max(text_[at_], '\1') : '\0';
  }
  bool take(char wanted_letter) {
    if (peek() != wanted_letter) return false;
    ++at_;
    return true;
  }

  Json read_value(int depth) {
    const char first = peek();
    if (wanted_ != nullptr && way_ == *wanted_) found_ = at_;
    if (first != '{' && first != '[') return read_scalar();
    if (depth > deepest_json) fail(fmt::format("nested deeper than {}", deepest_json));
    return first == '{' ? read_object(depth) : read_array(depth);
  }

  Json read_object(int depth) {
    Json object = Json::object();
    take('{');
    if (take('}')) return object;
    do {
      if (peek() != '"') fail_without("a key in quotation marks");
      const std::string key = read_scalar().get<std::string>();
      if (!take(':')) fail_without("a colon");
      way_.push_back(key);
      object[key] = read_value(depth + 1);
      way_.pop_back();
    } while (take(','));
    if (!take('}')) fail_without("a comma or }");
    return object;
  }

  Json read_array(int depth) {
    Json array = Json::array();
    take('[');
    if (take(']')) return array;
    do {
      way_.push_back(std::to_string(array.size()));
      array.push_back(read_value(depth + 1));
      way_.pop_back();
    } while (take(','));
    if (!take(']')) fail_without("a comma or ]");
    return array;
  }

  Json read_scalar() {
    std::size_t end = std::min(text_.find_first_of(" \t\r\n,:[]{}\"", at_), text_.size());
    if (peek() == '"') {
      for (end = at_ + 1; end < text_.size() && text_[end] != '"';) end += text_[end] == '\\' ? 2 : 1;
      if (end >= text_.size()) fail("a quotation mark is not closed");
      ++end;
    }
    if (end == at_) fail_without("a value");
    const std::string word = text_.substr(at_, end - at_);
    Json value = Json::parse(word, nullptr, false);
    if (value.is_discarded() || word.find('\0') != std::string::npos)  // there nlohmann::json would end
      fail(word.front() == '"' ? "a text with letters that JSON does not take"
                               : fmt::format("\"{}\" is no value of JSON", config::printable(word)));
    at_ = end;
    return value;
  }

  const std::string& text_;
  const std::vector<std::string>* wanted_;
  std::vector<std::string> way_;
  std::size_t at_, found_ = 0;
};

}  // namespace

nlohmann::ordered_json parse_json(const std::string& text) { return JsonReader(text).read(); }

std::string json_place(const std::string& text, std::size_t offset, std::size_t first_line) {
  const std::string_view before = std::string_view(text).substr(0, offset);
  const auto line = first_line + static_cast<std::size_t>(std::count(before.begin(), before.end(), '\n'));
  return fmt::format("{}:{}", line, before.size() - (before.rfind('\n') + 1) + 1);
}

JsonPart JsonPart::below(const std::string& step, const nlohmann::ordered_json& value) const {
  JsonPart part(*text_, value);
  part.way_ = way_;
  part.way_.push_back(step);
  return part;
}

std::optional<JsonPart> JsonPart::find(const std::string& key) const {
  if (!value_->is_object()) fail("expected an object");
  const auto found = value_->find(key);
  return found == value_->end() ? std::nullopt : std::optional(below(key, *found));
}

JsonPart JsonPart::need(const std::string& key) const {
  const std::optional<JsonPart> found = find(key);
  if (!found) fail(fmt::format("there is no \"{}\"", key));
  return *found;
}

std::vector<JsonPart> JsonPart::members() const {
  if (!value_->is_object()) fail("expected an object");
  std::vector<JsonPart> parts;
  for (const auto& [key, value] : value_->items()) parts.push_back(below(key, value));
  return parts;
}

std::vector<JsonPart> JsonPart::items() const {
  if (!value_->is_array()) fail("expected an array");
  std::vector<JsonPart> parts;
  for (std::size_t i = 0; i < value_->size(); ++i) parts.push_back(below(std::to_string(i), value_->at(i)));
  return parts;
}

std::vector<JsonPart> JsonPart::items(const std::string& key) const {
  const std::optional<JsonPart> found = find(key);
  return found ? found->items() : std::vector<JsonPart>{};
}

std::vector<std::string> JsonPart::texts(const std::string& key) const {
  std::vector<std::string> all;
  for (const JsonPart& item : items(key)) all.push_back(item.text());
  return all;
}

std::string JsonPart::text() const {
  if (!value_->is_string()) fail("expected a text");
  return value_->get<std::string>();
}

std::string JsonPart::text(const std::string& key, const std::string& otherwise) const {
  const std::optional<JsonPart> found = find(key);
  return found ? found->text() : otherwise;
}

double JsonPart::number() const {
  if (!value_->is_number()) fail("expected a number");
  return value_->get<double>();
}

double JsonPart::number(const std::string& key, double otherwise) const {
  const std::optional<JsonPart> found = find(key);
  return found ? found->number() : otherwise;
}

bool JsonPart::flag(const std::string& key, bool otherwise) const {
  const std::optional<JsonPart> found = find(key);
  if (found && !found->value_->is_boolean()) found->fail("expected true or false");
  return found ? found->value_->get<bool>() : otherwise;
}

nlohmann::ordered_json JsonPart::copy(const std::string& key) const {
  const std::optional<JsonPart> found = find(key);
  return found ? *found->value_ : nlohmann::ordered_json::object();
}

std::size_t JsonPart::offset() const {
  JsonReader reader(*text_, &way_);
  reader.read();
  return reader.found();
}

void JsonPart::fail(const std::string& why, const std::string& suggestion) const {
  throw JsonFault(offset(), why, suggestion);
}

}  // namespace gustlab
