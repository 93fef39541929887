// SQLite with exceptions and ownership, as much of it as a result store needs.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

struct sqlite3;
struct sqlite3_stmt;

namespace gustlab {

class Statement;

// Every call throws with the file's path when SQLite says no: DataError when the file is something else, else IoError.
class Database {
 public:
  enum class Mode { read, write, create };
  Database(const std::string& path, Mode mode);

  void run(const std::string& sql);
  Statement prepare(std::string_view sql);
  const std::string& path() const { return path_; }
  [[noreturn]] void fail() const;

 private:
  struct Close {
    void operator()(sqlite3* database) const;
  };
  std::string path_;
  std::unique_ptr<sqlite3, Close> handle_;
};

// Columns and parameters count from 0. A number that is NaN is NULL in the file.
class Statement {
 public:
  Statement& bind(int parameter, std::int64_t value);
  Statement& bind(int parameter, double value);
  Statement& bind(int parameter, std::string_view value);
  // Next row; false after the last, and then ready to be bound again.
  bool step();
  std::int64_t integer(int column) const;
  double number(int column) const;
  bool is_number(int column) const;  // or NULL; to be asked before the value
  std::string name(int column) const;
  std::string text(int column) const;

 private:
  friend class Database;
  struct Finalize {
    void operator()(sqlite3_stmt* statement) const;
  };
  Statement(Database& database, sqlite3_stmt* handle) : database_(&database), handle_(handle) {}
  void check(int code) const;

  Database* database_;
  std::unique_ptr<sqlite3_stmt, Finalize> handle_;
};

}  // namespace gustlab
