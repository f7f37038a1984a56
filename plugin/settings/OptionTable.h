#pragma once

#include "haptics/base/text/Number.h"

#include <cmath>
#include <functional>
#include <initializer_list>
#include <string>
#include <utility>
#include <vector>

namespace osgMidair
{

/// Equal, or neither a number: a NaN that stays is no change.
inline bool same(double a, double b)
{
    return a == b || (std::isnan(a) && std::isnan(b));
}

/// One named value of a plain struct \a T: how it is read from text, what it may be, what it is for.
template<typename T>
struct Option
{
    std::string name;
    std::string help;                                ///< with unit, range and default
    std::function<bool(T&, const std::string&)> set; ///< false: not understood
    std::string expected;                            ///< what set() understands
    std::function<bool(T&, const T&, std::string&)>
        repair; ///< true: was out of range; says what it was
};

/// The names and ranges of a struct's values in one place, for files, command lines, tags and help alike.
template<typename T>
class OptionTable
{
public:
    OptionTable&
    number(const char* name, double T::*member, double low, double high, const char* help)
    {
        return ranged(name, member, low, high, help);
    }
    OptionTable& number(const char* name, int T::*member, int low, int high, const char* help)
    {
        return ranged(name, member, low, high, help);
    }
    /// 0, or within the range.
    OptionTable&
    numberOrZero(const char* name, double T::*member, double low, double high, const char* help)
    {
        ranged(name, member, low, high, help);
        Option<T>& option = _options.back();
        option.expected = "0 or " + option.expected;
        option.repair =
            [member, inner = option.repair](T& object, const T& defaults, std::string& what)
        { return object.*member != 0.0 && inner(object, defaults, what); };
        return *this;
    }
    OptionTable& flag(const char* name, bool T::*member, const char* help)
    {
        auto set = [member](T& object, const std::string& text)
        {
            const bool yes = text == "true" || text == "on" || text == "1" || text == "yes";
            const bool no = text == "false" || text == "off" || text == "0" || text == "no";
            if (yes || no) object.*member = yes;
            return yes || no;
        };
        return add({name, help, set, "true or false", {}});
    }
    OptionTable& text(const char* name, std::string T::*member, const char* help)
    {
        auto set = [member](T& object, const std::string& text)
        {
            object.*member = text;
            return true;
        };
        return add({name, help, set, "a text", {}});
    }
    template<typename E>
    OptionTable& choice(const char* name,
                        E T::*member,
                        std::initializer_list<std::pair<const char*, E>> choices,
                        const char* help)
    {
        const std::vector<std::pair<std::string, E>> all(choices.begin(), choices.end());
        std::string expected;
        for (const auto& [word, value] : all)
            expected += (expected.empty() ? "" : ", ") + word;
        auto set = [member, all](T& object, const std::string& text)
        {
            for (const auto& [word, value] : all)
            {
                if (word != text) continue;
                object.*member = value;
                return true;
            }
            return false;
        };
        // A file in binary may hold any number.
        auto repair = [member, all, expected, name](T& object, const T& defaults, std::string& what)
        {
            for (const auto& choice : all)
                if (choice.second == object.*member) return false;
            what = std::string(name) + " is number " +
                   std::to_string(static_cast<int>(object.*member)) + ", should be one of " +
                   expected + "; the default is used";
            object.*member = defaults.*member;
            return true;
        };
        return add({name, help, set, "one of " + expected, repair});
    }
    OptionTable& add(Option<T> option)
    {
        _options.push_back(std::move(option));
        return *this;
    }

    bool set(T& object, const std::string& name, const std::string& value, std::string& error) const
    {
        std::string known;
        for (const Option<T>& option : _options)
        {
            known += (known.empty() ? "" : ", ") + option.name;
            if (option.name != name) continue;
            if (option.set(object, value)) return true;
            error = name + " is \"" + value + "\", should be " + option.expected;
            return false;
        }
        error = "unknown option \"" + name + "\"; known are " + known;
        return false;
    }

    std::vector<std::string> repair(T& object) const
    {
        std::vector<std::string> said;
        const T defaults;
        for (const Option<T>& option : _options)
        {
            std::string what;
            if (option.repair && option.repair(object, defaults, what)) said.push_back(what);
        }
        return said;
    }

    std::vector<std::pair<std::string, std::string>> describe() const
    {
        std::vector<std::pair<std::string, std::string>> all;
        for (const Option<T>& option : _options)
            all.emplace_back(option.name, option.help);
        return all;
    }

private:
    static bool read(const std::string& text, double& value)
    {
        return midair::base::parseNumber(text, value);
    }
    static bool read(const std::string& text, int& value)
    {
        return midair::base::parseWhole(text, value);
    }
    static std::string trimmed(const std::string& text)
    {
        const std::size_t first = text.find_first_not_of(" \t");
        if (first == std::string::npos) return {};
        return text.substr(first, text.find_last_not_of(" \t") - first + 1);
    }
    static std::string written(double value) { return midair::base::shortNumber(value); }

    template<typename V>
    OptionTable& ranged(const char* name, V T::*member, V low, V high, const char* help)
    {
        const std::string range = written(low) + " .. " + written(high);
        auto set = [member](T& object, const std::string& text)
        { return read(trimmed(text), object.*member); };
        auto repair = [=](T& object, const T& defaults, std::string& what)
        {
            V& value = object.*member;
            if (value >= low && value <= high) return false; // false for NaN, too
            what = std::string(name) + " is " + written(value) + ", should be " + range + "; " +
                   written(defaults.*member) + " is used";
            value = defaults.*member;
            return true;
        };
        return add({name, help, set, "a number, " + range, repair});
    }

    std::vector<Option<T>> _options;
};

} // namespace osgMidair
