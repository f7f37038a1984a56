#pragma once

#include "device/ArrayDevice.h"

#include <map>
#include <set>
#include <string>

namespace midair::device
{

constexpr std::size_t kMostUriCharacters = 4096; ///< in one URI, and in a list of them
constexpr int kMostDevices = 64;                 ///< in one list

/// Parses the URI of a device or another external resource: `scheme:path?key=value&key=value`. Each
/// device takes the parameters that it knows, then calls rejectUnknown(), so that a misspelt one is
/// an error.
class DeviceUri
{
public:
    /// Throws DeviceError if \a text is too long, has no scheme, or has a parameter without value
    /// or twice. \a thing is its name in error messages.
    explicit DeviceUri(const std::string& text, const std::string& thing = "device");

    const std::string& text() const { return _text; }
    const std::string& scheme() const { return _scheme; }
    const std::string& path() const
    {
        return _path;
    } ///< between the colon and the question mark; may be empty

    bool has(const std::string& key) const { return _parameters.count(key) != 0; }
    /// Returns the value of parameter \a key without taking it; empty if missing.
    std::string value(const std::string& key) const;
    /// Takes the value of parameter \a key, or \a fallback if missing.
    std::string takeText(const std::string& key, const std::string& fallback);
    /// A number in [low, high]; throws DeviceError that names the range.
    double takeNumber(const std::string& key, double fallback, double low, double high);
    /// Seconds in [0, 1e6], written with a unit: `2s`, `100ms`, `20us`; throws DeviceError.
    double takeSeconds(const std::string& key, double fallback_s);
    bool takeFlag(const std::string& key, bool fallback); ///< 0, 1, no, yes, false, true

    /// Takes all remaining parameters, for a device that checks them itself.
    std::map<std::string, std::string> takeRest();

    /// Throws DeviceError for a parameter that was not taken; the message lists the known ones.
    void rejectUnknown() const;
    /// Throws DeviceError if the path is empty; \a what names the expected path ("a file").
    void requirePath(const std::string& what) const;
    void rejectPath() const; ///< throws DeviceError if there is a path

    /// Returns a DeviceError whose text starts with the URI.
    DeviceError error(const std::string& what) const;

private:
    std::string take(const std::string& key);

    std::string _thing; ///< "device", for messages
    std::string _text;
    std::string _scheme;
    std::string _path;
    std::map<std::string, std::string> _parameters;
    std::set<std::string> _known; ///< parameters that takers asked for
};

} // namespace midair::device
