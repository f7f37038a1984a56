#pragma once

#include "plugin/settings/ForTests.h"

#include <optional>
#include <string>

namespace osgMidair
{

/// URI of a recording of hands: "recorded:FILE" is played once, "recorded:FILE?loop" is repeated.
struct OSGMIDAIR_FOR_TESTS RecordedUri
{
    std::string file;
    bool loops = false;

    /// Returns none if \a uri is another kind of hand source.
    static std::optional<RecordedUri> parse(const std::string& uri);
    std::string text() const;
};

} // namespace osgMidair
