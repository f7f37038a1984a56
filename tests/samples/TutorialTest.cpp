// The commands of plugin/TUTORIAL.md, run one after the other in a folder that looks like the tree.

#include "tests/samples/Shell.h"

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include <gtest/gtest.h>

namespace
{

namespace fs = std::filesystem;

const std::string kTutorial = MIDAIR_ROOT "/plugin/TUTORIAL.md";

bool begins(const std::string& text, const std::string& with)
{
    return text.compare(0, with.size(), with) == 0;
}

} // namespace

TEST(Tutorial, ItsCommandsDoWhatItSays)
{
    if (shell("which osgconv").code != 0) GTEST_SKIP() << "osgconv is not installed";
    const fs::path folder = fs::path(testing::TempDir()) / "midair-tutorial";
    fs::remove_all(folder);
    fs::create_directories(folder);
    fs::create_symlink(MIDAIR_ROOT "/samples", folder / "samples");
    fs::create_symlink(fs::path(MIDAIR_BIN).parent_path(), folder / "build");
    std::ifstream in(kTutorial);
    int run = 0;
    // The last block sets what the tree has.
    std::string settings;
    bool isBlock = false;
    for (std::string line; std::getline(in, line);)
    {
        if (begins(line, "```"))
        {
            isBlock = begins(line, "```sh");
            if (isBlock) settings.clear();
            continue;
        }
        if (isBlock) settings += line + "; ";
        if (!begins(line, "    ")) continue;
        const std::string command = line.substr(4);
        // What needs a display, or hardware, is left to people.
        if (command.find("osgviewer") != std::string::npos) continue;
        ++run;
        const bool isConversion = begins(command, "osgconv");
        const std::string preload =
            isConversion && *MIDAIR_SANITIZER_RUNTIME
                ? "ASAN_OPTIONS=detect_leaks=0 LD_PRELOAD=" MIDAIR_SANITIZER_RUNTIME " "
                : "";
        const Outcome outcome =
            shell("cd " + folder.string() + "; " + settings + preload + command);
        EXPECT_EQ(outcome.code, 0) << command << "\n" << outcome.output;
    }
    EXPECT_GE(run, 6);
    EXPECT_TRUE(fs::exists(folder / "mine.osgt"));
    fs::remove_all(folder);
}

TEST(Tutorial, NamesEachSceneOfTheGallery)
{
    std::ifstream in(kTutorial);
    std::stringstream text;
    text << in.rdbuf();
    for (const auto& entry : fs::directory_iterator(MIDAIR_ROOT "/samples/scenes"))
    {
        if (!entry.is_regular_file()) continue;
        EXPECT_NE(text.str().find(entry.path().filename().string()), std::string::npos)
            << entry.path();
    }
}
