// Whole files in and out; what is written is there whole or not at all.
#pragma once

#include <functional>
#include <iosfwd>
#include <string>
#include <string_view>

namespace gustlab {

// Writes beside the path and renames, so that a reader never sees half a file. Throws IoError with the path.
void write_file(const std::string& path, std::string_view bytes);
void write_file(const std::string& path, const std::function<void(std::ostream&)>& write);
// Makes a folder and its parents. Throws IoError with the path.
void make_folder(const std::string& path);

// Before long work: throw the IoError that write_file(path, …), or make_folder(path), would throw. They leave nothing.
void check_file_can_be_written(const std::string& path);
void check_folder_can_be_made(const std::string& path);
// Why a file cannot be read ("No such file or directory", "Is a directory", …); empty when it can.
std::string why_unreadable(const std::string& path);

}  // namespace gustlab
