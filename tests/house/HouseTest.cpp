// The house's own rules, read from its files: which way includes point, how many members classes
// have.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <utility>
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
    for (const char* library :
         {"haptics/base", "haptics", "device", "device/autd3/emulator", "engine-bridge"})
        for (const std::string& storey : storeysOf(library))
            height[storey] = next++;
    // Four folders of what is installed into one.
    height["plugin/extending/include/osgMidair"] = next;
    height["plugin/overlays/include/osgMidair"] = next;
    height["plugin/display/include/osgMidair"] = next;
    height["plugin/include/osgMidair"] = next++;
    for (const std::string& storey : storeysOf("plugin"))
        height[storey] = next++;
    height["plugin/osg-plugins"] = next++;
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
            // Headers of the C interface stand beside each other in the tree and where they are
            // installed.
            const std::string quoted = (*match)[1];
            const bool isBeside = quoted.find('/') == std::string::npos;
            includes.push_back(isBeside ? (file.parent_path() / quoted).generic_string() : quoted);
            continue;
        }
        for (const std::string folder : {"haptics",
                                         "engine-bridge",
                                         "plugin/extending",
                                         "plugin/overlays",
                                         "plugin/display",
                                         "plugin"})
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

// Samples include what is installed, as programs of others do: of the kit the public headers alone,
// of what has no scene the libraries that are components; parts of one program are no other's, but
// for what reads a scene file (midair-check's and midair-bake's) and what solves for a row
// (midair-solve's and midair-sweep's).
TEST(House, SamplesStandSideBySide)
{
    const std::set<std::string> shared = {"samples/shared",
                                          "samples/installations/shell",
                                          "samples/shared/monitor",
                                          "samples/shared/monitor/page",
                                          "samples/shared/views",
                                          "samples/shared/shards"};
    const std::set<std::pair<std::string, std::string>> lent = {
        {"samples/tools/bake", "samples/tools/check"},
        {"samples/experiments/jnd", "samples/experiments/paper"},
        {"samples/experiments/coincide", "samples/experiments/jnd"},
        {"samples/installations/paper", "samples/experiments/paper"},
        {"samples/tools/sweep", "samples/tools/solve"}};
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
                EXPECT_TRUE(folder == own || shared.count(folder) > 0 ||
                            lent.count({own, folder}) > 0)
                    << file << " includes " << include;
            }
            const bool isInstalled = include.find("/include/osgMidair/") != std::string::npos ||
                                     include.rfind("haptics/", 0) == 0 ||
                                     include.rfind("device/", 0) == 0 ||
                                     include.rfind("engine-bridge/playing/", 0) == 0 ||
                                     include.rfind("engine-bridge/calibration/", 0) == 0 ||
                                     include.rfind("engine-bridge/hands/round/", 0) == 0 ||
                                     include.rfind("engine-bridge/display/", 0) == 0 ||
                                     include.rfind("engine-bridge/tags/", 0) == 0 ||
                                     include.rfind("engine-bridge/solving/", 0) == 0;
            EXPECT_TRUE(isInstalled || *fs::path(include).begin() == "samples")
                << file << " includes " << include;
            // Those in the folder itself and the main one show the kit, by its public headers
            // alone.
            if (own == "samples/demo" ||
                ((own == "samples/tools" || own == "samples/features") &&
                 file.extension() == ".cpp" && file.filename() != "23-without-scene.cpp"))
            {
                if (*fs::path(include).begin() == "samples") continue;
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
            else if (folder == "engine-bridge/scene" || folder == "engine-bridge/scene/drawn" ||
                     folder == "engine-bridge/bodies")
                allowed = true;
            else if (folder == "engine-bridge/hands")
                allowed = !isGraph;
            EXPECT_TRUE(allowed) << file << " includes " << of << "..";
        }
    }
    EXPECT_GT(known, 20);
}

// A class of one idea has few data members.
TEST(House, ClassesHaveFewMembers)
{
    constexpr int kMost = 15;
    static const std::regex opens(
        R"(^ *(?:class|struct) (?:alignas\(\d+\) )?(?:OSGMIDAIR_\w+ )?(\w+)[^;]*$)");
    static const std::regex member(
        R"(^ +(?!return|using|friend|static)[^()=]*[ *&>]_\w+( = [^;]*|\{[^;]*\})?;.*)");
    // What is guarded counts as well, and may stand on a line of its own.
    static const std::regex guard(R"(\s*MIDAIR_(PT_)?GUARDED_BY\([^()]*\))");
    struct Open
    {
        std::string name;
        long depth;
        int members;
    };
    int classes = 0;
    for (const fs::path& file : allFiles())
    {
        if (!isSource(file) || *file.begin() == "tests") continue;
        std::istringstream lines(std::regex_replace(textOf(kRoot / file), guard, ""));
        std::vector<Open> open;
        long depth = 0;
        std::smatch match;
        for (std::string line; std::getline(lines, line);)
        {
            const bool isClass = std::regex_match(line, match, opens);
            if (isClass) open.push_back({match[1], depth, 0});
            depth += std::count(line.begin(), line.end(), '{');
            depth -= std::count(line.begin(), line.end(), '}');
            if (open.empty()) continue;
            if (!isClass && depth == open.back().depth + 1 && std::regex_match(line, member))
                ++open.back().members;
            if (depth > open.back().depth || line.find('}') == std::string::npos) continue;
            EXPECT_LE(open.back().members, kMost) << open.back().name << " in " << file;
            classes += open.back().members > 0 ? 1 : 0;
            open.pop_back();
        }
    }
    EXPECT_GT(classes, 200);
}

