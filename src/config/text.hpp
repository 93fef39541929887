// Text for people and for files: the nearest name, quoting.
#pragma once

#include <string>
#include <string_view>

namespace gustlab::config {

// ASCII letters in lower case.
std::string lower(std::string_view text);

// A TOML basic string, quotes included.
std::string quoted(std::string_view text);
// Text of others for a file: a byte that is no UTF-8 as \xNN.
std::string valid_utf8(std::string_view text);
// Text of others for a terminal: control characters as \xNN, so that none of them is obeyed; of a word that is longer than any path its beginning.
std::string printable(std::string_view text);

}  // namespace gustlab::config
