// What readers of files take at most: regular files of a limited size that ask for a limited
// memory.

#include "haptics/array/TransducerArray.h"
#include "haptics/base/InputError.h"
#include "haptics/surface/ObjReader.h"
#include "haptics/surface/TriangleMesh.h"

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

using namespace midair::haptics;

namespace
{

std::string errorOf(const std::function<void()>& read)
{
    try
    {
        read();
    }
    catch (const midair::base::InputError& error)
    {
        return error.what();
    }
    return {};
}

/// A folder that goes when the test ends.
class ReaderLimits : public testing::Test
{
protected:
    ReaderLimits() : _folder(testing::TempDir() + "midair-limits-" + std::to_string(::getpid()))
    {
        std::filesystem::create_directories(_folder);
    }
    ~ReaderLimits() override { std::filesystem::remove_all(_folder); }

    std::string path(const std::string& name) const { return _folder + "/" + name; }
    std::string written(const std::string& name, const std::string& text) const
    {
        std::ofstream(path(name)) << text;
        return path(name);
    }
    /// Its bytes take no room on the disk.
    std::string sized(const std::string& name, std::uintmax_t bytes) const
    {
        std::filesystem::resize_file(written(name, ""), bytes);
        return path(name);
    }
    std::string pipe(const std::string& name) const
    {
        EXPECT_EQ(::mkfifo(path(name).c_str(), 0600), 0);
        return path(name);
    }

private:
    std::string _folder;
};

const std::string kTriangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
const std::string kHead =
    R"({"frequency_Hz": 40000, "sourceAmplitude_Pa_m": 10, "directivity": "point")";

} // namespace

TEST_F(ReaderLimits, ModelsAreRegularFilesOf256MiBAtMost)
{
    const std::string big = sized("big.obj", (std::uintmax_t(256) << 20) + 1);
    EXPECT_EQ(errorOf([&] { readObj(big); }),
              big + ": has 268435457 bytes, should have at most 256 MiB");
    const std::string waits = pipe("pipe.obj");
    for (const std::string& name : {std::string("/dev/zero"), waits})
        EXPECT_EQ(errorOf([&] { readObj(name); }),
                  name + ": is a device or a pipe, should be a regular file");
}

TEST_F(ReaderLimits, ArraysAreRegularFilesOf32MiBAtMost)
{
    const std::string big = sized("big.json", (std::uintmax_t(32) << 20) + 1);
    EXPECT_EQ(errorOf([&] { TransducerArray::load(big); }),
              "array file '" + big + "' has 33554433 bytes, should have at most 32 MiB");
    const std::string waits = pipe("pipe.json");
    for (const std::string& name : {std::string("/dev/zero"), waits})
        EXPECT_EQ(errorOf([&] { TransducerArray::load(name); }),
                  "array file '" + name + "' is a device or a pipe, should be a regular file");
}

TEST_F(ReaderLimits, AModelsMaterialFileIsLookedForAndNeverOpened)
{
    pipe("pipe.mtl");
    for (const std::string name : {"pipe.mtl", "/dev/zero", "../../../../../../dev/zero"})
    {
        SCOPED_TRACE(name);
        const std::string obj = written("model.obj", "mtllib " + name + "\n" + kTriangle);
        std::vector<std::string> warnings;
        EXPECT_EQ(readObj(obj, &warnings).triangles.cols(), 1); // and doesn't wait
        ASSERT_EQ(warnings.size(), 1U);
        EXPECT_EQ(warnings[0],
                  obj + ", line 1: the material file \"" + name +
                      "\" is not there; materials are not needed");
    }
    written("real.mtl", "newmtl m\n");
    std::vector<std::string> warnings;
    readObj(written("model.obj", "mtllib real.mtl\n" + kTriangle), &warnings);
    EXPECT_TRUE(warnings.empty());
}

TEST_F(ReaderLimits, AFaceHasAtMost4096Corners)
{
    std::string text;
    std::string face = "f";
    for (int i = 0; i < 4097; ++i)
    {
        const double angle = 2.0 * 3.141592653589793 * i / 4097;
        char line[64];
        std::snprintf(line, sizeof line, "v %.6f %.6f 0\n", std::cos(angle), std::sin(angle));
        text += line;
        face += " " + std::to_string(i + 1);
    }
    const std::string obj = written("round.obj", text + face + "\n");
    EXPECT_EQ(errorOf([&] { readObj(obj); }),
              obj + ", line 4098: the face has 4097 corners; at most 4096 are possible");
    face.resize(face.rfind(' '));
    EXPECT_EQ(readObj(written("round.obj", text + face + "\n")).triangles.cols(), 4094);
}

TEST_F(ReaderLimits, ListsOfAnArrayHaveAtMost65536Entries)
{
    std::string places = "[0,0]";
    std::string levels = "0";
    for (int i = 0; i < 65536; ++i)
    {
        places += ",[0,0]";
        levels += ",1";
    }
    const std::string board = R"("boards": [{"position_m": [0,0,0], "normal": [0,0,1], )";
    EXPECT_EQ(errorOf(
                  [&] {
                      TransducerArray::fromJson(
                          kHead + "," + board + R"("places_m": [)" + places + "]}]}", "a");
                  }),
              "a: boards[0].places_m has 65537 entries; at most 65536 are possible");
    EXPECT_EQ(errorOf(
                  [&] {
                      TransducerArray::fromJson(kHead + R"(,"amplitudeLevels": [)" + levels + "]}",
                                                "a");
                  }),
              "a: amplitudeLevels has 65537 entries; at most 65536 are possible");
}
