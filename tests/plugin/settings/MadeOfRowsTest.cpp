// What documents and public headers say of settings and overlays is made of their rows:
//     MIDAIR_WRITE_ROWS=1 build/bin/midair_plugin_tests --gtest_filter='MadeOfRows.*'
// writes it anew; without the variable these tests say where it differs.
#include "haptics/base/text/Number.h"
#include "plugin/overlays/OverlayPart.h"
#include "plugin/settings/AllSettings.h"

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

using namespace osgMidair;

namespace
{

using Lines = std::vector<std::string>;

const std::string kHow =
    "; MIDAIR_WRITE_ROWS=1 build/bin/midair_plugin_tests --gtest_filter='MadeOfRows.*' writes it";

std::string textOf(const std::string& file)
{
    std::ifstream in(MIDAIR_ROOT "/" + file);
    std::ostringstream text;
    text << in.rdbuf();
    EXPECT_FALSE(text.str().empty()) << file;
    return text.str();
}

Lines linesOf(const std::string& text)
{
    std::istringstream in(text);
    Lines lines;
    for (std::string line; std::getline(in, line);)
        lines.push_back(line);
    return lines;
}

std::string joined(const Lines& lines)
{
    std::string text;
    for (const std::string& line : lines)
        text += line + "\n";
    return text;
}

/// Compares \a wanted with the text of \a file, or writes it.
void expectText(const std::string& file, const std::string& wanted)
{
    const std::string said = textOf(file);
    if (std::getenv("MIDAIR_WRITE_ROWS"))
    {
        if (said != wanted) std::ofstream(MIDAIR_ROOT "/" + file) << wanted;
        return;
    }
    const Lines a = linesOf(said);
    const Lines b = linesOf(wanted);
    for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i)
        ASSERT_EQ(a[i], b[i]) << file << ":" << i + 1 << kHow;
    ASSERT_EQ(said.size(), wanted.size()) << file << kHow;
}

/// \a text in lines that begin with \a begin and are at most \a width wide.
Lines wrapped(const std::string& text, const std::string& begin, std::size_t width)
{
    Lines lines;
    std::istringstream in(text);
    for (std::string word; in >> word;)
        if (lines.empty() || lines.back().size() + 1 + word.size() > width)
            lines.push_back(begin + word);
        else
            lines.back() += " " + word;
    return lines;
}

// --- Documents -----------------------------------------------------------------------------------

template<typename T>
Lines valueRows(const SettingTable<T>& table, const std::string& what)
{
    Lines rows = {"| " + what + " | default | values | |", "|---|---|---|---|"};
    for (const Setting<T>& row : table.rows())
        rows.push_back("| `" + row.name + "` | " + row.defaultText() + " | " + row.values() +
                       " | " + row.help + " |");
    return rows;
}

template<typename T>
std::string safetyNames(const SettingTable<T>& table)
{
    std::string names;
    for (const Setting<T>& row : table.rows())
        if (row.isSafety) names += (names.empty() ? "`" : ", `") + row.name + "`";
    return names;
}

Lines safetyLines()
{
    return wrapped("Of a scene " + safetyNames(sceneSettings()) + "; of an object " +
                       safetyNames(surfaceProperties()) + ".",
                   "",
                   140);
}

Lines variableLines()
{
    std::string names;
    for (const auto& row : sceneSettings().rows())
        if (!row.variable.empty())
            names += (names.empty() ? "`OSG_MIDAIR_" : ", `OSG_MIDAIR_") + row.variable + "`";
    return wrapped(names + ".", "", 140);
}

Lines overlayRows()
{
    Lines rows = {"| overlay | key | in files | node | what is seen |", "|---|---|---|---|---|"};
    for (const auto& [place, kind] : overlayKinds())
        rows.push_back("| `" + kind.word + "` | " + kind.keyName() + " | `Show" + kind.name +
                       "` | `" + kind.make()->className() + "` | " + kind.seen +
                       (kind.isHidden ? "; hidden at first" : "") + " |");
    return rows;
}

Lines overlayNumberRows()
{
    Lines rows = {"| number | default | values | |", "|---|---|---|---|"};
    for (const auto& [place, kind] : overlayKinds())
        for (const OverlayNumber& number : kind.numbers)
            rows.push_back("| `" + number.name + "` | " +
                           midair::base::shortNumber(number.get(*kind.make())) + " | " +
                           number.numbers() + " | " + number.help + " |");
    return rows;
}

