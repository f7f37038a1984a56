// Part of each test program: a folder of its own for temporary files. ctest starts a program for
// each test and several at once; with one folder for all, two tests that give a file the same name
// would read each other's.

#include <cstdlib>
#include <filesystem>
#include <string>

#include <unistd.h>

namespace
{

struct OwnTemporaryFolder
{
    OwnTemporaryFolder()
    {
        std::error_code error;
        std::string path = std::filesystem::temp_directory_path(error) / "midair-test-XXXXXX";
        if (error || !::mkdtemp(path.data())) std::abort();
        folder = path;
        owner = ::getpid();
        ::setenv("TMPDIR", path.c_str(), 1);
        ::setenv("TEST_TMPDIR", path.c_str(), 1); // GoogleTest's TempDir()
    }
    ~OwnTemporaryFolder()
    {
        std::error_code ignored;
        if (::getpid() == owner) // not in a child that a test has forked
            std::filesystem::remove_all(folder, ignored);
    }

    std::filesystem::path folder;
    pid_t owner = 0;
};

const OwnTemporaryFolder kOwnTemporaryFolder;

} // namespace

#ifdef __SANITIZE_ADDRESS__
// What threads of a test program hold looks lost in a child that it forks, where they are not. The
// sanitizer asks by this name.
extern "C" int __lsan_is_turned_off(); // NOLINT(bugprone-reserved-identifier)
extern "C" int __lsan_is_turned_off()  // NOLINT(bugprone-reserved-identifier)
{
    return ::getpid() == kOwnTemporaryFolder.owner ? 0 : 1;
}
#endif
