#include "haptics/array/ArrayFileWatch.h"

#include <filesystem>
#include <fstream>
#include <string>

#include <gtest/gtest.h>
#include <unistd.h>

using midair::haptics::ArrayFileWatch;

namespace
{

/// A file that is gone at the end.
class WatchedFile
{
public:
    WatchedFile() :
        path(testing::TempDir() + "midair-watch-" + std::to_string(::getpid()) + ".json")
    {
        std::filesystem::remove(path);
    }
    ~WatchedFile() { std::filesystem::remove(path); }

    void write(const std::string& text) const { std::ofstream(path) << text; }

    const std::string path;
};

// Each look in these tests is that much after the one before; no test waits for it.
constexpr double kStep_s = 2.0 * ArrayFileWatch::kLook_s;

} // namespace

TEST(ArrayFileWatch, TellsOfAChangeOnceTheFileRests)
{
    const WatchedFile file;
    file.write("one");
    ArrayFileWatch watch(file.path);
    double now_s = 100.0;
    EXPECT_FALSE(watch.isChanged(now_s));
    file.write("another");
    EXPECT_FALSE(watch.isChanged(now_s + 0.1 * ArrayFileWatch::kLook_s)) << "looked too soon";
    EXPECT_FALSE(watch.isChanged(now_s += kStep_s)) << "it may still be written";
    file.write("a third, longer");
    EXPECT_FALSE(watch.isChanged(now_s += kStep_s)) << "it is still written";
    EXPECT_TRUE(watch.isChanged(now_s += kStep_s));
    EXPECT_TRUE(watch.isChanged(now_s += kStep_s)) << "until it is read again";
    EXPECT_FALSE(ArrayFileWatch(file.path).isChanged(now_s));
}

TEST(ArrayFileWatch, TellsOfAFileThatGoesAndOfOneThatComes)
{
    const WatchedFile file;
    ArrayFileWatch watch(file.path);
    double now_s = 100.0;
    EXPECT_FALSE(watch.isChanged(now_s));
    EXPECT_FALSE(watch.isChanged(now_s += kStep_s));
    file.write("there");
    EXPECT_FALSE(watch.isChanged(now_s += kStep_s));
    EXPECT_TRUE(watch.isChanged(now_s += kStep_s));
    ArrayFileWatch again(file.path);
    std::filesystem::remove(file.path);
    EXPECT_FALSE(again.isChanged(now_s += kStep_s));
    EXPECT_TRUE(again.isChanged(now_s += kStep_s));
}

TEST(ArrayFileWatch, WhatIsBuiltInNeverChanges)
{
    for (const char* name : {"octagon", "board", ""})
    {
        ArrayFileWatch watch(name);
        for (int look = 0; look < 4; ++look)
            EXPECT_FALSE(watch.isChanged(look * kStep_s)) << name;
    }
}
