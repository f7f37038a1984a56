// Links of the project's documents lead somewhere.

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <regex>
#include <sstream>
#include <string>

#include <gtest/gtest.h>

namespace
{

namespace fs = std::filesystem;

std::string textOfFile(const fs::path& file)
{
    std::ifstream in(file);
    std::ostringstream text;
    text << in.rdbuf();
    return text.str();
}

/// True if \a document has a heading with this anchor, made as code hosts make them: small letters,
/// hyphens for blanks, no punctuation.
bool hasHeading(const std::string& document, const std::string& anchor)
{
    std::istringstream lines(document);
    for (std::string line; std::getline(lines, line);)
    {
        if (line.empty() || line[0] != '#') continue;
        std::string made;
        for (const char c : line.substr(std::min(line.find(' ') + 1, line.size())))
            if (c == ' ')
                made += '-';
            else if (std::isalnum(static_cast<unsigned char>(c)) || c == '-' || c == '_')
                made += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
        if (made == anchor) return true;
    }
    return false;
}

int checkLinks(const fs::path& file)
{
    static const std::regex link(R"(\]\(([^)\s#]*)(?:#([^)\s]*))?\))");
    const std::string text = textOfFile(file);
    int count = 0;
    for (std::sregex_iterator match(text.begin(), text.end(), link), end; match != end; ++match)
    {
        const std::string target = (*match)[1];
        if (target.rfind("http", 0) == 0) continue;
        ++count;
        const fs::path other = target.empty() ? file : file.parent_path() / target;
        EXPECT_TRUE(fs::exists(other)) << file << " links to " << target;
        const std::string anchor = (*match)[2];
        if (!anchor.empty() && fs::is_regular_file(other))
        {
            EXPECT_TRUE(hasHeading(textOfFile(other), anchor))
                << file << " links to " << other << ", which has no heading for #" << anchor;
        }
    }
    return count;
}

} // namespace

// Programs set by a setter what files and options set by a name.
TEST(Documents, EachSettingHasItsSetter)
{
    const fs::path root = MIDAIR_ROOT;
    const std::string headers =
        textOfFile(root / "plugin/include/osgMidair/HapticSettings") +
        textOfFile(root / "plugin/include/osgMidair/HapticProperty") +
        textOfFile(root / "engine-bridge/include/osgMidair/SceneSettings") +
        textOfFile(root / "engine-bridge/include/osgMidair/ObjectSettings") +
        textOfFile(root / "haptics/include/osgMidair/FieldSettings");
    const std::string text = textOfFile(root / "samples/guides/SETTINGS.md");
    const std::string tables =
        text.substr(text.find("## Objects"), text.find("## Names") - text.find("## Objects"));
    static const std::regex row(R"(\n\| `(\w+)` \|)");
    int count = 0;
    for (std::sregex_iterator match(tables.begin(), tables.end(), row), end; match != end; ++match)
    {
        std::string name = (*match)[1];
        if (name == "unit") name = "pressureUnit";
        name[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(name[0])));
        EXPECT_NE(headers.find("void set" + name + "("), std::string::npos) << name;
        ++count;
    }
    EXPECT_GT(count, 60);
}

TEST(Documents, LinkToWhatIsThere)
{
    const fs::path root = MIDAIR_ROOT;
    int count = 0;
    for (const auto& entry : fs::directory_iterator(root))
        if (entry.path().extension() == ".md") count += checkLinks(entry.path());
    for (const char* top : {"haptics", "device", "engine-bridge", "plugin", "samples", "tests"})
        for (const auto& entry : fs::recursive_directory_iterator(root / top))
            if (entry.path().extension() == ".md") count += checkLinks(entry.path());
    EXPECT_GT(count, 30);
}
