// The README shows files of the project; they must be the files.

#include <fstream>
#include <sstream>
#include <string>

#include <gtest/gtest.h>

namespace
{

std::string content(const std::string& path)
{
    std::ifstream file(path);
    EXPECT_TRUE(file) << path;
    std::stringstream text;
    text << file.rdbuf();
    return text.str();
}

TEST(Readme, ShowsTheSamplesAsTheyAre)
{
    const std::string readme = content(MIDAIR_ROOT "/README.md");
    for (const std::string name : {"/samples/minimal.cpp", "/samples/scenes/star.osgt"})
        EXPECT_NE(readme.find("\n" + content(MIDAIR_ROOT + name) + "```"), std::string::npos)
            << name;
}

} // namespace
