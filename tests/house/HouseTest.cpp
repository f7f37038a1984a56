// The house's own rules, read from its files: which way includes point, how large folders and files
// are.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace
{

namespace fs = std::filesystem;

const fs::path kRoot = MIDAIR_ROOT;
const std::set<std::string> kTops = {
    "plugin", "engine-bridge", "haptics", "device", "samples", "tests"};

std::string textOf(const fs::path& file)
{
    std::ifstream in(file, std::ios::binary);
    std::ostringstream text;
    text << in.rdbuf();
    return text.str();
}

bool isSource(const fs::path& file)
{
    return file.extension() == ".h" || file.extension() == ".cpp" ||
           file.parent_path().filename() == "osgMidair";
}

/// All regular files below the six folders, relative to the root.
std::vector<fs::path> allFiles()
{
    std::vector<fs::path> files;
    for (const std::string& top : kTops)
        for (const auto& entry : fs::recursive_directory_iterator(kRoot / top))
            if (entry.is_regular_file() && entry.path().extension() != ".pyc")
                files.push_back(fs::relative(entry.path(), kRoot));
    std::sort(files.begin(), files.end());
    return files;
}

/// A folder's storeys from the ground up, as its CMakeLists.txt lists them; each line needs its
/// sentence.
std::vector<std::string> storeysOf(const fs::path& folder)
{
    const std::string text = textOf(kRoot / folder / "CMakeLists.txt");
    const std::size_t begin = text.find("set(MIDAIR_STOREYS");
    const std::size_t end = text.find("\n)", begin);
    std::vector<std::string> storeys;
    if (begin == std::string::npos || end == std::string::npos) return storeys;
    std::istringstream lines(text.substr(begin, end - begin));
    std::string line;
    std::getline(lines, line);
    const std::regex pattern(R"(\s+(\S+)\s+# \S.*)");
    while (std::getline(lines, line))
    {
        std::smatch match;
        EXPECT_TRUE(std::regex_match(line, match, pattern))
            << folder << "/CMakeLists.txt: a folder without its sentence: " << line;
        if (match.empty()) continue;
        const std::string name = match[1];
        storeys.push_back(name == "." ? folder.generic_string() : (folder / name).generic_string());
    }
    return storeys;
}

/// Height of each folder of the product over the ground.
std::map<std::string, int> heights()
{
    std::map<std::string, int> height;
    int next = 0;
    for (const char* library : {"haptics/base", "haptics", "device", "engine-bridge"})
        for (const std::string& storey : storeysOf(library))
            height[storey] = next++;
    height["plugin/include/osgMidair"] = next++;
    for (const std::string& storey : storeysOf("plugin"))
        height[storey] = next++;
    height["plugin/serializers"] = next++;
    height["plugin/loader"] = next++;
    return height;
}

std::vector<std::string> includesOf(const fs::path& file)
{
    static const std::regex pattern(R"(#\s*include\s*(?:"([^"]+)\"|<(osgMidair/[^>]+)>))");
    const std::string text = textOf(kRoot / file);
    std::vector<std::string> includes;
    for (std::sregex_iterator match(text.begin(), text.end(), pattern), end; match != end; ++match)
    {
        if ((*match)[1].matched)
        {
            includes.push_back((*match)[1]);
            continue;
        }
        for (const std::string folder : {"haptics", "engine-bridge", "plugin"})
        {
            const std::string installed = folder + "/include/" + (*match)[2].str();
            if (fs::exists(kRoot / installed) || folder == "plugin") includes.push_back(installed);
            if (fs::exists(kRoot / installed)) break;
        }
    }
    return includes;
}

TEST(House, NoIncludeGoesUp)
{
    const std::map<std::string, int> height = heights();
    ASSERT_GT(height.size(), 25u);
    int arrows = 0;
    for (const fs::path& file : allFiles())
    {
        const std::string top = file.begin()->string();
        if (!isSource(file) || top == "samples" || top == "tests") continue;
        const auto own = height.find(file.parent_path().generic_string());
        ASSERT_NE(own, height.end()) << file << " is in a folder that no CMakeLists.txt lists";
        for (const std::string& include : includesOf(file))
        {
            const fs::path other(include);
            const auto there = height.find(other.parent_path().generic_string());
            ASSERT_NE(there, height.end())
                << file << " includes " << include << ", which is in no folder of the product";
            EXPECT_TRUE(fs::exists(kRoot / other)) << file << " includes " << include;
            EXPECT_LE(there->second, own->second) << file << " includes upwards: " << include;
            // Side by side: the array knows no field, the field no array.
            EXPECT_FALSE(top == "device" && *other.begin() == "haptics" &&
                         include.rfind("haptics/base/", 0) != 0)
                << file << " includes " << include;
            ++arrows;
        }
    }
    EXPECT_GT(arrows, 500);
}

// A sample that others are shown includes what is installed; parts of one program are no other's.
TEST(House, SamplesStandSideBySide)
{
    int looked = 0;
    for (const fs::path& file : allFiles())
    {
        if (!isSource(file) || *file.begin() != "samples") continue;
        const std::string own = file.parent_path().generic_string();
        for (const std::string& include : includesOf(file))
        {
            const std::string folder = fs::path(include).parent_path().generic_string();
            ++looked;
            if (*fs::path(include).begin() == "samples")
            {
                EXPECT_TRUE(folder == own || folder == "samples" || folder == "samples/views")
                    << file << " includes " << include;
            }
            EXPECT_NE(*fs::path(include).begin(), "tests") << file << " includes " << include;
            if (file.filename() == "minimal.cpp" || file.filename() == "hands.cpp")
            {
                EXPECT_NE(folder.find("/include/osgMidair"), std::string::npos)
                    << file << " includes " << include;
            }
        }
    }
    EXPECT_GT(looked, 50);
}

TEST(House, OnlyTheUpperStoreysKnowTheSceneGraph)
{
    static const std::regex pattern(
        R"(#\s*include\s*<(osg(?!Midair)\w*/|OpenThreads/|bt[A-Z]|Bullet|LinearMath|openxr/))");
    int known = 0;
    for (const fs::path& file : allFiles())
    {
        if (!isSource(file)) continue;
        const std::string folder = file.parent_path().generic_string();
        const std::string top = file.begin()->string();
        const std::string text = textOf(kRoot / file);
        for (std::sregex_iterator match(text.begin(), text.end(), pattern), end; match != end;
             ++match)
        {
            ++known;
            const std::string of = (*match)[1];
            const bool isGraph = of.rfind("osg", 0) == 0 || of == "OpenThreads/";
            bool allowed = top == "plugin" || top == "tests" || top == "samples";
            if (of == "openxr/")
                allowed = top == "tests" || folder == "engine-bridge/hands/openxr";
            else if (folder == "engine-bridge/scene" || folder == "engine-bridge/bodies")
                allowed = true;
            else if (folder == "engine-bridge/hands")
                allowed = !isGraph;
            EXPECT_TRUE(allowed) << file << " includes " << of << "..";
        }
    }
    EXPECT_GT(known, 20);
}

TEST(House, FoldersAndFilesAreSmall)
{
    std::map<std::string, int> count;
    for (const fs::path& file : allFiles())
    {
        ++count[file.parent_path().generic_string()];
        if (!isSource(file)) continue;
        const std::string text = textOf(kRoot / file);
        EXPECT_LE(std::count(text.begin(), text.end(), '\n'), 400) << file;
    }
    for (const auto& [folder, files] : count)
        EXPECT_LE(files, 25) << folder;
}

TEST(House, TestsMirrorTheFolders)
{
    for (const std::string top : {"haptics", "device", "engine-bridge", "plugin", "samples"})
        for (const auto& entry : fs::recursive_directory_iterator(kRoot / "tests" / top))
        {
            if (!entry.is_directory()) continue;
            EXPECT_TRUE(fs::is_directory(kRoot / fs::relative(entry.path(), kRoot / "tests")))
                << entry.path() << " tests no folder of the product";
        }
    for (const fs::path& file : allFiles())
    {
        const std::string top = file.begin()->string();
        if (file.extension() != ".cpp" || top == "tests") continue;
        const fs::path mirror = kRoot / "tests" / file.parent_path();
        EXPECT_TRUE(fs::is_directory(mirror)) << file << ": there is no " << mirror;
    }
}

TEST(House, InstalledHeadersStandAlone)
{
    static const std::regex inner(R"(namespace midair|midair::(?!haptics::FieldSettings|)"
                                  R"(haptics::FieldFigures|bridge::HologramCounters)|#include ")");
    static const std::regex quoted(R"(#include ")");
    for (const fs::path& file : allFiles())
    {
        const std::string folder = file.parent_path().generic_string();
        if (folder == "haptics/include/osgMidair" || folder == "engine-bridge/include/osgMidair")
        {
            EXPECT_FALSE(std::regex_search(textOf(kRoot / file), quoted)) << file;
        }
        if (folder != "plugin/include/osgMidair") continue;
        std::smatch match;
        const std::string text = textOf(kRoot / file);
        EXPECT_FALSE(std::regex_search(text, match, inner))
            << file << " names what no installed header declares: " << match[0];
    }
}

TEST(House, TheTopLevelIsAsItIs)
{
    const std::set<std::string> files = {
        "CMakeLists.txt", "README.md", "LICENSE", "CHANGELOG.md", "CONTRIBUTING.md"};
    for (const auto& entry : fs::directory_iterator(kRoot))
    {
        const std::string name = entry.path().filename().string();
        if (name.front() == '.' || name.rfind("build", 0) == 0) continue;
        EXPECT_TRUE(entry.is_directory() ? kTops.count(name) : files.count(name)) << name;
    }
}

} // namespace
