// Whole files in and out; what is written is there whole or not at all.
#pragma once

#include <filesystem>
#include <functional>
#include <initializer_list>
#include <iosfwd>
#include <string>
#include <string_view>

namespace gustlab {

// Writes where `path` leads. A regular file is replaced at once, so that a reader never sees half of it; symbolic links are
// followed; a device, a FIFO and "-" (stdout) are written through. Throws with the path, and leaves nothing then:
// ConfigError where the path is wrong (a file where a folder should be, …), IoError where the disk refuses.
void write_file(const std::string& path, std::string_view bytes);
void write_file(const std::string& path, const std::function<void(std::ostream&)>& write);
// Makes a folder and its parents. Throws the same.
void make_folder(const std::string& path);
// The files and folders that `write` writes and makes by the two above are there when it ends, or none of them is.
void write_together(const std::function<void()>& write);
// Replaces a folder, which need not be there, by the one that `fill` writes into. Throws the same, and changes nothing then.
void replace_folder(const std::string& path, const std::function<void(const std::filesystem::path& fresh)>& fill);

// A folder of its own in `parent`, which goes away with all that is in it.
class ScratchFolder {
 public:
  explicit ScratchFolder(const std::filesystem::path& parent);
  ~ScratchFolder();
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

// Before long work: throw what write_file(path, …), or make_folder(path), would throw. They leave nothing.
void check_file_can_be_written(const std::string& path);
void check_folder_can_be_made(const std::string& path);
// The same of files in a folder that may not be there yet.
void check_files_can_be_written(const std::string& folder, std::initializer_list<const char*> names);
// Whether a path is named as what is written beside its target until it is whole. What a killed process left so is removed.
bool remove_if_left_beside(const std::string& path);

// The bytes of a file. Throws Error (ConfigError, DataError) with the path when it cannot be read, or is larger than
// `most_bytes`.
inline constexpr std::size_t most_text_bytes = std::size_t{64} << 20;
std::string read_into(const std::string& path, std::string& bytes,
                      std::size_t most_bytes = most_text_bytes);  // why not; empty: it is read
// The same, block after block.
std::string read_blocks(const std::string& path, std::size_t most_bytes,
                        const std::function<void(std::string_view)>& block);
template <class Error>
std::string read_file(const std::string& path, std::size_t most_bytes = most_text_bytes) {
  std::string bytes;
  if (const std::string why = read_into(path, bytes, most_bytes); !why.empty())
    throw Error(path + ": cannot read (" + why + ")");
  return bytes;
}
// From here on the program refuses to write over a file that it has read (ConfigError).
void protect_inputs();
// For readers that open a file themselves.
void note_input(const std::string& path);
// Whether an error is of the path itself (a name that is too long, links in a circle, a file where a folder should be, …): it is the
// user's to change.
bool is_fault_of_path(int reason);
// Before a folder is read that may not be there: throws DataError where nobody can tell, as its path is at fault.
void check_input_path(const std::string& path);
// Why a file cannot be read ("No such file or directory", "Is a directory", …); empty when it can.
std::string why_unreadable(const std::string& path);

}  // namespace gustlab
