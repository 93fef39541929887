// Declared parameters to and from text.
#include <fmt/format.h>

#include <cmath>
#include <filesystem>

#include "config/hash.hpp"
#include "config/resources.hpp"
#include "config/text.hpp"
#include "config/toml.hpp"
#include "gustlab/errors.hpp"
#include "util/files.hpp"

namespace gustlab::config {

namespace {

std::string range_text(const ParameterInfo& info) {
  const bool low = std::isfinite(info.min), high = std::isfinite(info.max);
  if (low && high) return fmt::format("from {} to {}", shortest(info.min), shortest(info.max));
  if (low) return fmt::format("at least {}", shortest(info.min));
  if (high) return fmt::format("at most {}", shortest(info.max));
  return "";
}

std::string with_unit(const std::string& value, const ParameterInfo& info) {
  return info.unit == "-" ? value : fmt::format("{} {}", value, info.unit);
}

class Reader final : public ParameterVisitor {
 public:
  explicit Reader(Table& table) : table_(table) {}

  void number(std::string_view name, double& value, const ParameterInfo& info) override {
    if (const auto read = table_.number(name)) check(name, value = *read, info);
  }
  void integer(std::string_view name, std::int64_t& value, const ParameterInfo& info) override {
    if (const auto read = table_.integer(name)) check(name, static_cast<double>(value = *read), info);
  }
  void flag(std::string_view name, bool& value, const ParameterInfo&) override {
    value = table_.flag(name).value_or(value);
  }
  void text(std::string_view name, std::string& value, const ParameterInfo&) override {
    value = table_.text(name).value_or(value);
  }
  void numbers(std::string_view name, std::vector<double>& value, const ParameterInfo& info) override {
    if (const auto read = table_.numbers(name)) value = *read;
    for (const double item : value) check(name, item, info);
  }
  void texts(std::string_view name, std::vector<std::string>& value, const ParameterInfo&) override {
    value = table_.texts(name).value_or(value);
  }
  void vector(std::string_view name, Vector3& value, const ParameterInfo& info) override {
    const auto read = table_.numbers(name);
    if (!read) return;
    if (read->size() != 3)
      table_.fail(name, fmt::format("\"{}\" must have three numbers", name), fmt::format("this has {}", read->size()),
                  "write [x, y, z]");
    value = Vector3(read->data());
    for (const double item : *read) check(name, item, info);
  }
  // relative to the file that names it (an override: to the one that it changes), or one that is shipped
  void file(std::string_view name, InputFile& value, const ParameterInfo&) override {
    const auto read = table_.text(name);
    if (read) value.path = *read;
    if (value.path.empty()) return;
    std::error_code error;
    std::filesystem::path found;
    for (const std::filesystem::path namer : {table_.path(), table_.where(name)})
      if (const auto beside = namer.parent_path() / value.path; std::filesystem::is_regular_file(beside, error))
        found = beside;
    if (read && !found.empty()) {
      value.path = found.string();
    } else {
      try {
        value.path = find_resource(value.path);
      } catch (const ConfigError&) {
        table_.fail(name, fmt::format("\"{}\" is not there", value.path),
                    "a path is relative to this file, or to the folder of gustlab", "");
      }
    }
    if (const std::string why = read_into(value.path, value.bytes); !why.empty())
      table_.fail(name, fmt::format("\"{}\" cannot be read", value.path), why, "");
    // no bytes mean that no file is named
    if (value.bytes.empty())
      throw DataError(fmt::format("{}:1:1: the file is empty ({} names it as \"{}\"); name another", value.path,
                                  table_.where(name), name));
  }

 private:
  void check(std::string_view name, double value, const ParameterInfo& info) {
    if (value >= info.min && value <= info.max) return;
    table_.fail(name, fmt::format("\"{}\" is out of range", name),
                fmt::format("{} is not {}", with_unit(shortest(value), info), range_text(info)), "");
  }

  Table& table_;
};

class Printer final : public ParameterVisitor {
 public:
  explicit Printer(bool commented) : commented_(commented) {}

  void number(std::string_view name, double& value, const ParameterInfo& info) override {
    line(name, shortest(value), info);
  }
  void integer(std::string_view name, std::int64_t& value, const ParameterInfo& info) override {
    line(name, fmt::format("{}", value), info);
  }
  void flag(std::string_view name, bool& value, const ParameterInfo& info) override {
    line(name, value ? "true" : "false", info);
  }
  void text(std::string_view name, std::string& value, const ParameterInfo& info) override {
    line(name, config::quoted(value), info);
  }
  void numbers(std::string_view name, std::vector<double>& value, const ParameterInfo& info) override {
    list(name, value.data(), value.size(), info);
  }
  void texts(std::string_view name, std::vector<std::string>& value, const ParameterInfo& info) override {
    std::string items;
    for (const std::string& item : value) items += (items.empty() ? "" : ", ") + config::quoted(item);
    line(name, "[" + items + "]", info);
  }
  void vector(std::string_view name, Vector3& value, const ParameterInfo& info) override {
    list(name, value.data(), 3, info);
  }
  // in a key the bytes stand for the file, wherever it is
  void file(std::string_view name, InputFile& value, const ParameterInfo& info) override {
    const auto words = Hash().add(value.bytes).words();
    const std::string digest = value.bytes.empty() ? "" : fmt::format("{:016x}{:016x}", words[0], words[1]);
    line(name, config::quoted(commented_ ? value.path : digest), info);
  }

  std::string result;

 private:
  void list(std::string_view name, const double* values, std::size_t size, const ParameterInfo& info) {
    std::string items;
    for (std::size_t i = 0; i < size; ++i) items += (i > 0 ? ", " : "") + shortest(values[i]);
    line(name, "[" + items + "]", info);
  }
  void line(std::string_view name, const std::string& value, const ParameterInfo& info) {
    result += fmt::format("{} = {}", name, value);
    if (commented_) {
      const std::string range = range_text(info);
      const char* separator = info.help.empty() || range.empty() ? "" : "; ";
      result += fmt::format("  # [{}] {}{}{}", info.unit, info.help, separator, range);
    }
    result += '\n';
  }

  bool commented_;
};

std::string print(Parameterized& target, bool commented) {
  Printer printer(commented);
  target.visit(printer);
  return printer.result;
}

}  // namespace

void read_parameters(Table& table, Parameterized& target) {
  Reader reader(table);
  target.visit(reader);
  table.finish();
}

std::string canonical_text(Parameterized& target) { return print(target, false); }
std::string commented_text(Parameterized& target) { return print(target, true); }

}  // namespace gustlab::config
