// In the place of the C interface where it is left out: what libmidair says of itself to any
// program.

#include "engine-bridge/c/midair.h"

uint32_t midair_version(void)
{
    return MIDAIR_VERSION;
}
