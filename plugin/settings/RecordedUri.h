#pragma once

#include <optional>
#include <string>

namespace osgMidair
{

/// A recording of hands: "recorded:FILE" is played once, "recorded:FILE?loop" again and again.
struct RecordedUri
{
    std::string file;
    bool loops = false;

    /// None: \a uri is another kind of hand source.
    static std::optional<RecordedUri> parse(const std::string& uri);
    std::string text() const;
};

} // namespace osgMidair
