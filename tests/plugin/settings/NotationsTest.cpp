// plugin/NOTATIONS.md against the tables of settings.
#include "plugin/settings/AllSettings.h"

#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

using namespace osgMidair;

namespace
{

/// midair-demo's option. It takes an object's pressure in Pa, and plays no objects that are off.
std::string optionOf(const std::string& name, bool isScene)
{
    if (!isScene && (name == "enabled" || name == "unit")) return "";
    std::string option = "`--";
    for (const char c : name)
        if (c >= 'A' && c <= 'Z')
            option += std::string("-") + static_cast<char>(c - 'A' + 'a');
        else
            option += c;
    return option + "`";
}

/// A row for each setting: its name, in node files, in tags and options, as a variable and on the
/// command line. The header's line has no code in its first column.
template<typename T>
void addRows(const SettingTable<T>& table, bool isScene, std::vector<std::string>& rows)
{
    for (const Setting<T>& row : table.rows())
        rows.push_back("| `" + row.name + "` | `" + row.storedName() + "` | `" + row.name +
                       "=` | " + (row.variable.empty() ? "" : "`OSG_MIDAIR_" + row.variable + "`") +
                       " | " + optionOf(row.name, isScene) + " |");
}

} // namespace

TEST(Notations, AreThoseOfTheTables)
{
    std::vector<std::string> wanted;
    addRows(surfaceProperties(), false, wanted);
    addRows(sceneSettings(), true, wanted);
    std::ifstream in(MIDAIR_ROOT "/plugin/NOTATIONS.md");
    std::vector<std::string> said;
    for (std::string line; std::getline(in, line);)
        if (line.compare(0, 3, "| `") == 0) said.push_back(line);
    std::string all;
    for (const std::string& row : wanted)
        all += row + "\n";
    EXPECT_EQ(said, wanted) << "plugin/NOTATIONS.md should have these rows:\n" << all;
}
