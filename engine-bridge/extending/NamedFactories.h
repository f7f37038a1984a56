#pragma once

#include "haptics/base/InputError.h"
#include "haptics/base/ThrownBy.h"
#include "haptics/base/threads/Mutex.h"

#include <algorithm>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace midair::bridge
{

/// Factories of one kind that an application registered by name. Any thread.
template<typename Factory>
class NamedFactories
{
public:
    /// \a kind: "solver", for error messages.
    explicit NamedFactories(std::string kind) : _kind(std::move(kind)) {}

    /// Returns false, with the reason in \a error, unless \a name has 1 .. 32 small letters, digits
    /// and dashes, is not one of \a known, the kit's own names, and is free.
    bool add(const std::string& name,
             Factory make,
             const std::vector<std::string>& known,
             std::string& error)
    {
        const bool isName =
            !name.empty() && name.size() <= kMostLetters &&
            name.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789-") == std::string::npos;
        if (!isName)
            error = "\"" + name + "\" is not a valid name of a " + _kind +
                    "; it must have 1 to 32 small letters, digits and dashes";
        else if (!make)
            error = "the " + _kind + " \"" + name + "\" was registered without a factory";
        else
        {
            const base::Lock lock(_mutex);
            const bool isKnown = std::find(known.begin(), known.end(), name) != known.end();
            if (!isKnown && _makers.emplace(name, std::move(make)).second) return true;
            error = "the name \"" + name + "\" is taken";
        }
        return false;
    }

    /// Returns an empty function for an unknown name.
    Factory find(const std::string& name)
    {
        const base::Lock lock(_mutex);
        const auto found = _makers.find(name);
        return found == _makers.end() ? Factory() : found->second;
    }

    std::vector<std::string> names()
    {
        const base::Lock lock(_mutex);
        std::vector<std::string> all;
        for (const auto& entry : _makers)
            all.push_back(entry.first);
        return all;
    }

private:
    static constexpr std::size_t kMostLetters = 32;

    const std::string _kind;
    base::Mutex _mutex;
    std::map<std::string, Factory> _makers MIDAIR_GUARDED_BY(_mutex);
};

/// Calls \a make, which is application code, with the part of \a text after the colon. Throws
/// base::InputError, with \a name (which describes \a text) and the reason, if it throws or returns
/// null.
template<typename Factory>
auto makeNamed(const Factory& make, const std::string& text, const std::string& name)
{
    std::string why = "it could not be made";
    try
    {
        if (auto made = make(text.substr(text.find(':') + 1))) return made;
    }
    catch (...)
    {
        why = base::whatWasThrown();
    }
    throw base::InputError(name + ": " + why);
}

} // namespace midair::bridge
