// JSON as text, whatever the names in it are made of.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace gustlab::config {

// The document as UTF-8, which is all that JSON may be: of keys and texts, such as names of files, a byte that is no UTF-8 is written
// as a message has it, \xNN.
std::string json_text(const nlohmann::ordered_json& document, int indent = -1);

}  // namespace gustlab::config
