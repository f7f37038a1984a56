#pragma once

#include "haptics/base/threads/Mutex.h"

#include <algorithm>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace midair::bridge
{

/// What an application registered by name, of one kind. From any thread.
template<typename Factory>
class NamedFactories
{
public:
    /// \a kind: "solver", for errors.
    explicit NamedFactories(std::string kind) : _kind(std::move(kind)) {}

    /// Returns false, with the reason in \a error, if \a name has another form than 1 .. 32 small
    /// letters, digits and dashes, is one of \a known, the kit's own, or is there already.
    bool add(const std::string& name,
             Factory make,
             const std::vector<std::string>& known,
             std::string& error)
    {
        const bool isName =
            !name.empty() && name.size() <= kMostLetters &&
            name.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789-") == std::string::npos;
        if (!isName)
            error = "\"" + name + "\" is no name of a " + _kind +
                    "; it must have 1 to 32 small letters, digits and dashes";
        else if (!make)
            error = "the " + _kind + " \"" + name + "\" has nothing that makes it";
        else
        {
            const base::Lock lock(_mutex);
            const bool isKnown = std::find(known.begin(), known.end(), name) != known.end();
            if (!isKnown && _makers.emplace(name, std::move(make)).second) return true;
            error = "the name \"" + name + "\" is taken";
        }
        return false;
    }

    /// Returns an empty function if there is none of that name.
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

} // namespace midair::bridge
