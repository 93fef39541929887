// JSON that others may have written: each value knows where it stands, so that messages can say it.
#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace gustlab {

// What is wrong with a text, and where. Whoever reads the file puts its name before it.
struct JsonFault : std::runtime_error {
  JsonFault(std::size_t at, const std::string& why, std::string what_to_do = "")
      : std::runtime_error(why), offset(at), suggestion(std::move(what_to_do)) {}
  std::size_t offset;      // bytes before it
  std::string suggestion;  // may be empty
};

// Throws JsonFault for what is no JSON, or is nested deeper than a hundred values.
nlohmann::ordered_json parse_json(const std::string& text);

// line:col, the text's first line being `first_line`.
std::string json_place(const std::string& text, std::size_t offset, std::size_t first_line = 1);

// A value of a parsed text, which must outlive it. All throw JsonFault at the value that is not as asked.
class JsonPart {
 public:
  JsonPart(const std::string& text, const nlohmann::ordered_json& whole) : text_(&text), value_(&whole) {}

  // of an object
  JsonPart need(const std::string& key) const;
  std::optional<JsonPart> find(const std::string& key) const;
  std::vector<JsonPart> members() const;
  // of an array; of what is not there, nothing
  std::vector<JsonPart> items() const;
  std::vector<JsonPart> items(const std::string& key) const;
  std::vector<std::string> texts(const std::string& key) const;

  std::string text() const;
  std::string text(const std::string& key, const std::string& otherwise) const;
  double number() const;
  double number(const std::string& key, double otherwise) const;
  bool flag(const std::string& key, bool otherwise) const;
  bool is_object() const { return value_->is_object(); }
  // as it is; an empty object when it is not there
  nlohmann::ordered_json copy(const std::string& key) const;

  std::size_t offset() const;
  [[noreturn]] void fail(const std::string& why, const std::string& suggestion = "") const;

 private:
  JsonPart below(const std::string& step, const nlohmann::ordered_json& value) const;

  const std::string* text_;
  const nlohmann::ordered_json* value_;
  std::vector<std::string> way_{};  // keys and indices from the whole to it
};

}  // namespace gustlab
