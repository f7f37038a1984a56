// OSG loads this for file names ending with .haptic: osgdb_haptic.

#include <osgMidair/FileFormats>

namespace
{

[[maybe_unused]] const bool kIsRegistered = (osgMidair::registerLoader(), true);

} // namespace
