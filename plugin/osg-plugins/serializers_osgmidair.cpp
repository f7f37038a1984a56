// OSG loads this for files with a class of osgMidair: osgdb_serializers_osgmidair.

#include <osgMidair/FileFormats>

namespace
{

[[maybe_unused]] const bool kIsRegistered = (osgMidair::registerSerializers(), true);

} // namespace
