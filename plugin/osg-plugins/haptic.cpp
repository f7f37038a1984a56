// What OSG loads where a file's name ends with .haptic: osgdb_haptic.

#include <osgMidair/FileFormats>

namespace
{

[[maybe_unused]] const bool kIsRegistered = (osgMidair::registerLoader(), true);

} // namespace