// Two classes of one name in one namespace are undefined behaviour that no compiler tells: the
// linker keeps one of their functions, and which depends on the optimisation.
TEST(House, EachClassHasANameOfItsOwn)
{
    static const std::regex opens(R"(namespace( [\w:]+)?)");
    static const std::regex defines(
        R"((?:template<.*> ?)?(?:class|struct) (?:OSGMIDAIR_[A-Z_]+ )?(\w+)(?: final)?(?: :.*)?)");
    std::map<std::string, std::set<fs::path>> files;
    for (const fs::path& file : allFiles())
    {
        if (!isSource(file) || *file.begin() == "tests" || *file.begin() == "samples") continue;
        std::istringstream lines(textOf(kRoot / file));
        std::vector<std::string> spaces;
        std::smatch match;
        for (std::string line; std::getline(lines, line);)
            if (std::regex_match(line, match, opens))
                spaces.push_back(match[1]);
            else if (line.rfind("} // namespace", 0) == 0 && !spaces.empty())
                spaces.pop_back();
            else if (std::regex_match(line, match, defines) &&
                     std::count(spaces.begin(), spaces.end(), "") == 0)
            {
                std::string name;
                for (const std::string& space : spaces)
                    name += space + "::";
                files[name + match[1].str()].insert(file);
            }
    }
    EXPECT_GT(files.size(), 200U);
    for (const auto& [name, places] : files)
        EXPECT_EQ(places.size(), 1U)
            << name << " in " << *places.begin() << " and " << *places.rbegin();
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
    static const std::regex inner(
        R"(namespace midair|midair::(?!haptics::FieldSettings|)"
        R"(haptics::FieldFigures|haptics::ExposureFigures|)"
        R"(bridge::HologramCounters|bridge::SceneSettings|bridge::ObjectSettings|bridge::SceneStatistics)|#include ")");
    static const std::regex quoted(R"(#include ")");
    for (const fs::path& file : allFiles())
    {
        const std::string folder = file.parent_path().generic_string();
        if (folder == "haptics/include/osgMidair" || folder == "engine-bridge/include/osgMidair")
        {
            EXPECT_FALSE(std::regex_search(textOf(kRoot / file), quoted)) << file;
        }
        if (folder != "plugin/include/osgMidair" &&
            folder != "plugin/extending/include/osgMidair" &&
            folder != "plugin/overlays/include/osgMidair")
            continue;
        std::smatch match;
        const std::string text = textOf(kRoot / file);
        EXPECT_FALSE(std::regex_search(text, match, inner))
            << file << " names what no installed header declares: " << match[0];
    }
}

// A code that nothing says any more is one that programs wait for in vain.
TEST(House, EachMessageCodeIsSaid)
{
    const std::string header = textOf(kRoot / "haptics/base/text/MessageLog.h");
    const std::size_t begin = header.find("enum class MessageCode");
    const std::string list = header.substr(begin, header.find("};", begin) - begin);
    std::set<std::string> unsaid;
    const std::regex pattern(R"(\n    ([A-Z_]+))");
    for (std::sregex_iterator match(list.begin(), list.end(), pattern), end; match != end; ++match)
        unsaid.insert((*match)[1]);
    EXPECT_GT(unsaid.size(), 40u);
    const std::regex use(R"(MessageCode::([A-Z_]+))");
    for (const fs::path& file : allFiles())
    {
        if (!isSource(file) || *file.begin() == "tests") continue;
        const std::string text = textOf(kRoot / file);
        for (std::sregex_iterator match(text.begin(), text.end(), use), end; match != end; ++match)
            unsaid.erase((*match)[1]);
    }
    for (const std::string& code : unsaid)
        ADD_FAILURE() << code << " is said by nothing";
}

TEST(House, TheTopLevelIsAsItIs)
{
    const std::set<std::string> files = {"CMakeLists.txt",
                                         "CMakePresets.json",
                                         "README.md",
                                         "LICENSE",
                                         "CHANGELOG.md",
                                         "CONTRIBUTING.md"};
    for (const auto& entry : fs::directory_iterator(kRoot))
    {
        const std::string name = entry.path().filename().string();
        if (name.front() == '.' || name.rfind("build", 0) == 0) continue;
        EXPECT_TRUE(entry.is_directory() ? kTops.count(name) : files.count(name)) << name;
    }
}

} // namespace
