#pragma once

#include <osgMidair/ArrayDriver>

#include <functional>
#include <memory>
#include <string>

namespace midair::bridge
{

/// Makes a driver, which is then opened; null counts as a failure to open.
using ArrayDriverFactory = std::function<std::shared_ptr<ArrayDriver>()>;

/// Registers \a scheme, 1 .. 32 small letters, for the rest of the program. Returns false, with the
/// reason in \a error, if it is malformed or taken. Any thread.
bool registerDriver(const std::string& scheme, ArrayDriverFactory make, std::string& error);

} // namespace midair::bridge
