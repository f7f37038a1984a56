#pragma once

#include <string>

namespace osgMidair
{

/// Lets another process (midair-check, where it is installed beside the kit) read \a file with
/// OSG's \a options, which may end it, and returns why this one should not; empty: it may.
std::string whyNotToRead(const std::string& file, const std::string& options);

} // namespace osgMidair
