// README.md and the guides: short, all of them found from an index, and showing files as they are.

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>

#include <gtest/gtest.h>

namespace
{

namespace fs = std::filesystem;

const std::string kGuides = "samples/guides/";

std::string content(const std::string& path)
{
    std::ifstream file(MIDAIR_ROOT "/" + path);
    EXPECT_TRUE(file) << path;
    std::stringstream text;
    text << file.rdbuf();
    return text.str();
}

auto linesOf(const std::string& text)
{
    return std::count(text.begin(), text.end(), '\n');
}

/// All documents of the project, below its root.
std::set<std::string> documents()
{
    std::set<std::string> found;
    for (const auto& entry : fs::recursive_directory_iterator(MIDAIR_ROOT))
    {
        const std::string path = fs::relative(entry.path(), MIDAIR_ROOT).generic_string();
        if (entry.path().extension() == ".md" && path.rfind("build", 0) != 0) found.insert(path);
    }
    return found;
}

TEST(Readme, IsShortAndBeginsWithAPicture)
{
    const std::string readme = content("README.md");
    EXPECT_LT(linesOf(readme), 90);
    EXPECT_LT(readme.find("!["), 100U);
}

// samples/run.sh is all that a newcomer has built.
TEST(Readme, ItsProgramsAreBuiltByItsFirstCommand)
{
    const std::string readme = content("README.md");
    const std::string cmake = content("samples/CMakeLists.txt");
    const std::size_t at = cmake.find("add_dependencies(midair_run midair-demo");
    ASSERT_NE(at, std::string::npos);
    const std::string built = cmake.substr(at, cmake.find(')', at) - at) + " ";
    const std::regex program("build/bin/([a-z-]+)");
    const auto begin = std::sregex_iterator(readme.begin(), readme.end(), program);
    ASSERT_NE(begin, std::sregex_iterator());
    for (auto one = begin; one != std::sregex_iterator(); ++one)
        EXPECT_NE(built.find(" " + (*one)[1].str() + " "), std::string::npos) << one->str();
}

TEST(Readme, LeadsToEachDocument)
{
    const std::string readme = content("README.md");
    const std::string index = content(kGuides + "README.md");
    EXPECT_NE(readme.find("(" + kGuides + "README.md"), std::string::npos);
    for (const std::string& path : documents())
    {
        const bool isGuide = path.rfind(kGuides, 0) == 0;
        if (path == "README.md" || path == kGuides + "README.md") continue;
        EXPECT_NE(index.find(isGuide ? "(" + path.substr(kGuides.size()) : "(../../" + path),
                  std::string::npos)
            << path;
    }
}

TEST(Guides, AreFewAndHaveNamesOfTheirOwn)
{
    std::ptrdiff_t guides = 0;
    std::ptrdiff_t lines = 0;
    std::set<std::string> names;
    for (const std::string& path : documents())
    {
        const std::string name = fs::path(path).filename().string();
        EXPECT_TRUE(names.insert(name).second || name == "README.md") << path;
        if (path.rfind(kGuides, 0) != 0) continue;
        ++guides;
        lines += linesOf(content(path));
    }
    EXPECT_GT(guides, 15);
    EXPECT_LE(guides, 25);
    EXPECT_LE(lines, 3500);
}

TEST(Guides, ShowTheSceneAsItIs)
{
    EXPECT_NE(
        content(kGuides + "START.md").find("\n" + content("samples/scenes/star.osgt") + "```"),
        std::string::npos);
}

// The pictures themselves: tests/documents.
TEST(Guides, ShowAPictureOfEachStepAndSample)
{
    std::istringstream start(content(kGuides + "START.md"));
    std::map<std::string, std::string> steps;
    std::string heading;
    for (std::string line; std::getline(start, line);)
    {
        if (line.rfind("## ", 0) == 0) heading = line;
        if (std::regex_search(heading, std::regex("^## [0-9]"))) steps[heading] += line + ' ';
    }
    EXPECT_EQ(steps.size(), 6U);
    for (const auto& [step, text] : steps)
    {
        EXPECT_NE(text.find("](../pictures/start/"), std::string::npos) << step;
        EXPECT_NE(text.find("ou should see"), std::string::npos) << step;
    }
    std::istringstream programs(content(kGuides + "CPP.md"));
    int samples = 0;
    for (std::string line; std::getline(programs, line);)
    {
        if (!std::regex_search(line, std::regex(R"(^\| [0-9]+ \| `)"))) continue;
        ++samples;
        EXPECT_NE(line.find("](../pictures/samples/"), std::string::npos) << line;
    }
    EXPECT_GE(samples, 27);
}

} // namespace
