// samples/guides/START.md has a gallery of all scenes. Its commands are run by tests/documents.

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include <gtest/gtest.h>

TEST(Tutorial, NamesEachSceneOfTheGallery)
{
    std::ifstream in(MIDAIR_ROOT "/samples/guides/START.md");
    std::stringstream text;
    text << in.rdbuf();
    for (const auto& entry : std::filesystem::directory_iterator(MIDAIR_ROOT "/samples/scenes"))
    {
        if (!entry.is_regular_file()) continue;
        EXPECT_NE(text.str().find(entry.path().filename().string()), std::string::npos)
            << entry.path();
    }
}
