#include "haptics/base/threads/Punctual.h"

#include <sys/prctl.h>

namespace midair::base
{

void wakePunctually()
{
    prctl(PR_SET_TIMERSLACK, 1UL); // ns; 0 would be the default
}

} // namespace midair::base
