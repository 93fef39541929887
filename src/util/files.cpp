#include "util/files.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <iostream>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <vector>

#include "gustlab/errors.hpp"

namespace gustlab {

namespace {

namespace fs = std::filesystem;

constexpr std::string_view standard_output = "-";
constexpr int most_links = 40;  // as Linux has it

// `path`, or the nearest folder above it that is there; empty: none of a relative path is
fs::path nearest_there(fs::path path) {
  std::error_code error;
  while (path.has_relative_path() && !fs::exists(fs::status(path, error))) path = path.parent_path();
  return path;
}

// the file that stands where a folder of `path` should be; empty: there is none
std::string file_on_the_way(const fs::path& path) {
  std::error_code error;
  const fs::path there = nearest_there(path);
  return fs::exists(there, error) && !fs::is_directory(there, error) ? there.string() : "";
}

// What is wrong with the path itself is the user's to change; the rest the disk refuses.
[[noreturn]] void fail(const std::string& path, std::string_view what, int reason) {
  const std::string file = reason == ENOTDIR ? file_on_the_way(path) : "";
  const std::string message = fmt::format(
      "{}: {} ({})", path, what,
      file.empty() ? std::strerror(reason ? reason : EIO) : fmt::format("{} is a file, not a folder", file));
  if (is_fault_of_path(reason)) throw ConfigError(message + "; name another");
  throw IoError(message);
}

constexpr std::string_view no_file = "cannot write", no_folder = "cannot make this folder";

[[noreturn]] void fail(const std::string& path, int reason) { fail(path, no_file, reason); }

// Where a path leads: symbolic links of every part of it are followed, also to what is not there yet.
fs::path led_to(fs::path path, const std::string& shown, std::string_view what) {
  std::error_code error;
  fs::path here;
  int links = 0;
  for (auto part = path.begin(); part != path.end();) {
    here /= *part++;
    if (!fs::is_symlink(fs::symlink_status(here, error))) continue;
    if (++links > most_links) fail(shown, what, ELOOP);
    fs::path left = fs::read_symlink(here);
    here = here.parent_path();
    for (; part != path.end(); ++part) left /= *part;
    path = std::move(left);
    part = path.begin();
  }
  return here;
}
fs::path folder_led_to(const std::string& path) {
  if (path == standard_output)
    throw ConfigError("-: is the standard output, not a folder; name a folder (./- is one of this name)");
  return led_to(fs::absolute(path), path, no_folder);
}

// a file is known by where it stands, whatever name it was read by
using FileId = std::pair<dev_t, ino_t>;
struct Inputs {
  std::mutex mutex;
  std::set<FileId> read;
  bool are_protected = false;
};
Inputs& inputs() {
  static Inputs all;
  return all;
}

bool is_input(const fs::path& path) {
  struct stat there {};
  const std::lock_guard lock(inputs().mutex);
  return inputs().are_protected && stat(path.c_str(), &there) == 0 &&
         inputs().read.contains({there.st_dev, there.st_ino});
}

// what stands beside a target until it takes its place is called .gustlab.PROCESS.NUMBER
constexpr const char* beside_name = ".gustlab.{}.{}";

// calls `make(path)` with new names in the folder until none stands there; it returns false with errno
template <class Make>
fs::path make_unique(const fs::path& folder, Make make) {
  static std::atomic<unsigned> count{0};
  for (;;) {
    const fs::path path = folder / fmt::format(beside_name, getpid(), count++);
    if (make(path.c_str())) return path;
    if (errno != EEXIST) return {};
  }
}

// an empty file beside the target, which goes away unless it takes the target's place
class FileBeside {
 public:
  FileBeside(const fs::path& target, const std::string& shown) : shown_(shown) {
    path_ = make_unique(target.has_parent_path() ? target.parent_path() : ".", [](const char* path) {
      const int file = open(path, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
      return file >= 0 && close(file) == 0;
    });
    if (path_.empty()) fail(shown_, errno);
  }
  ~FileBeside() {
    if (!path_.empty()) unlink(path_.c_str());
  }
  FileBeside(const FileBeside&) = delete;
  FileBeside& operator=(const FileBeside&) = delete;
  const fs::path& path() const { return path_; }

  void replace(const fs::path& target) {
    struct stat there {};
    if (stat(target.c_str(), &there) == 0 && chmod(path_.c_str(), there.st_mode & 07777) != 0) fail(shown_, errno);
    if (std::rename(path_.c_str(), target.c_str()) != 0) fail(shown_, errno);
    path_.clear();
  }

 private:
  fs::path path_;
  std::string shown_;
};

// "-", and whatever else leads there, as /dev/stdout
bool is_stdout(const std::string& path) {
  struct stat there {
  }, out{};
  return path == standard_output || (stat(path.c_str(), &there) == 0 && fstat(STDOUT_FILENO, &out) == 0 &&
                                     there.st_dev == out.st_dev && there.st_ino == out.st_ino);
}

// where writing ends
struct Target {
  fs::path path;
  bool written_through = false;
};
Target find_target(const std::string& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (fs::is_directory(status)) fail(path, EISDIR);
  // the link of an open pipe (/dev/fd/3) leads nowhere by its name
  const bool written_through = fs::exists(status) && !fs::is_regular_file(status);
  Target target{written_through ? fs::path(path) : led_to(path, path, no_file), written_through};
  if (is_input(target.path))
    throw ConfigError(fmt::format("{}: is an input of this command (it would be lost); name another file", path));
  if (fs::exists(status) && access(target.path.c_str(), W_OK) != 0) fail(path, errno);
  return target;
}

// what write_together holds back: files beside their targets, and the topmost of the folders that were made for them
struct Together {
  std::vector<fs::path> made;
  std::vector<std::pair<std::unique_ptr<FileBeside>, fs::path>> written;
  std::set<fs::path> targets;

