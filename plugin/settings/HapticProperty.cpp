#include "plugin/settings/AllSettings.h"
#include "plugin/settings/Assignments.h"

#include <osgMidair/HapticProperty>

namespace osgMidair
{

bool HapticProperty::set(const std::string& name, const std::string& value, std::string& error)
{
    return surfaceProperties().set(*this, name, value, error);
}

void HapticProperty::parse(const std::string& text, std::vector<std::string>& errors)
{
    // "a=1; b=2" or "a=1 b=2"; a value with a unit ("500 Pa") needs the semicolon, a comma or the
    // end after it.
    forEachAssignment(text,
                      [this, &errors](const std::string& name, const std::string& value)
                      {
                          std::string error;
                          if (!set(name.empty() ? "enabled" : name, value, error))
                              errors.push_back(error);
                      });
}

std::vector<std::string> HapticProperty::repair()
{
    return surfaceProperties().repair(*this);
}

std::vector<std::pair<std::string, std::string>> HapticProperty::describe()
{
    return surfaceProperties().describe();
}

int HapticProperty::formatVersion()
{
    static const int newest = surfaceProperties().newestVersion();
    return newest;
}

bool operator==(const HapticProperty& a, const HapticProperty& b)
{
    return surfaceProperties().areSame(a, b);
}

} // namespace osgMidair
