#pragma once

#include <osgMidair/Export>

/// Marks what the tests look into. The installed library doesn't export it, since it is in no
/// public header; the library that the tests link does (midair_kit_for_tests).
#define OSGMIDAIR_FOR_TESTS OSGMIDAIR_EXPORT

/// Marks what stands inside an exported class and is the kit's own.
#define OSGMIDAIR_NO_EXPORT __attribute__((visibility("hidden")))
