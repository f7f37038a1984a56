#pragma once

#include <cstdlib>
#include <string>
#include <vector>

/// A text of one of the variables that cap what a user's programs play. Every interface is tried
/// with all of them: the kit, the C interface, midair-device, midair-tune and recordings.
struct UserCapText
{
    const char* variable;
    std::string text;
    bool isUnderstood;
    bool needsPoints; ///< understood, but nobody can hold it without control points
};

inline std::vector<UserCapText> userCapTexts()
{
    std::string many = "0 0 1";
    for (int k = 0; k < 64; ++k)
        many += ";0 0 1";
    std::vector<UserCapText> all;
    const auto add = [&](const char* variable,
                         const std::vector<std::string>& right,
                         const std::vector<std::string>& wrong,
                         bool needsPoints = false)
    {
        for (const std::string& text : right)
            all.push_back({variable, text, true, needsPoints && text != "0"});
        for (const std::string& text : wrong)
            all.push_back({variable, text, false, false});
    };
    add("OSG_MIDAIR_ENABLED", {"true", "Yes", "1"}, {"", "flase", "2"});
    add("OSG_MIDAIR_MAX_AMPLITUDE", {"0.3", "30 %"}, {"", "much", "nan", "1.5", "-0.1", "0,5"});
    add("OSG_MIDAIR_MAX_PRESSURE",
        {"0", "2 kPa"},
        {"", "loud", "800 kg", "-1", "inf", "2e6"},
        true);
    add("OSG_MIDAIR_EAR_LIMIT",
        {"0", "none", "NONE", "118", "118 dB"},
        {"", "quiet", "12", "1e9", "110,5", "110 Pa", "-5", "nan"});
    add("OSG_MIDAIR_EAR_POINTS",
        {"", "0 0 0.6", "0 0 0.6; 30 0 60 cm;"},
        {"0 0 0.6;;0.3 0 0.6", "0 0", "1 2 3 4", "a b c", "0 0 nan", "0 0 1 kg", ";", many});
    return all;
}

/// Sets a variable of the environment, as the user or the program does, as long as it lives.
class SetVariable
{
public:
    SetVariable(const std::string& name, const std::string& value) : _name(name)
    {
        ::setenv(_name.c_str(), value.c_str(), 1);
    }
    ~SetVariable() { ::unsetenv(_name.c_str()); }
    SetVariable(const SetVariable&) = delete;
    SetVariable& operator=(const SetVariable&) = delete;

private:
    std::string _name;
};
