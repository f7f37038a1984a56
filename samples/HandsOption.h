#pragma once

#include <string>

namespace midair::samples
{

inline constexpr char kRecorded[] = "recorded:"; ///< before the file's name in a source of hands

/// Returns the source of hands that \a text names on a command line: a recording's file, FILE.csv,
/// is one that repeats, "recorded:FILE.csv?loop"; all else stays as it is.
inline std::string handsOf(const std::string& text)
{
    const std::string ending = ".csv";
    const bool isFile = text.size() > ending.size() && text.find(':') == std::string::npos &&
                        text.compare(text.size() - ending.size(), ending.size(), ending) == 0;
    return isFile ? kRecorded + text + "?loop" : text;
}

/// Returns true if the source of hands \a hands is a recording.
inline bool isRecording(const std::string& hands)
{
    return hands.rfind(kRecorded, 0) == 0;
}

} // namespace midair::samples
