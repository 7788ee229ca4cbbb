#include "formats/os/atomic_file.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include "formats/os/files.h"
#include "tests/support/test_data.h"
#include "tests/tools/harness.h"

namespace sbrdf::internal {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr mode_t kPermissions = 07777;

mode_t mode_of(const std::string& path) {
  struct stat status {};
  return stat(path.c_str(), &status) == 0 ? status.st_mode & kPermissions : 0;
}

bool takes_nameless_files(const ScratchFolder& folder) {
  const int number = open(folder.path().c_str(), O_TMPFILE | O_WRONLY, 0600);
  if (number >= 0) close(number);
  return number >= 0;
}

/// Both ways of writing do the same for whoever looks at the folder afterwards.
class AtomicFileTest : public testing::TestWithParam<WhileWritten> {
 protected:
  AtomicFileTest() {
    if (GetParam() == WhileWritten::kNameless && !takes_nameless_files(folder_)) {
      skipped_ = "the file system of " + folder_.path().string() + " has no files without a name (O_TMPFILE)";
    }
  }
  void SetUp() override {
    if (!skipped_.empty()) GTEST_SKIP() << skipped_;
  }
  [[nodiscard]] static Result<std::unique_ptr<AtomicFile>> create(const std::string& path) {
    return AtomicFile::create(path, GetParam());
  }
  [[nodiscard]] static Status write_whole(const std::string& path, std::string_view text) {
    const auto file = create(path);
    if (!file) return file.error();
    if (Status written = (*file)->write(0, bytes_of(text)); !written) return written.error();
    return (*file)->commit();
  }
  static void expect_refused(const std::string& path, const std::string& fragment) {
    const auto file = create(path);
    ASSERT_FALSE(file.ok()) << path;
    EXPECT_EQ(file.error().code, ErrorCode::kIo);
    EXPECT_THAT(file.error().message, HasSubstr(fragment));
    const Status asked = check_destination(path);
    ASSERT_FALSE(asked.ok());
    EXPECT_EQ(asked.error().message, file.error().message);
  }

