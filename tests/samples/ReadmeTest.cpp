// The README shows files of the project; they must be the files.

#include <algorithm>
#include <filesystem>
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

TEST(Readme, ShowsTheSceneAsItIs)
{
    const std::string readme = content(MIDAIR_ROOT "/README.md");
    EXPECT_NE(readme.find("\n" + content(MIDAIR_ROOT "/samples/scenes/star.osgt") + "```"),
              std::string::npos);
}

TEST(Readme, IsShortAndBeginsWithAPicture)
{
    const std::string readme = content(MIDAIR_ROOT "/README.md");
    EXPECT_LE(std::count(readme.begin(), readme.end(), '\n'), 150);
    EXPECT_LT(readme.find("!["), 100U);
}

TEST(Readme, LeadsToEachDocument)
{
    const std::string readme = content(MIDAIR_ROOT "/README.md");
    for (const auto& entry : std::filesystem::recursive_directory_iterator(MIDAIR_ROOT))
    {
        const std::string path =
            std::filesystem::relative(entry.path(), MIDAIR_ROOT).generic_string();
        if (entry.path().extension() != ".md" || path == "README.md" ||
            path.rfind("build", 0) == 0 || path.rfind("tests/", 0) == 0)
            continue;
        EXPECT_NE(readme.find("(" + path), std::string::npos) << path;
    }
}

} // namespace