  ~Together() {
    std::error_code ignored;
    for (const fs::path& folder : made) fs::remove_all(folder, ignored);
  }
};
thread_local std::optional<Together> together;

void write_stream(const std::string& path, std::ostream& stream, const std::function<void(std::ostream&)>& write) {
  errno = 0;
  write(stream);
  if (!stream.flush()) fail(path, errno);
}

}  // namespace

void write_file(const std::string& path, std::string_view bytes) {
  write_file(path, [&](std::ostream& file) { file.write(bytes.data(), static_cast<std::streamsize>(bytes.size())); });
}

void write_file(const std::string& path, const std::function<void(std::ostream&)>& write) {
  if (is_stdout(path)) return write_stream(path, std::cout, write);
  const Target target = find_target(path);
  const auto fill = [&](const fs::path& where) {
    errno = 0;
    std::ofstream file(where, std::ios::binary);
    if (!file) fail(path, errno);
    write_stream(path, file, write);
    file.close();
    if (!file) fail(path, errno);
  };
  if (target.written_through) return fill(target.path);
  auto beside = std::make_unique<FileBeside>(target.path, path);
  fill(beside->path());
  if (!together) return beside->replace(target.path);
  if (!together->targets.insert(fs::weakly_canonical(fs::absolute(target.path))).second)
    throw ConfigError(
        fmt::format("{}: would be written twice (one of the two would be lost); name another file", path));
  together->written.emplace_back(std::move(beside), target.path);
}

void make_folder(const std::string& path) {
  std::error_code error;
  const fs::path folder = folder_led_to(path);
  if (together && !fs::exists(folder, error)) {
    fs::path top = folder.lexically_normal();
    while (top.has_relative_path() && !fs::exists(top.parent_path(), error)) top = top.parent_path();
    together->made.push_back(top);
  }
  fs::create_directories(folder, error);
  if (error) fail(path, no_folder, error.value());
}

void write_together(const std::function<void()>& write) {
  if (together) return write();
  struct End {
    ~End() { together.reset(); }
  } const end;
  together.emplace();
  write();
  for (const auto& [beside, target] : together->written) beside->replace(target);
  together->made.clear();
}

ScratchFolder::ScratchFolder(const fs::path& parent) {
  path_ = make_unique(parent, [](const char* path) { return mkdir(path, 0777) == 0; });
  if (path_.empty())
    throw IoError(fmt::format("{}: cannot make a folder here ({})", parent.string(), std::strerror(errno)));
}

ScratchFolder::~ScratchFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

void replace_folder(const std::string& path, const std::function<void(const fs::path& fresh)>& fill) {
  // a link stays one, and a slash at the end means nothing
  fs::path target = fs::weakly_canonical(folder_led_to(path));
  if (!target.has_filename()) target = target.parent_path();
  make_folder(target.parent_path().string());
  const ScratchFolder scratch(target.parent_path());
  const fs::path fresh = scratch.path() / "fresh", old = scratch.path() / "old";
  make_folder(fresh.string());
  fill(fresh);
  if (renameat2(AT_FDCWD, fresh.c_str(), AT_FDCWD, target.c_str(), RENAME_EXCHANGE) == 0) return;
  // nothing there to exchange with, or a file system that exchanges nothing
  const bool moved = errno == EINVAL && std::rename(target.c_str(), old.c_str()) == 0;
  if (std::rename(fresh.c_str(), target.c_str()) == 0) return;
  const int reason = errno;
  if (moved) std::rename(old.c_str(), target.c_str());
  throw IoError(fmt::format("{}: cannot be replaced ({})", path, std::strerror(reason)));
}

void check_file_can_be_written(const std::string& path) {
  if (is_stdout(path)) return;
  const Target target = find_target(path);
  if (!target.written_through) FileBeside can_be_made(target.path, path);
}

void check_folder_can_be_made(const std::string& path) {
  std::error_code error;
  const fs::path there = nearest_there(folder_led_to(path));
  if (!fs::is_directory(there, error)) fail(path, no_folder, ENOTDIR);
  // only who tries knows: in /proc nobody can, whatever its permissions say
  const fs::path made = make_unique(there, [](const char* name) { return mkdir(name, 0777) == 0; });
  if (made.empty()) fail(path, no_folder, errno);
  fs::remove(made, error);
}

bool remove_if_left_beside(const std::string& path) {
  const std::string name = fs::path(path).filename().string();
  int process = 0;
  unsigned number = 0;
  if (std::sscanf(name.c_str(), ".gustlab.%d.%u", &process, &number) != 2 || process <= 0 ||
      name != fmt::format(beside_name, process, number))
    return false;
  std::error_code ignored;
  if (kill(process, 0) != 0 && errno == ESRCH) fs::remove_all(path, ignored);
  return true;
}

void check_files_can_be_written(const std::string& folder, std::initializer_list<const char*> names) {
  check_folder_can_be_made(folder);
  if (!fs::is_directory(folder)) return;
  for (const char* name : names) check_file_can_be_written((fs::path(folder) / name).string());
}

std::string read_into(const std::string& path, std::string& bytes, std::size_t most_bytes) {
  bytes.clear();
  return read_blocks(path, most_bytes, [&](std::string_view block) { bytes += block; });
}

std::string read_blocks(const std::string& path, std::size_t most_bytes,
                        const std::function<void(std::string_view)>& block) {
  errno = 0;
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "rbe"), std::fclose);
  if (!file) return std::strerror(errno ? errno : EIO);
  std::array<char, 65536> bytes;
  for (std::size_t got = 0, all = 0; (got = std::fread(bytes.data(), 1, bytes.size(), file.get())) > 0;) {
    if ((all += got) > most_bytes) return fmt::format("it is larger than {} MiB", most_bytes >> 20);
    block({bytes.data(), got});
  }
  if (std::ferror(file.get())) return std::strerror(errno ? errno : EIO);
  note_input(path);
  return {};
}

void protect_inputs() {
  const std::lock_guard lock(inputs().mutex);
  inputs().are_protected = true;
}

void note_input(const std::string& path) {
  struct stat there {};
  if (stat(path.c_str(), &there) != 0 || !S_ISREG(there.st_mode)) return;
  const std::lock_guard lock(inputs().mutex);
  inputs().read.insert({there.st_dev, there.st_ino});
}

bool is_fault_of_path(int reason) {
  return reason == ENOTDIR || reason == EISDIR || reason == ENOENT || reason == ENAMETOOLONG || reason == ELOOP;
}

void check_input_path(const std::string& path) {
  std::error_code error;
  if (!fs::exists(path, error) && error) throw DataError(fmt::format("{}: cannot read ({})", path, error.message()));
}

std::string why_unreadable(const std::string& path) {
  errno = 0;
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "rb"), std::fclose);
  // a folder opens, and cannot be read
  if (file && (std::fgetc(file.get()) != EOF || std::feof(file.get()))) return {};
  return std::strerror(errno ? errno : EIO);
}

}  // namespace gustlab
