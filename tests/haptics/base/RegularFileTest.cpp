#include "haptics/base/RegularFile.h"

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

using namespace midair::base;

namespace
{

struct Folder
{
    std::filesystem::path path;
    Folder()
    {
        std::string name = (std::filesystem::temp_directory_path() / "midair-XXXXXX").string();
        path = mkdtemp(name.data());
    }
    ~Folder() { std::filesystem::remove_all(path); }
    std::string operator/(const std::string& name) const { return (path / name).string(); }
};

std::string refusal(const std::string& path, std::size_t most = 100)
{
    try
    {
        readRegularFile(path, most);
    }
    catch (const FileError& error)
    {
        return error.what();
    }
    return "was read";
}

} // namespace

TEST(RegularFile, IsReadWhole)
{
    const Folder folder;
    std::ofstream(folder / "a") << std::string("x\0y\n", 4);
    EXPECT_EQ(readRegularFile(folder / "a", 4), std::string("x\0y\n", 4));
    std::filesystem::create_symlink("a", folder / "link");
    EXPECT_EQ(readRegularFile(folder / "link", 4).size(), 4u);
}

TEST(RegularFile, OneThatIsTooLongIsNotRead)
{
    const Folder folder;
    std::ofstream(folder / "a") << "12345";
    EXPECT_EQ(refusal(folder / "a", 4), "has 5 bytes, should have at most 4 bytes");
    // Sparse: nobody has the memory for it.
    std::filesystem::resize_file(folder / "a", std::uintmax_t(1) << 40);
    EXPECT_EQ(refusal(folder / "a", 1 << 20), "has 1099511627776 bytes, should have at most 1 MiB");
}

TEST(RegularFile, WhatIsNoneIsNotRead)
{
    const Folder folder;
    EXPECT_EQ(refusal("/dev/zero"), "is a device or a pipe, should be a regular file");
    EXPECT_EQ(refusal(folder.path.string()), "is a folder, should be a regular file");
    EXPECT_EQ(refusal(folder / "missing"), "can't be read: No such file or directory");
    ASSERT_EQ(mkfifo((folder / "pipe").c_str(), 0600), 0);
    EXPECT_EQ(refusal(folder / "pipe"), "is a device or a pipe, should be a regular file");
    std::filesystem::create_symlink("/dev/zero", folder / "link");
    EXPECT_EQ(refusal(folder / "link"), "is a device or a pipe, should be a regular file");
}
