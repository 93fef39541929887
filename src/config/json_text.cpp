#include "config/json_text.hpp"

#include <nlohmann/json.hpp>

#include "config/text.hpp"

namespace gustlab::config {

namespace {

using nlohmann::ordered_json;

ordered_json with_valid_text(const ordered_json& value) {
  if (value.is_string()) return valid_utf8(value.get_ref<const std::string&>());
  if (!value.is_structured()) return value;
  ordered_json out = value.is_array() ? ordered_json::array() : ordered_json::object();
  for (const auto& [key, part] : value.items())
    if (value.is_array()) out.push_back(with_valid_text(part));
    else out[valid_utf8(key)] = with_valid_text(part);
  return out;
}

}  // namespace

std::string json_text(const ordered_json& document, int indent) { return with_valid_text(document).dump(indent); }

}  // namespace gustlab::config