  const ScratchFolder folder_;
  const std::string path_ = folder_ / "out";
  std::string skipped_;
};

TEST_P(AtomicFileTest, IsThereOnceItIsCommitted) {
  {
    const auto file = create(path_);
    ASSERT_TRUE(file.ok()) << file.error().message;
    ASSERT_TRUE((*file)->write(0, bytes_of("new")).ok());
    EXPECT_FALSE(std::filesystem::exists(path_));
    ASSERT_TRUE((*file)->commit().ok());
    EXPECT_EQ(read_text(path_), "new");
  }
  EXPECT_EQ(read_text(path_), "new");
  EXPECT_THAT(folder_.entries(), ElementsAre("out"));
}

TEST_P(AtomicFileTest, LeavesNothingWithoutACommit) {
  write_bytes(folder_ / "old", bytes_of("old"));
  for (const std::string& path : {path_, folder_ / "old"}) {
    const auto file = create(path);
    ASSERT_TRUE(file.ok());
    ASSERT_TRUE((*file)->write(0, bytes_of("new")).ok());
  }
  EXPECT_THAT(folder_.entries(), ElementsAre("old"));
  EXPECT_EQ(read_text(folder_ / "old"), "old");
}

TEST_P(AtomicFileTest, PutsEveryRangeWhereItBelongsFromManyThreads) {
  const auto file = create(path_);
  ASSERT_TRUE(file.ok());
  constexpr std::size_t kRanges = 64;
  constexpr std::size_t kSize = 10'000;
  std::vector<std::thread> threads;
  for (std::size_t first = 0; first < 4; ++first) {
    threads.emplace_back([&, first] {
      for (std::size_t k = kRanges - 1 - first; k < kRanges; k -= 4) {
        const std::string text(kSize, static_cast<char>('0' + k));
        EXPECT_TRUE((*file)->write((k + 1) * kSize, bytes_of(text)).ok());
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  ASSERT_TRUE((*file)->commit().ok());
  std::string expected(kSize, '\0');  // nobody wrote there
  for (std::size_t k = 0; k < kRanges; ++k) expected.append(kSize, static_cast<char>('0' + k));
  EXPECT_TRUE(read_text(path_) == expected);
}

TEST_P(AtomicFileTest, TakesPermissionsFromTheMaskOrFromTheFileItReplaces) {
  const mode_t before = umask(027);
  ASSERT_TRUE(write_whole(path_, "new").ok());
  EXPECT_EQ(mode_of(path_), 0640);
  for (const mode_t mode : {0600U, 0664U, 0755U}) {
    ASSERT_EQ(chmod(path_.c_str(), mode), 0);
    ASSERT_TRUE(write_whole(path_, "newer").ok());
    EXPECT_EQ(mode_of(path_), mode);
  }
  umask(before);
  EXPECT_EQ(read_text(path_), "newer");
  EXPECT_THAT(folder_.entries(), ElementsAre("out"));
}

TEST_P(AtomicFileTest, FollowsLinksToFilesThatAreThereAndToThoseThatAreNot) {
  std::filesystem::create_directory(folder_ / "deep");
  write_bytes(folder_ / "deep/there", bytes_of("old"));
  for (const std::string name : {"there", "missing"}) {
    std::filesystem::create_symlink("deep/" + name, folder_ / ("to_" + name));
    std::filesystem::create_symlink("to_" + name, folder_ / ("again_to_" + name));
    ASSERT_TRUE(write_whole(folder_ / ("again_to_" + name), "new").ok());
    EXPECT_TRUE(std::filesystem::is_symlink(folder_ / ("to_" + name)));
    EXPECT_EQ(read_text(folder_ / ("deep/" + name)), "new");
  }
  std::filesystem::create_symlink("nowhere/file", folder_ / "astray");
  expect_refused(folder_ / "astray", "nowhere cannot be used: No such file or directory");
  std::filesystem::create_symlink("circle", folder_ / "circle");
  expect_refused(folder_ / "circle", "Too many levels of symbolic links");
}

TEST_P(AtomicFileTest, RefusesWhatIsNoFileAndFoldersThatTakeNone) {
  expect_refused(folder_.path(), "is a directory");
  expect_refused(folder_ / "missing/out", "missing cannot be used: No such file or directory");
  write_bytes(folder_ / "file", {});
  expect_refused(folder_ / "file/out", "is not a folder");
  expect_refused(folder_ / std::string(300, 'x'), "File name too long");
  std::string deep = folder_.path();
  while (deep.size() < 5000) deep += "/aaaaaaaaaaaaaaaaaaaa";
  expect_refused(deep, "File name too long");
  if (geteuid() == 0) return;  // may do anything
  std::filesystem::create_directory(folder_ / "closed");
  std::filesystem::permissions(folder_ / "closed", std::filesystem::perms(0555));
  expect_refused(folder_ / "closed/out", "closed: Permission denied");
}

/// Writes until it fails or is killed, and tells through `told` once it has got some way.
bool write_for_ever(const std::string& path, WhileWritten kind, int told) {
  const auto file = AtomicFile::create(path, kind);
  const std::vector<std::byte> bytes(1 << 16);
  for (std::uint64_t k = 0; file.ok(); ++k) {
    // In a ring, so that no disk fills up.
    if (!(*file)->write(k % 64 * bytes.size(), bytes)) return true;
    if (k == 100 && write(told, "x", 1) != 1) break;
  }
  return false;
}

// In a process of its own, which is sent the signal, if it is not 0, in the middle.
int end_of_writer(const std::string& path, WhileWritten kind, int signal, std::uint64_t limit) {
  std::array<int, 2> ends{};
  if (pipe(ends.data()) != 0) return -1;
  const pid_t pid = fork();
  if (pid == 0) {
    std::signal(SIGXFSZ, SIG_IGN);
    const rlimit size = {limit, limit};
    if (setrlimit(RLIMIT_FSIZE, &size) != 0) _exit(9);
    _exit(write_for_ever(path, kind, ends[1]) ? 7 : 8);
  }
  close(ends[1]);
  char told = 0;
  const bool wrote = read(ends[0], &told, 1) == 1;
  if (wrote && signal != 0) kill(pid, signal);
  close(ends[0]);
  int status = 0;
  waitpid(pid, &status, 0);
  return WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status);
}

TEST_P(AtomicFileTest, LeavesTheOldFileWhenThereIsNoRoom) {
  write_bytes(path_, bytes_of("old"));
  EXPECT_EQ(end_of_writer(path_, GetParam(), 0, 1 << 20), 7);
  EXPECT_EQ(read_text(path_), "old");
  EXPECT_THAT(folder_.entries(), ElementsAre("out"));
}

TEST_P(AtomicFileTest, LeavesTheOldFileWhenKilled) {
  write_bytes(path_, bytes_of("old"));
  EXPECT_EQ(end_of_writer(path_, GetParam(), SIGKILL, RLIM_INFINITY), 128 + SIGKILL);
  EXPECT_EQ(read_text(path_), "old");
  if (GetParam() == WhileWritten::kNameless) {
    EXPECT_THAT(folder_.entries(), ElementsAre("out"));
  } else {
    EXPECT_EQ(folder_.entries().size(), 2);  // what the other way is for
  }
}

INSTANTIATE_TEST_SUITE_P(Tools, AtomicFileTest, testing::Values(WhileWritten::kNameless, WhileWritten::kNamed),
                         [](const auto& tested) {
                           return tested.param == WhileWritten::kNameless ? "Nameless" : "Named";
                         });

TEST(CheckDestination, LeavesNothingBehind) {
  const ScratchFolder folder;
  EXPECT_TRUE(check_destination(folder / "out").ok());
  EXPECT_THAT(folder.entries(), IsEmpty());
}

}  // namespace
}  // namespace sbrdf::internal
