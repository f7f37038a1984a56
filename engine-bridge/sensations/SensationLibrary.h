#pragma once

#include "engine-bridge/HapticObject.h"
#include "haptics/base/threads/Mutex.h"

#include <osgMidair/ObjectSettings>

#include <cstdint>
#include <map>
#include <memory>
#include <string>

namespace midair::bridge
{

/// A sensation of an object, and why it isn't felt as meant.
struct MadeSensation
{
    SensationProperties properties;
    std::string problem; ///< empty: none
};

/// Reads each sensation once: classics by their text, files by path and time of the last change,
/// texts of files as they are. Any thread.
class SensationLibrary
{
public:
    /// Returns the pattern of \a text: a classic, a path, or a pattern's own text, which begins
    /// with "{". Null, with the reason in \a problem, if it can't be read.
    std::shared_ptr<const haptics::Sensation> get(const std::string& text, std::string& problem);

private:
    /// A text that was read.
    struct Read
    {
        std::shared_ptr<const haptics::Sensation> pattern;
        std::string problem;
        std::int64_t changed = 0; ///< time of the file's last change; 0: no file
        std::uint64_t used = 0;
    };
    static constexpr std::size_t kMost = 256; ///< kept; the one that was used longest ago goes

    base::Mutex _mutex;
    std::map<std::string, Read> _read MIDAIR_GUARDED_BY(_mutex);
    std::uint64_t _uses MIDAIR_GUARDED_BY(_mutex) = 0;
};

/// Returns the library of the program.
SensationLibrary& sensationLibrary();

/// Returns the sensation of \a settings. Parameters that the pattern doesn't know are a problem,
/// the others are set all the same.
MadeSensation sensationOf(const ObjectSettings& settings);

} // namespace midair::bridge
