#include "util/files.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>

#include "gustlab/errors.hpp"

namespace gustlab {

void write_file(const std::string& path, std::string_view bytes) {
  write_file(path, [&](std::ostream& file) { file.write(bytes.data(), static_cast<std::streamsize>(bytes.size())); });
}

void write_file(const std::string& path, const std::function<void(std::ostream&)>& write) {
  const std::string beside = path + ".part";
  const auto fail = [&] {
    const int reason = errno;
    std::remove(beside.c_str());
    throw IoError(fmt::format("{}: cannot write ({})", path, std::strerror(reason ? reason : EIO)));
  };
  errno = 0;
  std::ofstream file(beside, std::ios::binary | std::ios::trunc);
  write(file);
  file.close();
  if (!file || std::rename(beside.c_str(), path.c_str()) != 0) fail();
}

void make_folder(const std::string& path) {
  std::error_code error;
  std::filesystem::create_directories(path, error);
  if (error) throw IoError(fmt::format("{}: cannot make this folder ({})", path, error.message()));
}

void check_file_can_be_written(const std::string& path) {
  const std::string beside = path + ".part";
  errno = std::filesystem::is_directory(path) ? EISDIR : 0;
  if (errno == 0 && std::ofstream(beside, std::ios::app)) errno = 0;
  const int reason = errno;
  std::remove(beside.c_str());
  if (reason != 0) throw IoError(fmt::format("{}: cannot write ({})", path, std::strerror(reason)));
}

void check_folder_can_be_made(const std::string& path) {
  const bool is_there = std::filesystem::exists(path);
  make_folder(path);
  if (!is_there) std::filesystem::remove(path);
}

std::string why_unreadable(const std::string& path) {
  errno = 0;
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "rb"), std::fclose);
  // a folder opens, and cannot be read
  if (file && (std::fgetc(file.get()) != EOF || std::feof(file.get()))) return {};
  return std::strerror(errno ? errno : EIO);
}

}  // namespace gustlab
