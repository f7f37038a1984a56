// Replaces the C interface in builds without it: libmidair reports this to its callers.

#include "engine-bridge/c/midair.h"

uint32_t midair_version(void)
{
    return MIDAIR_VERSION;
}
