#include "plugin/settings/Assignments.h"
#include "plugin/settings/UserOptions.h"
#include "tests/TrustedVariables.h"
#include "tests/fuzz/FuzzTargets.h"
#include "tests/fuzz/Require.h"

#include <osgMidair/HapticProperty>
#include <osgMidair/HapticSettings>

#include <cstdlib>
#include <sstream>
#include <string>
#include <vector>

using namespace osgMidair;

namespace
{

/// What was out of range is back to its default once it was said.
template<typename T>
void requireRepairs(T values)
{
    values.repair();
    require(values.repair().empty(), "what was repaired is in range");
}

bool knows(const std::vector<std::pair<std::string, std::string>>& described,
           const std::string& name)
{
    for (const auto& entry : described)
        if (entry.first == name) return true;
    return false;
}

} // namespace

void fuzzOptions(const std::uint8_t* data, std::size_t size)
{
    const std::string text(reinterpret_cast<const char*>(data), size);
    HapticSettings settings;
    HapticProperty property;
    for (const auto& [name, value, line] : assignmentsIn(text))
    {
        require(line >= 1, "lines are counted from 1");
        std::string error;
        const bool set = settings.set(name, value, error);
        require(set != !error.empty(), "what is not understood has an error, and nothing else");
        require(!set || knows(HapticSettings::describe(), name), "only known names are set");
        error.clear();
        require(property.set(name, value, error) != !error.empty(),
                "what is not understood has an error, and nothing else");
    }
    requireRepairs(settings);
    requireRepairs(property);
    std::vector<std::string> errors;
    HapticProperty tag;
    tag.parse(text, errors);
    requireRepairs(tag);
}

void fuzzEnvironment(const std::uint8_t* data, std::size_t size)
{
    midair::base::trustVariablesOfProgram(); // as if they had been there when it began
    std::istringstream lines(std::string(reinterpret_cast<const char*>(data), size));
    std::vector<std::string> names;
    for (std::string line; std::getline(lines, line);)
    {
        const std::size_t equals = line.find('=');
        if (equals == std::string::npos || equals == 0) continue;
        names.push_back("OSG_MIDAIR_" + line.substr(0, equals));
        // What follows a zero byte can't be said in an environment.
        setenv(names.back().c_str(), line.c_str() + equals + 1, 1);
    }
    std::vector<std::string> errors;
    requireRepairs(Environment::restrict(Environment::replace(HapticSettings(), errors)));
    for (const std::string& error : errors)
        require(error.compare(0, 11, "OSG_MIDAIR_") == 0, "an error names its variable");
    Environment::reportFile();
    for (const std::string& name : names)
        unsetenv(name.c_str());
}
