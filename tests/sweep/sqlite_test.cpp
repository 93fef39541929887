// The wrapper of SQLite: what is bound comes back, and what goes wrong is said with the file's path.
#include "sweep/sqlite.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <fstream>
#include <limits>

#include "gustlab/errors.hpp"
#include "support/temporary_folder.hpp"

namespace gustlab {
namespace sqlite_test {

TEST(Sqlite, WhatIsBoundComesBack) {
  const TemporaryFolder folder;
  const std::string path = (folder.path() / "test.sqlite").string();
  {
    Database database(path, Database::Mode::create);
    database.run("CREATE TABLE t(i INTEGER, x REAL, s TEXT)");
    Statement insert = database.prepare("INSERT INTO t VALUES (?, ?, ?)");
    const std::int64_t large = std::numeric_limits<std::int64_t>::min();
    insert.bind(0, large).bind(1, 0.1).bind(2, std::string_view("it's 'quoted'"));
    EXPECT_FALSE(insert.step());
    insert.bind(0, std::int64_t{1}).bind(1, std::nan("")).bind(2, std::string_view(""));  // ready to be bound again
    EXPECT_FALSE(insert.step());
  }
  Database database(path, Database::Mode::read);
  Statement select = database.prepare("SELECT i, x, s, x IS NULL FROM t ORDER BY i");
  ASSERT_TRUE(select.step());
  EXPECT_EQ(select.integer(0), std::numeric_limits<std::int64_t>::min());
  EXPECT_EQ(select.number(1), 0.1);
  EXPECT_EQ(select.text(2), "it's 'quoted'");
  ASSERT_TRUE(select.step());
  EXPECT_EQ(select.integer(3), 1);
  EXPECT_FALSE(select.step());
  EXPECT_THROW(database.run("INSERT INTO t VALUES (1, 2, '3')"), IoError);  // opened to be read
}

TEST(Sqlite, ErrorsNameTheFile) {
  const TemporaryFolder folder;
  const std::string path = (folder.path() / "other.sqlite").string();
  EXPECT_THROW(Database(path, Database::Mode::read), IoError);
  std::ofstream(path) << std::string(4096, 'x');
  try {
    Database database(path, Database::Mode::read);
    database.run("SELECT * FROM t");
    FAIL() << "a text file is no database";
  } catch (const DataError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr(path));
  }
}

TEST(Sqlite, AStoreThatAnotherWritesIsTheUsersToFree) {
  const TemporaryFolder folder;
  const std::string path = (folder.path() / "busy.sqlite").string();
  Database writer(path, Database::Mode::create);
  writer.run("CREATE TABLE t(i INTEGER)");
  writer.run("BEGIN EXCLUSIVE");
  try {
    Database(path, Database::Mode::read).run("SELECT * FROM t");
    FAIL() << "the other one has locked it";
  } catch (const DataError& error) {
    EXPECT_EQ(error.what(),
              path + ": cannot use this result store (database is locked); close the program that has it open");
  }
}

}  // namespace sqlite_test
}  // namespace gustlab
