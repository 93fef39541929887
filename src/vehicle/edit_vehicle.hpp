// A vehicle file with some of its numbers replaced; all else, comments included, stays as it was written.
#pragma once

#include <string>
#include <string_view>

namespace gustlab {

// Sets `key = literal  # source` in a table ("thrust"), which is added when it is not there. The key's old line and one that proposes
// it (`# key = …`) go, and so do the comment lines right above them, which told the old number's source.
void set_key(std::string& text, std::string_view table, std::string_view key, std::string_view literal,
             std::string_view source);
// Takes a key and its comment lines out of a table.
void drop_key(std::string& text, std::string_view table, std::string_view key);
// Takes out every [[effect]] of this type.
void drop_effect(std::string& text, std::string_view type);

}  // namespace gustlab