/// The text of \a file with what is between "<!-- rows: NAME -->" and "<!-- end of rows -->" made
/// by the makers, each of which has to be used once.
std::string withRows(const std::string& file, std::map<std::string, std::function<Lines()>> makers)
{
    static const std::regex begin("<!-- rows: ([^>]*) -->");
    Lines made;
    bool isInside = false;
    for (const std::string& line : linesOf(textOf(file)))
    {
        std::smatch match;
        if (line == "<!-- end of rows -->") isInside = false;
        if (!isInside) made.push_back(line);
        if (!std::regex_match(line, match, begin)) continue;
        const auto maker = makers.find(match[1]);
        EXPECT_NE(maker, makers.end()) << file << ": " << match[1];
        if (maker == makers.end()) continue;
        made.emplace_back();
        for (const std::string& row : maker->second())
            made.push_back(row);
        made.emplace_back();
        makers.erase(maker);
        isInside = true;
    }
    EXPECT_FALSE(isInside) << file << " has no end of rows";
    EXPECT_TRUE(makers.empty()) << file << " lacks rows of " << makers.begin()->first;
    return joined(made);
}

// --- Headers -------------------------------------------------------------------------------------

/// The comment of a row's setter.
template<typename T>
Lines commentOf(const Setting<T>& row)
{
    std::string text = row.summary();
    text[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(text[0])));
    return wrapped(text + ".", "    /// ", 100);
}

/// The text of the header \a file, where the first paragraph above each setter of a row of \a table
/// is made of the row; what follows after an empty line of the comment stays. \a found: the rows
/// that have a setter there.
template<typename T>
std::string
withComments(const std::string& file, const SettingTable<T>& table, std::vector<std::string>& found)
{
    static const std::regex setter("    void set(\\w+)\\(.*");
    Lines made;
    for (const std::string& line : linesOf(textOf(file)))
    {
        std::smatch match;
        const Setting<T>* row = nullptr;
        if (std::regex_match(line, match, setter))
            for (const Setting<T>& each : table.rows())
                if (each.storedName() == match[1]) row = &each;
        if (row)
        {
            found.push_back(row->name);
            std::size_t first = made.size();
            while (first > 0 && made[first - 1].compare(0, 7, "    ///") == 0)
                --first;
            const auto begin = made.begin() + static_cast<std::ptrdiff_t>(first);
            const auto own = std::find(begin, made.end(), "    ///");
            Lines comment = commentOf(*row);
            comment.insert(comment.end(), own, made.end());
            made.erase(begin, made.end());
            made.insert(made.end(), comment.begin(), comment.end());
        }
        made.push_back(line);
    }
    return joined(made);
}

template<typename T>
void expectComments(const Lines& files, const SettingTable<T>& table)
{
    std::vector<std::string> found;
    for (const std::string& file : files)
        expectText(file, withComments(file, table, found));
    for (const Setting<T>& row : table.rows())
        EXPECT_EQ(std::count(found.begin(), found.end(), row.name), 1)
            << row.name << " has to have one setter, set" << row.storedName() << "()";
}

const Lines kSceneHeaders = {"haptics/include/osgMidair/FieldSettings",
                             "engine-bridge/include/osgMidair/SceneSettings",
                             "plugin/include/osgMidair/HapticSettings"};
const Lines kObjectHeaders = {"engine-bridge/include/osgMidair/ObjectSettings",
                              "plugin/include/osgMidair/HapticProperty"};

} // namespace

TEST(MadeOfRows, ValuesOfScenesAndOverlays)
{
    expectText("samples/guides/SETTINGS.md",
               withRows("samples/guides/SETTINGS.md",
                        {{"objects", [] { return valueRows(surfaceProperties(), "property"); }},
                         {"scenes", [] { return valueRows(sceneSettings(), "setting"); }},
                         {"safety", safetyLines},
                         {"variables", variableLines},
                         {"overlays", overlayRows},
                         {"overlays' numbers", overlayNumberRows}}));
}

TEST(MadeOfRows, CommentsOfSetters)
{
    expectComments(kSceneHeaders, sceneSettings());
    expectComments(kObjectHeaders, surfaceProperties());
}

// What a row says is not said again by hand: members have no comment with a range or a default, and
// neither have the paragraphs below a setter's first.
TEST(MadeOfRows, NoRangeAndNoDefaultIsWrittenByHand)
{
    static const std::regex number(R"([0-9] \.\. -?[0-9]|[Dd]efault:? [0-9"A-Z]|\(the default\))");
    EXPECT_TRUE(std::regex_search("    double reach = 0.0; ///< m, 0 .. 10", number));
    EXPECT_TRUE(std::regex_search("    /// Hz. Default 5.", number));
    std::set<std::string> made;
    const auto note = [&made](const auto& table)
    {
        for (const auto& row : table.rows())
            for (const std::string& line : commentOf(row))
                made.insert(line);
    };
    note(sceneSettings());
    note(surfaceProperties());
    for (const Lines& files : {kSceneHeaders, kObjectHeaders})
        for (const std::string& file : files)
            for (const std::string& line : linesOf(textOf(file)))
                if (made.count(line) == 0 && line.find("//") != std::string::npos)
                {
                    EXPECT_FALSE(std::regex_search(line, number)) << file << ": " << line;
                }
}
