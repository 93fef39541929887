// Sets a declared parameter by name, for tests that need no file.
#pragma once

#include <stdexcept>
#include <string>

#include "gustlab/parameters.hpp"

namespace gustlab::test {

// Does nothing for every kind; a test's visitor overrides the kind it is about.
class QuietVisitor : public ParameterVisitor {
 public:
  void number(std::string_view, double&, const ParameterInfo&) override {}
  void integer(std::string_view, std::int64_t&, const ParameterInfo&) override {}
  void flag(std::string_view, bool&, const ParameterInfo&) override {}
  void text(std::string_view, std::string&, const ParameterInfo&) override {}
  void numbers(std::string_view, std::vector<double>&, const ParameterInfo&) override {}
  void texts(std::string_view, std::vector<std::string>&, const ParameterInfo&) override {}
  void vector(std::string_view, Vector3&, const ParameterInfo&) override {}
};

template <class Value>
class Setter final : public QuietVisitor {
 public:
  Setter(std::string_view name, Value value) : name_(name), value_(std::move(value)) {}
  bool found = false;

  void number(std::string_view name, double& value, const ParameterInfo&) override { set(name, value); }
  void integer(std::string_view name, std::int64_t& value, const ParameterInfo&) override { set(name, value); }
  void flag(std::string_view name, bool& value, const ParameterInfo&) override { set(name, value); }
  void text(std::string_view name, std::string& value, const ParameterInfo&) override { set(name, value); }
  void numbers(std::string_view name, std::vector<double>& value, const ParameterInfo&) override { set(name, value); }
  void texts(std::string_view name, std::vector<std::string>& value, const ParameterInfo&) override {
    set(name, value);
  }
  void vector(std::string_view name, Vector3& value, const ParameterInfo&) override { set(name, value); }
  void file(std::string_view name, InputFile& value, const ParameterInfo&) override { set(name, value); }

 private:
  template <class Target>
  void set(std::string_view name, Target& target) {
    if constexpr (std::is_same_v<Target, Value>) {
      if (name != name_) return;
      target = value_;
      found = true;
    }
  }
  std::string name_;
  Value value_;
};

template <class Value>
void set(Parameterized& target, std::string_view name, Value value) {
  Setter<Value> setter(name, std::move(value));
  target.visit(setter);
  if (!setter.found) throw std::logic_error("no such parameter: " + std::string(name));
}
inline void set_number(Parameterized& target, std::string_view name, double value) { set(target, name, value); }
inline void set_text(Parameterized& target, std::string_view name, const std::string& value) {
  set(target, name, value);
}

}  // namespace gustlab::test
