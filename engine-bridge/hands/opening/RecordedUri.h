#pragma once

#include <optional>
#include <string>

namespace midair::bridge
{

/// URI of a recording of hands: "recorded:FILE" is played once, "recorded:FILE?loop" is repeated.
struct RecordedUri
{
    std::string file;
    bool loops = false;

    /// Returns none if \a uri is another kind of hand source.
    static std::optional<RecordedUri> parse(const std::string& uri);
    std::string text() const;
};

} // namespace midair::bridge
